"""The ports: what crosses between solvers, and the calls that every solver answers.

Start here to connect a solver of your own: write a class with the methods of ``Frames``, ``Panel``
or ``Particles``, and a function ``build(plan)`` that makes one from a plan (``ports/plans``).  Each
protocol below shows a complete small solver that runs.

**What crosses.**  Everything that crosses is a list of points with a vector at each (``Motion``,
``Load``), in SI units and in one world frame, so the power through any interface is the sum of
F . v.  Motion runs down (frames -> panels -> particles), load runs up (particles -> panels ->
frames).  Frames tell the ``Pose`` of their bodies besides, for records.

**Signs.**  A ``Load`` is the force that its *giver* exerts on its *receiver*: of the particles on the
surface, of the panel on the frames.  A load that crosses is the mean over the sync interval
(impulse / length), never a sample, so momentum is handed over exactly.

**Order of calls.**  A solver is built from a plan and then asked for ``initial``, once or several
times, before anything else.  After that, ``advance`` carries it over one sync interval after the
other.  All other calls come at sync points and change nothing, ``restore`` excepted.  ``close`` comes
last, also after a failure.

**Going back.**  Some coupling schemes repeat an interval.  They take a solver back to its start by
``save`` and ``restore`` (``Restorable``), so every solver must have both; ``ports/state.py`` makes
them one line each.

**Failures.**  A solver that cannot go on raises ``SolverFailed`` (``ports/failures.py``) with the
reason; records refuse wrong shapes and values that are not finite by ``BrokenRecord``.
"""

from __future__ import annotations

from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import Frames, Scheduled
from orchestrator.ports.interface_records import (
    Account,
    AngularAccount,
    Array,
    BrokenRecord,
    ContactTangent,
    HermitePath,
    Indices,
    Inertia,
    InterfaceData,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    Pose,
    check_point_count,
)
from orchestrator.ports.interpolation import Interpolation
from orchestrator.ports.panel import Following, Inert, MeshedPanel, Panel
from orchestrator.ports.particle_records import Crossings, Overlaps, ParticleSnapshot, Removed, sort_removed
from orchestrator.ports.particles import Particles, Predicting, Wearing
from orchestrator.ports.state import Restorable, Saved
