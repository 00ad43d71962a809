"""The material of an instance document, exactly: what temperatures depend on."""

from fractions import Fraction
from typing import Any, NamedTuple

from cutgap.formulations.certificate.reading import fields, number, require

FIGURES = "conductivity_w_per_m_k specific_heat_j_per_kg_k density_kg_per_m3 thickness_mm power_w"


class Sheet(NamedTuple):
    """Conductivity in W/(m K), heat capacity in J/(m^3 K), thickness in m, power in W, ambient in deg C."""

    conductivity: Fraction
    capacity: Fraction
    thickness: Fraction
    power: Fraction
    ambient: Fraction


def sheet_of(value: Any) -> Sheet | None:
    """Return the material of a document; ``None`` where it has none."""
    if value is None:
        return None
    table = fields(value, "material", f"name {FIGURES}", "ambient_c")
    conductivity, heat, density, thickness, power = (
        number(table[name], f"material.{name}", least=0) for name in FIGURES.split()
    )
    require(min(conductivity, heat, density, thickness, power) > 0, "material: figures must be above 0")
    ambient = number(table.get("ambient_c", 20), "material.ambient_c")
    return Sheet(conductivity, heat * density, thickness / 1000, power, ambient)
