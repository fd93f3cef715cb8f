"""The coupled machine against one Exudyn system of frames and cables (``one_exudyn_model.py``).

Panels stay taut, as slack ones snap through and no two models stay together; and they are soft
rubber at half a per cent of stretch, as the cables' law is linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from orchestrator.ports import Array
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.one_exudyn_model import solved
from tests.coupled.screen import EMPTY

pytestmark = [pytest.mark.solver, pytest.mark.slow]
SPEED_rad_per_s, INTERVAL_s, COUNT = 100.0, 2e-4, 2000
SETTINGS = [
    "screen.inclination_deg=0",
    "gravity_m_per_s2=[2.54, 0.0, -9.476]",  # the deck's slope
    "screen.exciters.shaft.mass_moment_kg_m=0.01",
    f"screen.exciters.shaft.speed_rad_per_s={SPEED_rad_per_s}",
    "screen.exciters.shaft.run_up_s=0.05",
    "screen.bushings.isolation.damping_N_s_per_m=[150.0, 150.0, 150.0]",  # settles by e^-7
    "screen.panels.deck.tension_m=0.00075",
    "materials.PU.hyperelastic.c10_Pa=3.5e6",
    "materials.PU.hyperelastic.c01_Pa=0",
    "materials.PU.hyperelastic.maxwell=[{ratio=1.0, relaxation_s=2e-4}]",  # viscous below 1 kHz
    f"coupling.sync_interval_s={INTERVAL_s}",
    "panel.solver=strip",
    "panel.cells=[40, 1]",
    "panel.surface_cells=[40, 2]",
    "frames.solver=exudyn",
]


@dataclass(frozen=True)
class Amplitudes:
    """Complex, at the excitation's frequency, along x and z (2,) each: frames' centres by name,
    and the panels' middles against the mean of the frames."""

    frames_m: dict[str, Array]
    middles_m: list[Array]

    @property
    def stroke_m(self) -> complex:
        """Stroke along the deck."""
        return complex((self.frames_m["driven"] - self.frames_m["driving"])[0])


def amplitude(time_s: Array, moved_m: Array) -> Array:
    """Return the amplitude by least squares over the last four cycles."""
    last = time_s > time_s[-1] - 4 * 2 * np.pi / SPEED_rad_per_s
    turned = SPEED_rad_per_s * time_s[last]
    harmonic = np.column_stack([np.cos(turned), np.sin(turned), np.ones(len(turned))])
    cosine, sine, _ = np.linalg.lstsq(harmonic, moved_m[last], rcond=None)[0]
    return np.asarray(cosine - 1j * sine)


def amplitudes(time_s: Array, frames_m: dict[str, Array], middles_m: list[Array]) -> Amplitudes:
    frames = {name: amplitude(time_s, moved_m) for name, moved_m in frames_m.items()}
    mean = (frames["driving"] + frames["driven"]) / 2
    return Amplitudes(frames, [amplitude(time_s, moved_m) - mean for moved_m in middles_m])


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[Amplitudes, Amplitudes]:
    """Amplitudes of the coupled run, and of the one system."""
    loaded = load_case(tmp_path_factory.mktemp("one"), EMPTY, SETTINGS)
    model = solved(loaded.case, COUNT * INTERVAL_s, INTERVAL_s)
    with opened(loaded) as run:
        middles = [panel.centre_line[len(panel.centre_line) // 2] for panel in run.machine.panels]
        states, poses = [], []
        for _ in range(COUNT):
            states.append(run.advance(1))
            poses.append(run.machine.members.frames.pose())
    time_s = INTERVAL_s * np.arange(1, COUNT + 1)
    frames_m = np.array([pose.position_m for pose in poses])[:, :, [0, 2]]
    surface_m = np.array([state.panel.surface.position_m for state in states])[:, :, [0, 2]]
    coupled = amplitudes(
        time_s,
        {name: frames_m[:, number] for number, name in enumerate(run.machine.frames)},
        [surface_m[:, point] for point in middles],
    )
    return coupled, amplitudes(model.time_s, model.frames_m, model.middles_m)


def off(actual: Array | complex, expected: Array | complex) -> float:
    return float(np.linalg.norm(np.subtract(actual, expected)) / np.linalg.norm(expected))


def test_frames_move_alike(both: tuple[Amplitudes, Amplitudes]) -> None:
    """Size and phase agree within 1 %: the panels' law is 1 % softer (1 - strain of the neo-Hookean bar,
    twice for its tangent) and they are half of what is between the frames."""
    coupled, model = both
    for name, moved_m in model.frames_m.items():
        assert off(coupled.frames_m[name], moved_m) < 0.01


def test_the_stroke_is_the_same(both: tuple[Amplitudes, Amplitudes]) -> None:
    """2 %: panels are 0.8 of the stiffness between the frames, 1 % softer, and the excitation is
    at 0.6 of the frames' relative frequency, which enlarges that by 1 / (1 - 0.6^2)."""
    coupled, model = both
    assert abs(model.stroke_m) > 4e-4
    assert off(coupled.stroke_m, model.stroke_m) < 0.02


def test_panels_bend_alike(both: tuple[Amplitudes, Amplitudes]) -> None:
    """The middle's own deflection, 0.2 mm, within 3 %: 1.6 % of the strip's cells (6.6 % with 20
    of them, whose bending layer at the clamps is coarser) and the softer law."""
    coupled, model = both
    for found_m, expected_m in zip(coupled.middles_m, model.middles_m, strict=True):
        assert abs(expected_m[1]) > 2e-4
        assert off(found_m[1], expected_m[1]) < 0.03
