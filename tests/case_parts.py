"""What many tests' cases are made of, as TOML."""

from __future__ import annotations


def polyurethane(*branches: tuple[float, float]) -> str:
    """The panels' material "PU"; damped by ``branches`` of (ratio, relaxation time in s)."""
    rows = ", ".join(f"{{ ratio = {ratio}, relaxation_s = {time_s} }}" for ratio, time_s in branches)
    return f"""
[materials.PU]
density_kg_per_m3 = 1150.0
[materials.PU.hyperelastic]
c10_Pa = 0.7e6
c01_Pa = 2.8e6
bulk_modulus_Pa = 2.0e9
maxwell = [{rows}]
"""


def grains(name: str, density_kg_per_m3: float, youngs_modulus_Pa: float) -> str:
    """A material of particles, with Poisson's ratio 0.3."""
    return f"""
[materials.{name}]
density_kg_per_m3 = {density_kg_per_m3}
youngs_modulus_Pa = {youngs_modulus_Pa}
poisson_ratio = 0.3
"""


def contact(one: str, other: str, restitution: float, sliding: float, rolling: float = 0.0) -> str:
    """Between two materials; ``sliding`` and ``rolling`` friction."""
    return f"""
[[contacts]]
between = ["{one}", "{other}"]
restitution = {restitution}
sliding_friction = {sliding}
rolling_friction = {rolling}
"""
