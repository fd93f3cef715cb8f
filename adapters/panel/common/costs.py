"""What panels' costs have in common.

Costs are processor time on one core of a 2-core AMD EPYC machine that was busy with other work,
measured on drafts of shipped cases; ``python -m tools.cost_series`` measures predicted over taken.
"""

from __future__ import annotations

DOLFINX_S = 0.5
"""Importing DOLFINx."""
