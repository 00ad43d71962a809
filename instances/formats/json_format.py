"""Versioned JSON for instances and plans: the format that holds everything, bit for bit.

Contours and heads are named by id. Floats are written in the shortest form that reads back as the same
double. The schemas ``instance.schema.json`` and ``plan.schema.json`` lie next to this module.
"""

import json
from dataclasses import asdict
from typing import Any

from cutgap.instances.arrays import Floats, frozen_array
from cutgap.instances.evaluate import require_known
from cutgap.instances.formats.json_models import (
    ContourModel,
    EllipsoidModel,
    InstanceModel,
    LinkModel,
    PlanModel,
    VisitModel,
)
from cutgap.instances.formats.json_text import fit_format, load_json, parse_json
from cutgap.instances.formats.options import MachineOptions
from cutgap.instances.instance import Contour, Head, Instance, Machine, Material
from cutgap.instances.plan import Link, Plan, Visit
from cutgap.instances.region import Ellipsoid

INSTANCE_FORMAT = "cutgap-instance"
PLAN_FORMAT = "cutgap-plan"
VERSION = 1


def parse_instance(text: str, name: str, options: MachineOptions) -> Instance:
    """Return the instance in a JSON text; given options replace the file's homes and figures.

    Parameters
    ----------
    name
        Not used: the text carries its own name.

    Raises
    ------
    ValueError
        Naming field path and value, when the text is not a valid instance.
    """
    return parse_document(load_json(text), options)


def parse_document(document: Any, options: MachineOptions) -> Instance:
    """Return the instance in the content of a JSON file; errors as for ``parse_instance``."""
    model = fit_format(document, InstanceModel, INSTANCE_FORMAT)
    if options.homes and model.matrix is not None:
        raise ValueError("matrix: holds no lengths to other homes; leave --home out")
    heads = tuple(Head(head.id, _points(head.home)) for head in model.heads)
    positions = {contour.id: index for index, contour in enumerate(model.contours)}
    pairs = []
    for number, (before, after) in enumerate(model.precedence):
        for contour in (before, after):
            if contour not in positions:
                raise ValueError(f"precedence[{number}]: no contour has the id {contour[:40]!r}")
        pairs.append((positions[before], positions[after]))
    return Instance(
        name=model.name,
        contours=tuple(_contour(contour) for contour in model.contours),
        heads=options.heads() if options.homes else heads,
        machine=options.machine(Machine(**model.machine.model_dump())),
        precedence=tuple(pairs),
        matrix=_matrix(model.matrix),
        material=None if model.material is None else Material(**model.material.model_dump()),
        located=model.located,
    )


def format_instance(instance: Instance) -> str:
    """Return an instance as JSON text, one contour a line."""
    ids = [contour.id for contour in instance.contours]
    document: dict[str, Any] = {
        "format": INSTANCE_FORMAT,
        "version": VERSION,
        "name": instance.name,
        "machine": asdict(instance.machine),
        "heads": [_head_fields(head) for head in instance.heads],
        "contours": [_contour_fields(contour) for contour in instance.contours],
    }
    if instance.precedence:
        document["precedence"] = [[ids[before], ids[after]] for before, after in instance.precedence]
    if instance.matrix is not None:
        document["matrix"] = instance.matrix.tolist()
    if instance.material is not None:
        document["material"] = asdict(instance.material)
    if not instance.located:
        document["located"] = False
    return _layout(document)


def parse_plan(text: str, instance: Instance) -> Plan:
    """Return the plan in a JSON text; whether it is allowed is for ``check`` to say.

    Raises
    ------
    ValueError
        When the text is not a valid plan, names contours, entry points or heads that the instance does
        not have, or does not name each head once.
    """
    model = parse_json(text, PlanModel, PLAN_FORMAT)
    positions = {contour.id: index for index, contour in enumerate(instance.contours)}
    heads = [head.id for head in instance.heads]
    tours: dict[str, tuple[Visit, ...]] = {}
    for number, tour in enumerate(model.tours):
        place = f"tours[{number}]"
        if tour.head not in heads:
            names = ", ".join(heads)
            raise ValueError(f"{place}.head: no head {tour.head[:40]!r}; the instance has {names:.200}")
        if tour.head in tours:
            raise ValueError(f"{place}.head: {tour.head[:40]!r} has a tour already; give one a head")
        tours[tour.head] = tuple(
            _visit(instance, positions, visit, f"{place}.visits[{step}]")
            for step, visit in enumerate(tour.visits)
        )
    for head in heads:
        if head not in tours:
            raise ValueError(f"tours: none for head {head!r}; give it one, with no visits if it has no work")
    links = (_link(instance, positions, link, f"links[{number}]") for number, link in enumerate(model.links))
    return Plan(tuple(tours[head] for head in heads), tuple(links))


def _visit(instance: Instance, positions: dict[str, int], visit: VisitModel, place: str) -> Visit:
    contour = _contour_at(instance, positions, visit.contour, visit.entry, place, "")
    if visit.point is None:
        return Visit(contour, visit.entry)
    x, y, z = visit.point
    return Visit(contour, visit.entry, (x, y, z))


def _link(instance: Instance, positions: dict[str, int], link: LinkModel, place: str) -> Link:
    one = _contour_at(instance, positions, link.contour, link.entry, place, "")
    other = _contour_at(instance, positions, link.to_contour, link.to_entry, place, "to_")
    if one == other:
        raise ValueError(f"{place}.to_contour: {link.to_contour[:40]!r} again; a link joins two contours")
    return Link(one, link.entry, other, link.to_entry, link.passes)


def _contour_at(
    instance: Instance, positions: dict[str, int], name: str, entry: int, place: str, prefix: str
) -> int:
    """Return the index of a contour that is named with an entry point."""
    if name not in positions:
        raise ValueError(f"{place}.{prefix}contour: no contour has the id {name[:40]!r}")
    count = len(instance.contours[positions[name]].entry_points)
    if entry >= count:
        raise ValueError(f"{place}.{prefix}entry: expected less than {count}, got {entry}")
    return positions[name]


def format_plan(plan: Plan, instance: Instance) -> str:
    """Return a plan as JSON text; raises ``ValueError`` when it names what the instance does not have."""
    require_known(instance, plan)
    tours = [
        {
            "head": head.id,
            "visits": [_visit_fields(instance, visit) for visit in tour],
        }
        for head, tour in zip(instance.heads, plan.tours, strict=True)
    ]
    document = {"format": PLAN_FORMAT, "version": VERSION, "instance": instance.name, "tours": tours}
    if plan.links:
        document["links"] = [_link_fields(instance, link) for link in plan.links]
    return _layout(document)


def _link_fields(instance: Instance, link: Link) -> dict[str, Any]:
    ends = (instance.contours[link.contour].id, instance.contours[link.to_contour].id)
    return {**link._asdict(), "contour": ends[0], "to_contour": ends[1]}


def _visit_fields(instance: Instance, visit: Visit) -> dict[str, Any]:
    fields: dict[str, Any] = {"contour": instance.contours[visit.contour].id, "entry": visit.entry}
    return fields if visit.point is None else fields | {"point": list(visit.point)}


def _points(values: list[float] | list[list[float]] | None) -> Floats | None:
    return None if values is None else frozen_array(values, "points")


def _matrix(rows: list[list[float]] | None) -> Floats | None:
    """Refuse ragged rows here, where the row can be named."""
    if rows is None:
        return None
    for number, row in enumerate(rows):
        if len(row) != len(rows):
            raise ValueError(
                f"matrix[{number}]: expected {len(rows)} numbers as there are rows, got {len(row)}"
            )
    return frozen_array(rows, "matrix").reshape(len(rows), len(rows))


def _contour(model: ContourModel) -> Contour:
    points = frozen_array(model.entry_points, "entry_points")
    curve = _points(model.geometry)
    return Contour(model.id, points, model.perimeter, model.part, model.ring, curve, _ellipsoid(model.region))


def _ellipsoid(model: EllipsoidModel | None) -> Ellipsoid | None:
    if model is None:
        return None
    return Ellipsoid(frozen_array(model.centre, "centre"), frozen_array(model.axes, "axes"))


def _contour_fields(contour: Contour) -> dict[str, Any]:
    fields: dict[str, Any] = {
        "id": contour.id,
        "entry_points": contour.entry_points.tolist(),
        "perimeter": contour.perimeter,
    }
    if contour.part is not None:
        fields["part"] = contour.part
    if contour.ring != "hole":
        fields["ring"] = contour.ring
    if contour.geometry is not None:
        fields["geometry"] = contour.geometry.tolist()
    if contour.region is not None:
        region = contour.region
        fields["region"] = {"centre": region.centre.tolist(), "axes": region.axes.tolist()}
    return fields


def _head_fields(head: Head) -> dict[str, Any]:
    return {"id": head.id} if head.home is None else {"id": head.id, "home": head.home.tolist()}


def _layout(document: dict[str, Any]) -> str:
    """Return JSON with one top-level field, or one entry of a list, a line: short and easy to compare."""
    fields = []
    for key, value in document.items():
        text = _dump(value)
        if isinstance(value, list) and value:
            text = "[\n" + ",\n".join(f"    {_dump(entry)}" for entry in value) + "\n  ]"
        fields.append(f"  {_dump(key)}: {text}")
    return "{\n" + ",\n".join(fields) + "\n}\n"


def _dump(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
