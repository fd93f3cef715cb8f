"""Energy created, from what crosses alone, against what the members have."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import as_arrays, like
from orchestrator.run.monitor.interface_work import (
    Balance,
    ClampWork,
    ContactWork,
    ExchangedEnergy,
    interface_data,
)
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import CASE
from tests.coupling.line import FreeFrame, HungPlate, Sphere
from tests.monitor.machines import on_a_line
from tests.saved_states import differences

ALL = slice(None)


def energy_J(sphere: Sphere, plate: HungPlate, frame: FreeFrame) -> float:
    """Return the energy of the three, when the sphere has let go."""
    hanger_m = plate.x - plate.clamp.position_m[0, 0]
    return 0.5 * (
        sphere.mass_kg * sphere.v**2
        + plate.mass_kg * plate.v**2
        + frame.mass_kg * frame.v**2
        + plate.stiffness_N_per_m * hanger_m**2
    )


@pytest.mark.parametrize(
    ("scheme", "per_contact", "within"),
    # particles-first creates so little (1e-3 and 3e-4 J of 0.5 J) that the first touch counts
    [
        ("particles-first", 5, 0.1),
        ("particles-first", 10, 0.2),
        ("serial-staggered", 10, 0.02),
        ("serial-staggered", 20, 0.01),
    ],
)
def test_an_elastic_impact_has_as_much_more_energy_as_was_created(
    scheme: str, per_contact: int, within: float
) -> None:
    length_s = np.pi * np.sqrt(4 / 5) / per_contact
    sphere, plate = Sphere(1.0, 1.0, 0.3 * length_s, -1.0), HungPlate(4.0, 0.0)
    frame = FreeFrame(1.0)
    machine = on_a_line(sphere, plate, frame, scheme)
    state = initial_state(machine.solvers)
    work, before_J = ContactWork(state, ALL), energy_J(sphere, plate, frame)
    for index in range(3 * per_contact):
        state = machine.scheme.advance(machine.solvers, Interval(index, length_s), state)
        work.add([interface_data(machine.members, length_s)])
    gained_J = energy_J(sphere, plate, frame) - before_J
    assert gained_J > 1e-4
    assert work.balance.created_J == pytest.approx(gained_J, rel=within)


@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered"])
def test_a_frame_on_a_panel_too(scheme: str) -> None:
    """Swinging against a plate that hangs on it, for a tenth of a period, over which the spring's
    energy counts."""
    sphere, plate, frame = Sphere(1.0, 1.0, 9.0, 0.0), HungPlate(2.0, 3.0, 200), FreeFrame(5.0)
    plate.x = 0.1
    machine = on_a_line(sphere, plate, frame, scheme)
    state = initial_state(machine.solvers)
    work, before_J = ClampWork(state, ALL), energy_J(sphere, plate, frame)
    for index in range(400):
        state = machine.scheme.advance(machine.solvers, Interval(index, 0.1), state)
        work.add([interface_data(machine.members, 0.1)])
    gained_J = energy_J(sphere, plate, frame) - before_J
    assert abs(gained_J) > 1e-6
    assert work.balance.created_J == pytest.approx(gained_J, rel=0.1, abs=2e-6)


CHEAP = ["panel.solver=strip", "panel.cells=[8,1]", "frames.solver=two-mass"]


@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered", "robin", "aitken"])
def test_it_is_what_the_ledger_says(tmp_path: Path, scheme: str) -> None:
    """A bed on two panels between frames; the ledger asks the solvers."""
    sets: Sequence[str] = [*CHEAP, "particles.solver=spheres", f"coupling.scheme={scheme}"]
    with opened(load_case(tmp_path, CASE, sets)) as run:
        contacts, clamps = ContactWork(run.state, ALL), ClampWork(run.state, ALL)
        for _ in range(200):
            run.advance(1)
            interval = interface_data(run.machine.members, run.interval_s)
            contacts.add([interval])
            clamps.add([interval])
        terms_J = run.energy_J("created")
    # off by 9e-5, 9e-5, 3e-7 and 1e-8 of what went through contacts, and by 5e-7 at most at clamps
    for work, interface, off in ((contacts, "particles-panel", 2e-4), (clamps, "panel-frames", 1e-6)):
        balance = work.balance
        ledger_J = terms_J[f"created.{interface}"]
        assert balance.created_J == pytest.approx(ledger_J, rel=0, abs=off * balance.through_J)


def test_how_many_intervals_are_booked_at_once_makes_no_difference(tmp_path: Path) -> None:
    """One by one, all together, and with a checkpoint after the third; the first points count."""
    sets: Sequence[str] = [*CHEAP, "particles.solver=spheres", "coupling.scheme=serial-staggered"]
    with opened(load_case(tmp_path, CASE, sets)) as run:
        start, intervals = run.state, []
        for _ in range(120):
            run.advance(1)
            intervals.append(interface_data(run.machine.members, run.interval_s))
    for kind, points in ((ContactWork, slice(40)), (ClampWork, slice(20))):
        one_by_one, together, resumed, other = (kind(start, points) for _ in range(4))
        for interval in intervals:
            one_by_one.add([interval])
        together.add(intervals)
        other.add(intervals[:3])
        resumed.restore(other.save())
        resumed.add(intervals[3:])
        for work in (one_by_one, together, resumed):
            work.begin_anew()
        assert one_by_one.balance.created_J != 0.0
        assert one_by_one.balance.through_J > 0.0
        for other in (together, resumed):
            assert differences(one_by_one.save(), other.save()) == []


def test_a_share_of_what_went_through() -> None:
    balance = Balance()
    for _ in range(200):
        balance.add(0.2, 1.0)
    recent = (1 - (19 / 20) ** 200) * 20  # intervals
    assert balance.recent_share() == pytest.approx((0.2 * recent - 1) / recent)
    for _ in range(50):
        balance.add(-0.5, 1.0)
    assert balance.recent_share() > 0.3  # destroyed is as bad as created
    balance.begin_anew()
    assert balance.recent_share() == 0.0
    balance.begin_anew(0.3)
    balance.add(-0.3, 0.01)  # taken back
    assert balance.recent_share() == 0.0


def test_what_went_through_is_the_range_of_the_work() -> None:
    """The work is given for good, or to and fro; only the floor is left where nothing moves."""
    size_N = 3.0 + 4.0
    given, back, rest = ExchangedEnergy(), ExchangedEnergy(), ExchangedEnergy()
    for _ in range(100):
        given.add(0.5, 0.0, 1e-4)
        for work_J in (2.0, -2.0):
            back.add(work_J, 0.0, 1e-4)
        rest.add(1e-24, size_N, 1e-4)
    assert given.scale_J == pytest.approx(50.0)
    assert back.scale_J == pytest.approx(2.0)
    assert rest.scale_J == pytest.approx(7.0 * 1e-3 * 1e-4)
    saved = like(ExchangedEnergy(), as_arrays(back))
    saved.add(-3.0, 0.0, 1e-4)
    assert saved.scale_J == pytest.approx(5.0)


def test_walls_count_in_what_went_through() -> None:
    """A sphere bounces on a plate that does not count among the panels: a wall."""
    length_s = np.pi * np.sqrt(4 / 5) / 20
    sphere, plate = Sphere(1.0, 1.0, 0.3 * length_s, -1.0), HungPlate(4.0, 0.0)
    machine = on_a_line(sphere, plate, FreeFrame(1.0), "particles-first")
    state = initial_state(machine.solvers)
    work = ContactWork(state, slice(0, 0))
    for index in range(60):
        state = machine.scheme.advance(machine.solvers, Interval(index, length_s), state)
        work.add([interface_data(machine.members, length_s)])
    given_J = 0.5 * plate.mass_kg * plate.v**2
    assert work.exchange.scale_J == pytest.approx(given_J, rel=1e-3)
    assert work.balance.through_J == 0.0


def test_what_comes_back_in_the_next_interval_was_not_created() -> None:
    """The first touch of an impact takes all its work back in the next intervals."""
    balance = Balance()
    balance.add(-0.5, 1.0)
    assert balance.recent_share() == 0.0
    balance.add(0.45, 1.0)
    assert balance.recent_share() == 0.0
