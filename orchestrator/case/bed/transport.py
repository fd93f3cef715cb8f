"""How long material stays on the deck: an assumption, made before a run."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case

TRANSPORT_M_S = 0.34
"""Speed of the material: 40 kg/s in a layer of 175 mm on 0.8 m, 850 kg/m3 in bulk (Xu et al.,
Minerals 14, 2024, 278).  Thin layers go faster, so that there are fewer particles."""


def stay_s(case: Case, transport_m_per_s: float = TRANSPORT_M_S) -> float:
    """Time on the deck; infinite where nothing leaves."""
    return deck_length_m(case) / transport_m_per_s if case.screen.exits else math.inf


def deck_length_m(case: Case) -> float:
    """From the first panel's upper end to the last one's lower end; 0 without panels."""
    ends_m = [
        panel.rectangle.mounted(np.array([[along_m, 0.0]]))[0]
        for panel in single_panels(case)
        for along_m in (0.0, panel.rectangle.length_m)
    ]
    return float(np.linalg.norm(np.ptp(ends_m, axis=0))) if ends_m else 0.0
