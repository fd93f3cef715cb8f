"""Material that goes astray: particles that get lost, feeds that jam.  Results are kept."""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from orchestrator.output.records import trust
from tests.cases import CASE, case_folder
from tests.runs.outside import flipflow, run_words, summary

SOLVERS = """
[coupling]
sync_interval_s = 2e-4
[frames]
solver = "two-mass"
[panel]
solver = "rigid"
surface_cells = [6, 4]
[particles]
solver = "liggghts"
[output]
interval_s = 0.01
pictures = false
"""
# beside the panel, nothing below
STRAY = """
[bed.particles.stray]
position_m = [-0.3, 0.1, -0.85]
velocity_m_per_s = [0.0, 0.0, -3.0]
sieve_size_m = 0.02
material = "coal"
"""
# below a panel with openings of 10 mm, on its way into the undersize
ESCAPED = """
[screen.panels.deck.apertures]
length_m = 0.01
width_m = 0.01
pitch_along_m = 0.02
pitch_across_m = 0.02
[screen.exits.below]
product = "undersize"
box_m = [[-0.2, -0.2, -0.9], [0.5, 0.4, -0.3]]
[bed.particles.large]
position_m = [0.15, 0.1, -0.25]
velocity_m_per_s = [0.0, 0.0, -2.0]
sieve_size_m = 0.0101
material = "coal"
[bed.particles.small]
position_m = [0.15, 0.05, -0.25]
velocity_m_per_s = [0.0, 0.0, -2.0]
sieve_size_m = 0.0099
material = "coal"
"""
# a chute that pours into a bucket, which is full after some 25 particles
JAM = """
[screen.surfaces.floor]
corner_m = [-0.53, -0.04, -0.02]
edges_m = [[0.06, 0, 0], [0, 0.06, 0]]
frame = "ground"
material = "PU"
[screen.surfaces.front]
corner_m = [-0.53, -0.04, -0.02]
edges_m = [[0.06, 0, 0], [0, 0, 0.1]]
frame = "ground"
material = "PU"
[screen.surfaces.back]
corner_m = [-0.53, 0.02, -0.02]
edges_m = [[0.06, 0, 0], [0, 0, 0.1]]
frame = "ground"
material = "PU"
[screen.surfaces.left]
corner_m = [-0.53, -0.04, -0.02]
edges_m = [[0, 0.06, 0], [0, 0, 0.1]]
frame = "ground"
material = "PU"
[screen.surfaces.right]
corner_m = [-0.47, -0.04, -0.02]
edges_m = [[0, 0.06, 0], [0, 0, 0.1]]
frame = "ground"
material = "PU"
[bed.feeds.chute]
material = "coal"
rate_kg_per_s = 0.4
box_m = [[-0.52, -0.03, 0.0], [-0.48, 0.01, 0.03]]
velocity_m_per_s = [0.0, 0.0, -1.0]
sizes = [{ smallest_m = 0.018, largest_m = 0.020, mass_fraction = 1.0 }]
[monitor]
jam_s = 0.1
"""


def run(folder: Path, extra: str, *sets: str) -> tuple[int, str, Path]:
    text = CASE.replace("duration_s = 0.1", "duration_s = 0.6") + extra + SOLVERS
    case = case_folder(folder / "case", text)
    done = flipflow(*run_words(str(case), folder / "run", sets))
    return done.returncode, done.stderr, folder / "run"


@pytest.mark.process
def test_a_lost_particle_is_warned_of(tmp_path: Path) -> None:
    code, output, folder = run(tmp_path, STRAY, "duration_s=0.1")
    assert code == 0, output
    assert (
        "WARNING: 1 particle left the domain elsewhere than through an exit, of which the case has none: "
        "50 % of the mass that came"
    ) in " ".join(output.split())
    assert (
        "particle 2 (20 mm) is lost: it left the domain at (-0.3, 0.1, -1" in (folder / "run.log").read_text()
    )
    assert summary(folder)["material"]["lost"]["number"] == 1


@pytest.mark.process
def test_a_lost_particle_stops_the_run_where_the_case_wants_it(tmp_path: Path) -> None:
    code, output, folder = run(tmp_path, STRAY, "duration_s=0.1", "monitor.lost_particles=stop")
    assert code == 4
    assert "particle 2 (20 mm) is lost: it left the domain at (-0.3, 0.1, -1" in output
    figures = summary(folder)
    assert figures["status"] == "failed"
    assert figures["material"]["lost"]["number"] == 1
    with h5py.File(folder / "history.h5") as history:
        assert history["removed/exit"][:].tolist() == [-1]


@pytest.mark.process
def test_a_particle_too_large_for_the_undersize_is_warned_of(tmp_path: Path) -> None:
    """The particle is a third of all that came, so that the run is doubtful, too."""
    code, output, folder = run(tmp_path, ESCAPED, "duration_s=0.1")
    assert code == trust.EXIT_CODES[trust.DOUBTFUL], output
    assert "WARNING: 1 particle too large for any opening came out with the undersize" in output
    material = summary(folder)["material"]
    assert material["escaped"]["number"] == 1
    assert material["exits"]["below"]["number"] == 2


@pytest.mark.process
def test_a_particle_too_large_for_the_undersize_stops_the_run(tmp_path: Path) -> None:
    code, output, folder = run(tmp_path, ESCAPED, "duration_s=0.1", "monitor.escaped_particles=stop")
    assert code == 4
    assert 'particle 2 (10.1 mm) came out through exit "below"' in output
    assert summary(folder)["material"]["escaped"]["number"] == 1


@pytest.mark.process
def test_a_jammed_feed_stops_the_run(tmp_path: Path) -> None:
    code, output, folder = run(tmp_path, JAM)
    assert code == 4, output
    assert 'feed "chute" is jammed: of' in output
    figures = summary(folder)
    feed = figures["material"]["feeds"]["chute"]
    assert feed["fed_kg"] < 0.6 * feed["due_kg"]
    assert 0.1 < figures["simulated_s"] < 0.6
    with h5py.File(folder / "history.h5") as history:
        backlog_kg = history["feeds/chute/due_kg"][:] - history["feeds/chute/fed_kg"][:]
    assert backlog_kg[-1] > backlog_kg[len(backlog_kg) // 2] > 0.0


@pytest.mark.process
def test_a_jammed_feed_may_be_only_warned_of(tmp_path: Path) -> None:
    code, output, folder = run(tmp_path, JAM, "monitor.jammed_feed=warn", "duration_s=0.45")
    assert code == 0, output
    assert (folder / "run.log").read_text().count('feed "chute" is jammed') == 1


SOFT = ("particles.largest_youngs_modulus_Pa=1e4", "bed.particles.ball.velocity_m_per_s=[0,0,-2.3]")
THROUGH = (
    "coupling.sync_interval_s=1e-4",
    *SOFT,
    "duration_s=0.08",
    "output.pictures=false",
    "panel.solver=rigid",
)
SOLVERS_OF_PARTICLES = ["spheres", pytest.param("liggghts", marks=pytest.mark.solver)]


@pytest.mark.process
@pytest.mark.parametrize("solver", SOLVERS_OF_PARTICLES)
def test_a_particle_that_goes_through_a_panel_stops_the_run(tmp_path: Path, solver: str) -> None:
    sets = (*THROUGH, f"particles.solver={solver}")
    done = flipflow(*run_words("ball-on-panel", tmp_path / "run", sets))
    assert done.returncode == 4, done.stderr
    assert "warning: particles are expected to sink into what they meet by 1.9 of" in done.stderr
    assert "stopped by the monitor at t = " in done.stderr
    assert "1 times a particle went through the surface" in done.stderr
    figures = summary(tmp_path / "run")
    assert figures["status"] == "failed"
    crossings = figures["material"]["crossings"]
    assert (crossings["number"], crossings["first_id"]) == (1, 1)
    assert abs(crossings["first_position_m"][2]) < 1e-3
    # within five sync intervals of 1e-4 s
    assert -1e-9 < figures["simulated_s"] - crossings["first_time_s"] < 5.1e-4
    deepest = figures["material"]["deepest_overlaps"]["surface_per_diameter"]
    assert deepest == pytest.approx(0.5, abs=0.02)  # a radius


@pytest.mark.process
@pytest.mark.parametrize("solver", SOLVERS_OF_PARTICLES)
def test_a_run_that_goes_on_after_that_is_doubtful(tmp_path: Path, solver: str) -> None:
    sets = (*THROUGH, f"particles.solver={solver}", "monitor.crossed_surface=warn")
    done = flipflow(*run_words("ball-on-panel", tmp_path / "run", sets))
    assert done.returncode == 5, done.stderr
    assert "do not trust this run: Particles went through the surface 1 times" in done.stderr
    assert "deepest overlap since the start, over the radius: 1" in done.stderr
    figures = summary(tmp_path / "run")
    assert figures["status"] == "doubtful"
    assert figures["material"]["crossings"]["number"] == 1
