"""The JSON file formats as pydantic models; the published JSON Schemas are made from them.

Strict: a number in quotes is no number, unknown fields are refused. The models check shape and type;
what the values mean together is for ``Instance`` to check.
"""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from cutgap.instances.instance import ABSOLUTE_ZERO_C, Metric, Ring

Number = Annotated[float, Field(allow_inf_nan=False)]
# The limit of 0 makes pydantic refuse lone surrogates, which could not be written again.
Text = Annotated[str, Field(min_length=0)]
Name = Annotated[str, Field(min_length=1)]
# A wrong file of millions of entries would otherwise collect millions of errors.
Point3 = Annotated[list[Number], Field(min_length=3, max_length=3), Field(fail_fast=True)]
Point2 = Annotated[list[Number], Field(min_length=2, max_length=2), Field(fail_fast=True)]
Length = Annotated[float, Field(allow_inf_nan=False, ge=0)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0)]


class _Model(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class EllipsoidModel(_Model):
    """All points centre + sum of u_i axes_i with |u| <= 1: a segment, disc, ellipse, ball or ellipsoid."""

    centre: Point3 = Field(description="Centre [x, y, z] in mm.")
    axes: Annotated[list[Point3], Field(fail_fast=True)] = Field(
        min_length=1, max_length=3, description="Half axes [x, y, z] in mm."
    )


class ContourModel(_Model):
    """A closed curve to be cut once."""

    id: Name = Field(description="Unique within the instance.")
    entry_points: Annotated[list[Point3], Field(fail_fast=True)] = Field(
        min_length=1, description="Points [x, y, z] in mm at which cutting may start and then ends."
    )
    perimeter: Length = Field(description="Cut length in mm; 0 is a point to be visited.")
    part: Text | None = Field(default=None, description="Name of the part that the contour bounds.")
    ring: Ring = Field(default="hole", description="hole stands alone; inner or outer ring of its part.")
    geometry: Annotated[list[Point2], Field(fail_fast=True)] | None = Field(
        default=None,
        min_length=3,
        description="Closed polyline of points [x, y] in mm, first point not repeated.",
    )
    region: EllipsoidModel | None = Field(
        default=None, description="What the curve encloses, exactly; with free entries it is entered there."
    )


class HeadModel(_Model):
    """A cutting head."""

    id: Name = Field(description="Unique within the instance.")
    home: Point3 | None = Field(
        default=None, description="Place [x, y, z] in mm where it starts and ends; without, a closed tour."
    )


class MachineModel(_Model):
    """Speeds, time per contour and the metric of rapids."""

    v_jump: Positive = Field(description="Speed of rapids, mm/s.")
    v_cut: Positive = Field(description="Speed of cutting, mm/s.")
    t_aux: Length = Field(description="Auxiliary time per contour, s.")
    metric: Metric = Field(description="Rapid length; matrix takes it from the field matrix.")


class MaterialModel(_Model):
    """Sheet and beam, for temperatures."""

    name: Text
    conductivity_w_per_m_k: Positive
    specific_heat_j_per_kg_k: Positive
    density_kg_per_m3: Positive
    thickness_mm: Positive
    power_w: Positive
    ambient_c: Annotated[Number, Field(ge=ABSOLUTE_ZERO_C)] = 20.0


class InstanceModel(_Model):
    """What is to be cut, and on which machine."""

    format: Literal["cutgap-instance"]
    version: Literal[1]
    name: Text
    machine: MachineModel
    heads: Annotated[list[HeadModel], Field(fail_fast=True)] = Field(
        min_length=1, description="From left to right where there are several."
    )
    contours: Annotated[list[ContourModel], Field(fail_fast=True)]
    precedence: Annotated[
        list[Annotated[list[Name], Field(min_length=2, max_length=2), Field(fail_fast=True)]],
        Field(fail_fast=True),
    ] = Field(default=[], description="Pairs [a, b] of contour ids: a is cut before b.")
    matrix: Annotated[list[Annotated[list[Length], Field(fail_fast=True)]], Field(fail_fast=True)] | None = (
        Field(
            default=None,
            description="Rapid lengths in mm between all nodes: the entry points of the contours in order, "
            "then the homes.",
        )
    )
    material: MaterialModel | None = None
    located: bool = Field(default=True, description="False when the points carry no coordinates.")


class VisitModel(_Model):
    """A contour and where it is pierced: an entry point, or a point of the plan's own."""

    contour: Name = Field(description="Id of the contour.")
    entry: int = Field(default=0, ge=0, description="Number of the entry point, from 0.")
    point: Point3 | None = Field(
        default=None, description="Place [x, y, z] in mm instead of the entry point, with free entries."
    )


class TourModel(_Model):
    """The visits of one head in order."""

    head: Name = Field(description="Id of the head.")
    visits: Annotated[list[VisitModel], Field(fail_fast=True)]


class LinkModel(_Model):
    """A straight cut between entry points of two contours."""

    contour: Name = Field(description="Id of the contour at one end.")
    entry: int = Field(ge=0, description="Number of its entry point, from 0.")
    to_contour: Name = Field(description="Id of the contour at the other end.")
    to_entry: int = Field(ge=0, description="Number of its entry point, from 0.")
    passes: int = Field(default=2, ge=1, le=2, description="How often it is cut.")


class PlanModel(_Model):
    """Which head cuts what, in which order."""

    format: Literal["cutgap-plan"]
    version: Literal[1]
    instance: Text = Field(description="Name of the instance, for people; ids say what is meant.")
    tours: Annotated[list[TourModel], Field(fail_fast=True)] = Field(description="One a head, in any order.")
    links: Annotated[list[LinkModel], Field(fail_fast=True)] = Field(
        default=[], description="Links, with which a visit starts a stroke through all linked contours."
    )


SCHEMAS: dict[str, type[_Model]] = {"instance.schema.json": InstanceModel, "plan.schema.json": PlanModel}
"""File name of each published schema, in this folder, and its model."""


def json_schema(file_name: str) -> dict[str, Any]:
    """Return a published JSON Schema as made from its model."""
    schema = SCHEMAS[file_name].model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def write_schemas(folder: Path = Path(__file__).parent) -> None:
    """Write the published schemas; run it when a model changes."""
    for file_name in SCHEMAS:
        text = json.dumps(json_schema(file_name), indent=2) + "\n"
        (folder / file_name).write_text(text, encoding="utf-8")
