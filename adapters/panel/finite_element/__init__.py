"""Finite elements on DOLFINx: the sheet, the solid, and the stiffness of a panel with openings."""

from __future__ import annotations

from orchestrator.ports.plans import SolverMissing

try:
    import petsc4py

    # before anything else imports PETSc, which would take options, and libraries to load, from
    # .petscrc in the folder that the program is started in, and print pages of its own at signals such as
    # a closed pipe ("flipflow ... | head")
    petsc4py.init(["flipflow", "-skip_petscrc", "-no_signal_handler"])
    import dolfinx  # noqa: F401
except ImportError as missing:
    raise SolverMissing(
        "the panel solvers 'sheet' and 'solid', and a strip with openings, need DOLFINx 0.5 or 0.9 "
        f"(Debian: python3-dolfinx): {missing}"
    ) from missing
