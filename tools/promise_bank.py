"""The command that tries the promise "sure to be stable up to ..." on random scenes.

    python -m tools.promise_bank [--scenes 500] [--first 0] [--schemes a,b] [--shares 0.5,1] [--out FOLDER]

A scene is a case drawn with its number as the seed: a panel, taut or slack, of polyurethane or steel,
between still or shaken frames or on bushings, under a heavy lump, a lump among fines of up to 1 : 50, a
falling bed or a bed at rest.  Each scheme runs it at shares of the interval that its stability report
promises, while the monitor only warns.  A run is sound if it comes to its end and nothing speaks against its
coupling.  OUT gets runs.csv, and the case of each run that is not sound.

Exit code 0: of every scheme at every share, at least 99 % of the runs are sound.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import math
import multiprocessing
import random
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import tomli_w

from orchestrator.case.file.errors import CaseError
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.cli.console import find_all_problems
from orchestrator.cli.launch import run
from orchestrator.coupling.ledger import share_created
from orchestrator.output.records.run_folder import SUMMARY
from orchestrator.output.records.trust import LARGEST_SHARE_CREATED
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.stability.report import stability_report

SCHEMES = ("particles-first", "serial-staggered", "robin", "aitken", "quasi-newton")
WARNING = {"created_energy": "warn", "growing_modes": "warn", "deep_overlaps": "warn"}
SOUND, TRIED = ("done", "other doubts"), ("doubtful", "failed", "error", "incomplete")
LEAST_SOUND = 0.99
MOST_INTERVALS, FEWEST_INTERVALS = 8000, 20
MOST_PARTICLE_STEPS = 3e6
LEVEL = 'about = "strips"\nwithout = ["variation-across"]\n[panel]\nsolver = "strip"\n'
SHORTEST_S, DURATION_S = 0.008, 0.04


def random_case(seed: int) -> dict[str, Any]:
    """Return the tables of a random case without its coupling; its duration is about what it needs."""
    draw = random.Random(seed)
    length_m, width_m = draw.uniform(0.12, 0.4), draw.uniform(0.05, 0.25)
    steel = draw.random() < 0.15
    thickness_m = (
        draw.uniform(0.3e-3, 1.2e-3) if steel else math.exp(draw.uniform(math.log(1.5e-3), math.log(8e-3)))
    )
    tension = draw.choice(
        (0.0, draw.uniform(0.002, 0.04), draw.uniform(0.002, 0.04), draw.uniform(-0.03, 0.0))
    )
    if steel:
        tension *= 0.02
    bed, speed_m_per_s, highest_m = _particles(draw, length_m, width_m)
    density_kg_per_m3 = draw.uniform(1200, 4500)
    softened = draw.random() < 0.7
    fall_m_per_s = math.sqrt(speed_m_per_s**2 + 2 * 9.81 * highest_m) + 0.5  # and the panel comes up
    # Hertz's overlap of two equal spheres is 1.2 (density v^2 / E)^(2/5) of the radius: 0.01 to 0.25 of it
    cap_Pa = density_kg_per_m3 * fall_m_per_s**2 * math.exp(draw.uniform(math.log(50), math.log(2e5)))
    pair = {"sliding_friction": draw.uniform(0, 0.6), "rolling_friction": draw.choice((0.0, 0.1))}
    case: dict[str, Any] = {
        "title": f"scene {seed} of the bank of promises",
        "domain_m": [[-1.0, -1.0, -1.0], [2.0, 1.0, 1.5]],
        "materials": {
            "deck": _steel() if steel else _polyurethane(draw),
            "grain": {
                "density_kg_per_m3": density_kg_per_m3,
                "youngs_modulus_Pa": 9.9e8,
                "poisson_ratio": 0.3,
            },
        },
        "contacts": [
            {"between": ["grain", "deck"], "restitution": draw.uniform(0.05, 0.9), **pair},
            {"between": ["grain", "grain"], "restitution": draw.uniform(0.05, 0.9), **pair},
        ],
        "screen": {
            "panels": {
                "deck": {
                    "material": "deck",
                    "frames": ["ground", "ground"],
                    "corner_m": [0.0, 0.0, 0.0],
                    "length_m": length_m,
                    "width_m": width_m,
                    "thickness_m": thickness_m,
                    "clamp_m": 0.019,
                    "tension_m": tension * length_m,
                }
            }
        },
        "bed": bed,
        "default_level": "strip",
        "frames": {"solver": "prescribed"},
        "panel": {
            "cells": [draw.randint(8, 28), 1],
            "surface_cells": [draw.randint(8, 24), draw.randint(2, 8)],
        },
        "particles": {"largest_youngs_modulus_Pa": min(cap_Pa, 9.9e8)} if softened else {},
        "monitor": dict(WARNING, crossed_surface="warn", penetrated_surfaces="warn", folded_panels="warn"),
        "output": {"pictures": False},
        "checkpoint": {"wall_min": 0.0},
    }
    _shake(draw, case, length_m, width_m)
    return case


def _steel() -> dict[str, Any]:
    return {
        "density_kg_per_m3": 7850.0,
        "hyperelastic": {"c10_Pa": 1.3e10, "c01_Pa": 1.3e10, "bulk_modulus_Pa": 1.6e11},
    }


def _polyurethane(draw: random.Random) -> dict[str, Any]:
    branches = [{"ratio": 0.2, "relaxation_s": time_s} for time_s in (1e-2, 2e-3, 4e-4)]
    stiff = draw.uniform(0.5, 2.0)
    return {
        "density_kg_per_m3": 1150.0,
        "hyperelastic": {
            "c10_Pa": 0.7e6 * stiff,
            "c01_Pa": 2.8e6 * stiff,
            "bulk_modulus_Pa": 2e9,
            "maxwell": branches if draw.random() < 0.7 else [],
        },
    }


def _particles(draw: random.Random, length_m: float, width_m: float) -> tuple[dict[str, Any], float, float]:
    """Return the table of the bed, the speed of its fall, and its height."""
    kind = draw.choice(("lump", "lump", "lump among fines", "lump among fines", "falling bed", "bed at rest"))
    speed = math.exp(draw.uniform(math.log(0.2), math.log(5.0)))
    middle_m = [length_m * draw.uniform(0.2, 0.8), width_m * draw.uniform(0.2, 0.8)]
    bed: dict[str, Any] = {}
    lump_m = math.exp(draw.uniform(math.log(0.008), math.log(0.11)))
    highest_m = lump_m
    inset = 0.1
    if kind != "lump":
        grain_m = math.exp(draw.uniform(math.log(0.004), math.log(0.03)))
        if kind == "lump among fines":
            lump_m = draw.uniform(0.03, 0.11)
            grain_m = max(lump_m / math.exp(draw.uniform(math.log(4), math.log(50))), 0.0018)
        area_m2 = (1 - 2 * inset) ** 2 * length_m * width_m
        layers = draw.randint(1, 6)
        largest_m = grain_m * draw.uniform(1.0, 1.5)
        count = max(1, min(300, int(0.25 * layers * area_m2 / largest_m**2)))
        height_m = max(1.2 * largest_m, count * largest_m**3 / 0.2 / area_m2)
        fall = 0.0 if kind == "bed at rest" else -speed
        low_m = 0.002 + (0.0 if kind == "bed at rest" else speed * 0.002)
        bed["blocks"] = {
            "grains": {
                "material": "grain",
                "box_m": [
                    [inset * length_m, inset * width_m, low_m],
                    [(1 - inset) * length_m, (1 - inset) * width_m, low_m + height_m],
                ],
                "count": count,
                "sizes": [{"smallest_m": grain_m, "largest_m": largest_m, "mass_fraction": 1.0}],
                "velocity_m_per_s": [0.0, 0.0, fall],
                "seed": draw.randint(1, 10**6),
            }
        }
        highest_m = low_m + height_m
    if kind in ("lump", "lump among fines"):
        above_m = 0.5 * lump_m + (highest_m + 0.002 if kind == "lump among fines" else 0.002)
        bed["particles"] = {
            "lump": {
                "position_m": [*middle_m, above_m],
                "velocity_m_per_s": [draw.uniform(-0.3, 0.3) * speed, 0.0, -speed],
                "sieve_size_m": lump_m,
                "material": "grain",
            }
        }
    return bed, speed, highest_m


def _shake(draw: random.Random, case: dict[str, Any], length_m: float, width_m: float) -> None:
    """Let a frame move the panel in some of the scenes: a drive, or a free frame on bushings."""
    kind = draw.choice(("still", "still", "driven", "free"))
    if kind == "still":
        return
    panel, speed = case["screen"]["panels"]["deck"], draw.uniform(60, 120)
    panel["frames"] = ["base", "ground"]
    if kind == "driven":
        stroke_m = draw.uniform(0.001, 0.005)
        case["screen"]["frames"] = {
            "base": {
                "drive": {
                    "speed_rad_per_s": speed,
                    "amplitude_m": [stroke_m, 0.0, draw.uniform(0, 0.5) * stroke_m],
                }
            }
        }
        return
    case["frames"] = {"solver": "exudyn"}
    mass_kg = math.exp(draw.uniform(math.log(5), math.log(80)))
    stiffness = mass_kg * draw.uniform(15, 60) ** 2 / 4
    case["screen"]["frames"] = {
        "base": {
            "mass_kg": mass_kg,
            "inertia_kg_m2": [0.05 * mass_kg] * 3,
            "center_of_mass_m": [0.0, width_m / 2, 0.0],
        }
    }
    case["screen"]["bushings"] = {
        "feet": {
            "between": ["ground", "base"],
            "positions_m": [[x, y, 0.0] for x in (-0.2, 0.2) for y in (0.0, width_m)],
            "stiffness_N_per_m": [stiffness] * 3,
            "damping_N_s_per_m": [0.1 * stiffness / speed] * 3,
        }
    }
    case["screen"]["exciters"] = {
        "shaft": {
            "frame": "base",
            "position_m": [0.0, width_m / 2, 0.0],
            "mass_moment_kg_m": 0.003 * mass_kg,
            "speed_rad_per_s": speed,
            "run_up_s": 0.05,
        }
    }


def with_interval(case: dict[str, Any], scheme: str, interval_s: float, duration_s: float) -> dict[str, Any]:
    """Return the case with a scheme and an interval of three digits, which divides its duration."""
    digits = 2 - math.floor(math.log10(interval_s))
    interval_s = math.floor(interval_s * 10**digits + 1e-9) / 10**digits
    tenths = max(1, round(duration_s / 10 / interval_s))
    every_s = round(tenths * interval_s, digits + 3)
    return case | {
        "duration_s": round(10 * every_s, digits + 3),
        "coupling": {"scheme": scheme, "sync_interval_s": interval_s},
        "output": case["output"] | {"interval_s": every_s},
    }


def run_case(folder: Path) -> dict[str, Any]:
    """Run the case in a folder, and return its figures.

    "idle" is a run in which no particle met a surface, and "other doubts" are about the scene, such as its
    overlaps, and not about its coupling.
    """
    with contextlib.redirect_stderr(io.StringIO()):
        code = run(folder, None, folder / "run", [])
    summary = folder / "run" / SUMMARY
    if not summary.exists():
        return {"status": "error", "why": f"exit code {code}"}
    figures = json.loads(summary.read_text())
    created = share_created(figures) if "energy_ledger_J" in figures else math.nan
    status, doubts = figures["status"], figures["doubts"]
    if status in ("done", "doubtful") and not figures["material"]["deepest_overlaps"]["surface_m"]:
        status = "idle"
    elif status == "doubtful" and abs(created) <= LARGEST_SHARE_CREATED and "not solved" not in str(doubts):
        status = "other doubts"
    counts = figures.get("iterations") or {"mean": 1.0, "unsolved": 0}
    return {
        "status": status,
        "created": created,
        "runs": counts["mean"],
        "unsolved": counts["unsolved"],
        "why": "; ".join([figures["reason"], *doubts])[:200],
    }


def lasting_s(case: dict[str, Any], loaded: JudgedCase, interval_s: float) -> float:
    """Return how long a scene may be run, so that neither intervals nor particles' steps are too many."""
    bed = case["bed"]
    particles = len(bed.get("particles", {})) + sum(
        block["count"] for block in bed.get("blocks", {}).values()
    )
    steps_per_s = (particles + 20) / particle_step_s(loaded.case)
    return float(min(DURATION_S, MOST_INTERVALS * interval_s, MOST_PARTICLE_STEPS / steps_per_s))


def trial(seed: int, scheme: str, share: float, out: Path | None) -> dict[str, Any]:
    """Run a scene under a scheme at a share of the promised interval, and return the row of the table."""
    row: dict[str, Any] = {"seed": seed, "scheme": scheme, "share": share}
    case = random_case(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "levels").mkdir()
        (folder / "levels" / "strip.toml").write_text(LEVEL)

        def load(interval_s: float, duration_s: float) -> JudgedCase:
            table = with_interval(case, scheme, interval_s, duration_s)
            (folder / "case.toml").write_text(tomli_w.dumps(table))
            loaded = load_judged(folder, None, [])
            if problems := find_all_problems(loaded):
                raise CaseError(problems)
            return loaded

        try:
            loaded = load(1e-5, 0.02)
            report = stability_report(loaded.case)
            bound, safe_s = report.stability_bound, report.safe_s
            row |= {"safe_s": safe_s, "bound": bound.name if bound else ""}
            if bound is None or safe_s == 0:
                return row | {"status": "no promise"}
            interval_s = min(share * safe_s, DURATION_S / FEWEST_INTERVALS)
            duration_s = lasting_s(case, loaded, interval_s)
            row |= {"interval_s": interval_s, "duration_s": duration_s}
            if duration_s < SHORTEST_S:
                return row | {"status": "costly"}
            load(interval_s, duration_s)
        except CaseError as error:
            return row | {"status": "refused", "why": str(error)[:200]}
        begun = time.monotonic()
        row |= run_case(folder) | {"took_s": time.monotonic() - begun}
        if out is not None and row["status"] not in SOUND:
            shutil.copyfile(folder / "case.toml", out / f"{seed}-{scheme}-{share}.toml")
    return row


COLUMNS = (
    "seed",
    "scheme",
    "share",
    "status",
    "created",
    "safe_s",
    "bound",
    "interval_s",
    "duration_s",
    "runs",
    "unsolved",
    "took_s",
    "why",
)


def main() -> int:
    """Run the trials, print what is sound, and return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--schemes", default=",".join(SCHEMES))
    parser.add_argument("--shares", default="0.5,1")
    parser.add_argument("--out", type=Path, default=Path("runs/promises"))
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    tasks = [
        (seed, scheme, float(share), options.out)
        for seed in range(options.first, options.first + options.scenes)
        for scheme in options.schemes.split(",")
        for share in options.shares.split(",")
    ]
    rows = []
    with (
        (options.out / "runs.csv").open("w", newline="") as file,
        multiprocessing.get_context("spawn").Pool(options.workers, maxtasksperchild=40) as pool,
    ):
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for row in pool.imap(_trial, tasks):
            writer.writerow({key: row.get(key, "") for key in COLUMNS})
            file.flush()
            rows.append(row)
    return 0 if tell(rows) else 1


def _trial(task: tuple[int, str, float, Path]) -> dict[str, Any]:
    return trial(*task)


def tell(rows: list[dict[str, Any]]) -> bool:
    """Print for every scheme and share how many runs are sound, and return whether enough are."""
    enough = True
    for scheme, share in dict.fromkeys((row["scheme"], row["share"]) for row in rows):
        those = [row for row in rows if (row["scheme"], row["share"]) == (scheme, share)]
        counts: dict[str, int] = {}
        for row in those:
            counts[row["status"]] = counts.get(row["status"], 0) + 1
        sound = sum(counts.get(state, 0) for state in SOUND)
        tried = sound + sum(counts.get(state, 0) for state in TRIED)
        enough &= tried == 0 or sound >= LEAST_SOUND * tried
        print(f"{scheme:18} {share:4g} of the promise: {sound} of {tried} sound; {counts}")
    return enough


if __name__ == "__main__":
    sys.exit(main())
