"""The command that times a case part by part.

python -m tools.bench CASE                    compares it with LIGGGHTS alone, the same bed on rigid walls
python -m tools.bench CASE --effects [NAME]   times it without each effect that can be left out, part by part
"""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from orchestrator.case.bed.grains import shapes
from orchestrator.case.tables.case import has_particles
from orchestrator.preflight.judge import load_judged
from tools.bench import coupling, effects


def main() -> None:
    """Read the command line, and print the table of times."""
    parser = argparse.ArgumentParser("python -m tools.bench", description="Time a case part by part.")
    parser.add_argument("case", type=Path)
    parser.add_argument("--level")
    parser.add_argument("--intervals", type=int, default=2000, help="sync intervals to time")
    parser.add_argument(
        "--settling", type=int, default=coupling.BLOCK, help="sync intervals before them, untimed"
    )
    parser.add_argument(
        "--effects", nargs="*", metavar="NAME", help="time the case without each of its effects, or of these"
    )
    parser.add_argument("--set", action="append", default=[], dest="overrides", metavar="KEY=VALUE")
    args = parser.parse_args()
    console = Console(markup=False, width=180)
    if args.effects is not None:
        timed = effects.TimedCase(args.case, args.level, tuple(args.overrides))
        wanted = args.effects or effects.that_can_go(timed)
        if unknown := {*wanted} - {*effects.that_can_go(timed)}:
            parser.error(f"the case has no effects {', '.join(sorted(unknown))} that can be left out")
        console.print(effects.bench(timed, args.intervals, wanted))
    else:
        loaded = load_judged(args.case, args.level, args.overrides)
        if not has_particles(loaded.case):
            parser.error("the case has no particles: there is nothing to compare")
        if any(len(shape.spheres) > 1 for shape in shapes(loaded.case)):
            parser.error("LIGGGHTS alone has no grains of several spheres from memory: take spheres")
        console.print(coupling.bench(loaded, args.intervals, args.settling))


if __name__ == "__main__":
    main()
