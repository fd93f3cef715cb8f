"""The results of a run, computed a second time: by the definitions of docs/run-folder.md and
docs/theory/screening.md, from the records and snapshots in the run's folder, without the product's code.

What the product takes from records of cycles is taken here from the rows of every sync point, and what it
records of the bed from the snapshots for ParaView.  It needs a run whose series have a row at every sync
point, with shapes as often.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
import numpy.typing as npt
from scipy.fft import dct, dst
from scipy.optimize import minimize, minimize_scalar
from scipy.spatial.transform import Rotation
from scipy.stats import norm as normal
from scipy.stats import t as student

Array = npt.NDArray[Any]
G = 9.80665
LOST = -1
NEAR = 1e-7  # of a cycle: rounding of times at its ends
FIRST_NODE = 0.005299532504175  # of Gauss's 16 nodes in (0, 1): where the drawn partition curve begins
Statistic = Callable[[Array], float]


def divide(part: float, whole: float) -> float:
    """The quotient; NaN where there is nothing to divide by."""
    return part / whole if whole > 0 else float("nan")


def number(value: float) -> float | None:
    """A number as JSON has it."""
    return float(value) if np.isfinite(value) else None


def batch_number(cycles: int) -> int:
    """20 to 40 batches, which leave the fewest cycles over; each of a few cycles is a batch."""
    if cycles <= 40:
        return cycles
    return max(range(20, 41), key=lambda count: (-(cycles % count), count))


def batches_of(table: Array) -> Array:
    """Sums over batches of whole cycles; the first one has the cycles that are left over."""
    count = batch_number(len(table))
    long = len(table) // count
    ends = len(table) - long * np.arange(count - 1, -1, -1)
    starts = [0, *ends[:-1]]
    return np.array([table[a:b].sum(axis=0) for a, b in zip(starts, ends, strict=True)])


Width = tuple[float | None, float | None]
TOO_FEW: Width = None, None


def by_chance(values: Array) -> Width:
    """The half width of the interval of the mean of batches, and its standard error.

    The six slowest terms of the cosine transform have the variance, so that the interval is Student's with
    six degrees of freedom.  There is none of fewer than ten batches, or of fewer than five independent ones.
    """
    n, away = len(values), values - values.mean()
    if n < 10:
        return TOO_FEW
    square = float(np.sum(away**2))
    if square <= n * (1e-12 * np.abs(values).max()) ** 2:
        return 0.0, 0.0
    r = (n * float(np.sum(away[1:] * away[:-1])) / square + 1) / (n - 3)
    if n * (1 - r) / (1 + r) < 5:
        return TOO_FEW
    error = float(np.linalg.norm(dct(away, type=2, norm="ortho")[1:7]) / np.sqrt(6 * n))
    return float(student.ppf(0.975, 6)) * error, error


def of_a_feed(values: Array) -> Width:
    """The same where the sum of what came follows a line: its scatter about the line, at both ends."""
    n = len(values)
    if n < 10:
        return TOO_FEW
    came = np.concatenate([[0.0], np.cumsum(values)])
    line = np.polynomial.Polynomial.fit(np.arange(n + 1), came, 1)
    error = float(np.sqrt(2 * np.sum((came - line(np.arange(n + 1))) ** 2) / (n - 1)) / n)
    return float(normal.ppf(0.975)) * error, error


def too_short(values: Array) -> Width:
    """No interval, of a bed that has not changed often enough."""
    return TOO_FEW


def times(factor: float, width: Width) -> Width:
    """A width that is so many times as wide."""
    half_width, error = width
    return half_width and factor * half_width, error and factor * error


def with_width(value: float, batches: int, width: Width) -> dict[str, Any]:
    """An estimate with its interval, or with a reason where there is none."""
    half_width, error = width
    rest = {"reason": "too few"} if error is None else {"standard_error": error}
    return {"value": value, "half_width": half_width, "batches": batches} | rest


def estimate(
    of: Statistic,
    per_cycle: Array,
    counting: float | None = None,
    steady: bool = True,
    width: Callable[[Array], Width] = by_chance,
) -> dict[str, Any]:
    """The estimate of a figure of sums over the cycles (cycles, ...) of a window, by the jackknife where it
    is steady."""
    batches = batches_of(per_cycle)
    n, total = len(batches), batches.sum(axis=0)
    whole, without = of(total), np.array([of(total - batch) for batch in batches])
    if number(whole) is None or not steady:
        table = {"value": number(whole), "half_width": None, "batches": 0}
    elif n < 2 or not np.isfinite(without).all():
        table = with_width(whole, n, TOO_FEW)
    else:
        table = with_width(whole, n, width(n * whole - (n - 1) * without))
    return table if counting is None or not np.isfinite(counting) else table | {"counting": counting}


def counted(part: float, mass_kg: Array) -> float:
    """The standard deviation of a share of particles by their number alone."""
    return float(np.sqrt(part * (1 - part) * np.sum(mass_kg**2)) / np.sum(mass_kg))


@dataclass
class Motion:
    """The first harmonic of a motion (rows, components) over the last whole turns of a window."""

    time_s: Array
    values: Array
    turn_s: float
    window_s: tuple[float, float]
    width: Callable[[Array], Width] = by_chance

    def __post_init__(self) -> None:
        self.turns = int((self.window_s[1] - self.window_s[0]) / self.turn_s + NEAR)
        self.end_s = self.window_s[1]
        self.phasor, self.slow, self.inside = self.fit(self.turns, 0)

    def fit(self, turns: int, before: int) -> tuple[Array, Array, Array]:
        """The phasors by Hann's weight over ``turns`` turns that end ``before`` turns before the end, the
        slow motion, and the rows."""
        end_s = self.end_s - before * self.turn_s
        start_s, close = end_s - turns * self.turn_s, NEAR * self.turn_s
        rows = (self.time_s > start_s + close) & (self.time_s <= end_s + close)
        t, w = self.time_s[rows], 2 * np.pi / self.turn_s
        hann = np.abs(np.sin(np.pi * (t - start_s) / (end_s - start_s)))
        root = (hann if turns > 1 else np.ones_like(t))[:, None]
        since = (t - t.mean()) / self.turn_s
        terms = np.stack([np.cos(w * t), np.sin(w * t), np.ones_like(t), since], axis=1)
        c = np.linalg.pinv(root * terms) @ (root * self.values[rows])
        return c[0] - 1j * c[1], terms[:, 2:] @ c[2:], rows

    @cached_property
    def widths(self) -> list[Width]:
        """Width of each component: each batch has a phasor, whose part along the mean one counts. Hann's
        weight makes the interval wider."""
        count = batch_number(self.turns)
        long, rest = self.turns // count, self.values[self.inside] - self.slow
        t, w = self.time_s[self.inside], 2 * np.pi / self.turn_s
        along = []
        for k in range(count, 0, -1):
            low = self.end_s - k * long * self.turn_s
            rows = (t > low + NEAR * self.turn_s) & (t <= low + (long + NEAR) * self.turn_s)
            terms = np.stack([np.cos(w * t[rows]), np.sin(w * t[rows]), np.ones(rows.sum())], axis=1)
            c = np.linalg.pinv(terms) @ rest[rows]
            along.append(np.real((c[0] - 1j * c[1]) * np.conj(self.phasor) / np.abs(self.phasor)))
        return [times(1.5**0.5, self.width(column)) for column in np.array(along).T]

    @property
    def half_width(self) -> list[float | None] | None:
        """The half widths by component, or None if none is known."""
        half_widths = [half_width for half_width, _ in self.widths]
        return None if half_widths == [None] * len(half_widths) else half_widths

    @property
    def change(self) -> float:
        """The largest change of a phasor from the first half of the turns to the second."""
        half = self.turns // 2
        early, late = self.fit(half, self.turns - half)[0], self.fit(half, 0)[0]
        return float(np.abs(late - early).max())

    def estimate(self, component: int) -> dict[str, Any]:
        """The amplitude of a component as an estimate."""
        return with_width(np.abs(self.phasor[component]), batch_number(self.turns), self.widths[component])

    def table(self) -> dict[str, Any]:
        """The entry of a frame."""
        t, w = self.time_s[self.inside], 2 * np.pi / self.turn_s
        wave = np.outer(np.cos(w * t), self.phasor.real) - np.outer(np.sin(w * t), self.phasor.imag)
        rest = self.values[self.inside] - self.slow - wave
        # x and z are M (cos, sin): the singular values of M are the half axes
        m = np.array([[p.real, -p.imag] for p in self.phasor[[0, 2]]])
        left, sizes, _ = np.linalg.svd(m)
        tilt = np.degrees(np.arctan2(left[1, 0], left[0, 0]))
        return {
            "amplitude_m": np.abs(self.phasor),
            "half_width_m": self.half_width,
            "phase_rad": np.arctan2(self.phasor.imag, self.phasor.real),
            "major_m": sizes[0],
            "minor_m": np.sign(np.linalg.det(m)) * sizes[1],
            "tilt_deg": (tilt + 90.0) % 180.0 - 90.0,
            "other_m": (rest.max(axis=0) - rest.min(axis=0)) / 2,
        }


def acceleration(velocity: Array, step_s: float, band_Hz: float = 500.0) -> Array:
    """Sines of what exceeds the straight line, each derived exactly and weighed by its frequency's gain."""
    n = len(velocity) - 1
    slope = (velocity[-1] - velocity[0]) / (n * step_s)
    over = velocity - velocity[0] - np.arange(n + 1)[:, None] * step_s * slope
    sines = dst(over[1:-1], type=1, axis=0) / n
    w = np.pi * np.arange(1, n)[:, None] / (n * step_s)
    cosines = np.zeros_like(velocity)
    cosines[1:-1] = w * sines / (1 + (w / (2 * np.pi * band_Hz)) ** 8)
    return np.asarray(slope + dct(cosines, type=1, axis=0) / 2)


class Recomputed:
    """A run's folder, read by h5py, tomllib and meshio alone."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.case: dict[str, Any] = tomllib.loads((folder / "case.toml").read_text())
        self.data: dict[str, Array] = {}
        with h5py.File(folder / "history.h5") as history:

            def keep(name: str, item: Any) -> None:
                if isinstance(item, h5py.Dataset) and not name.startswith("results/"):
                    self.data[name] = item[()]

            history.visititems(keep)
            names, products = (history["removed"].attrs[key] for key in ("names", "products"))
            self.exits = [(str(name), str(product)) for name, product in zip(names, products, strict=True)]
        screen = self.case["screen"]
        a = np.radians(screen["inclination_deg"])
        self.deck = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
        self.cycle_s = 2 * np.pi / min(row["speed_rad_per_s"] for row in screen["exciters"].values())
        self.end_s = float(self.data["energy/time_s"][-1])
        self.cycles = int(self.end_s / self.cycle_s + NEAR)
        self.edges_s = np.arange(self.cycles + 1) * self.cycle_s
        self.frames = list(screen["frames"])
        self.panels = sorted(name.split("/")[1] for name in self.data if name.endswith("centre_line_m"))
        self.fed, self.removed = self.events("fed"), self.events("removed")
        self.first, self.last, self.is_steady = self.steady_cycles()
        self.window_s = float(self.edges_s[self.first]), float(self.edges_s[self.last])
        self.begin = self.first if self.is_steady else self.cycles // 2  # of the window of motion
        self.moves_s = float(self.edges_s[self.begin]), self.window_s[1]

    # ------------------------------------------------------------------ particles that came and left

    def events(self, kind: str) -> dict[str, Array]:
        table = {name.split("/")[1]: v for name, v in self.data.items() if name.startswith(f"{kind}/")}
        return table | {"kg": np.pi / 6 * table["sieve_size_m"] ** 3 * table["density_kg_per_m3"]}

    def cycle(self, time_s: Array) -> Array:
        """The number of the cycle of each time: later than its start, up to its end."""
        return np.searchsorted(self.edges_s[1:], time_s - NEAR * self.cycle_s)

    def within(self, time_s: Array, window_s: tuple[float, float] | None = None) -> npt.NDArray[np.bool_]:
        start_s, end_s = window_s or self.window_s
        close = NEAR * self.cycle_s
        return np.asarray((time_s > start_s + close) & (time_s <= end_s + close))

    def by_cycle(self, time_s: Array, values: Array, mask: Array | None = None) -> Array:
        """Sums over each whole cycle of the run."""
        rows = np.ones(len(time_s), bool) if mask is None else mask
        sums = np.bincount(self.cycle(time_s[rows]), values[rows], self.cycles)
        return np.asarray(sums[: self.cycles], float)

    def of_window(self, *columns: Array) -> Array:
        return np.stack(columns, axis=1)[self.first : self.last]

    @cached_property
    def balance(self) -> tuple[Array, Array, Array, Array]:
        """Mass in and out, hold-up at the ends of cycles, and its mean over each cycle."""
        came, left = self.fed, self.removed
        later = came["time_s"] > 0
        fed = self.by_cycle(came["time_s"], came["kg"], later)
        out = self.by_cycle(left["time_s"], left["kg"])
        starts, ends = self.edges_s[:-1, None], self.edges_s[1:, None]

        def present_s(time_s: Array) -> Array:
            return np.clip(ends - time_s, 0.0, ends - starts)

        mean = (
            present_s(came["time_s"]) @ came["kg"] - present_s(left["time_s"]) @ left["kg"]
        ) / self.cycle_s
        held = came["kg"][~later].sum() + np.concatenate([[0.0], np.cumsum(fed - out)])
        return fed, out, held, mean

    def steady_cycles(self) -> tuple[int, int, bool]:
        """The cycles by the marginal standard error rule, if they are steady; else all of them.

        The run must have a feed that never stops.
        """
        fed, out, held, mean = self.balance
        most = min(self.cycles // 2, self.cycles - 20)
        first = min(range(most + 1), key=lambda d: np.var(mean[d:]) / (self.cycles - d))
        came_kg, gone_kg = fed[first:].sum(), out[first:].sum()
        numbers = np.arange(self.cycles - first)
        line = np.polynomial.Polynomial.fit(numbers, mean[first:], 1).convert()
        scatter_kg = np.sqrt(np.sum((mean[first:] - line(numbers)) ** 2) / (len(numbers) - 2))
        self.imbalance = (came_kg - gone_kg) / came_kg
        self.drift = line.coef[1] * len(numbers) / came_kg
        balances = abs(self.imbalance) <= 0.02 + 2 * np.sqrt(2) * scatter_kg / came_kg
        is_steady = bool(balances and abs(self.drift) <= 0.02 and held[-1] <= gone_kg)
        return first if is_steady else 0, self.cycles, is_steady

    def estimate(
        self,
        of: Statistic,
        per_cycle: Array,
        counting: float | None = None,
        width: Callable[[Array], Width] = by_chance,
    ) -> dict[str, Any]:
        """The estimate of a figure of the bed, which has an interval where the bed is steady."""
        return estimate(of, per_cycle, counting, self.is_steady, width)

    @cached_property
    def width(self) -> Callable[[Array], Width]:
        """The interval of what hangs on the bed: a steady window needs five mean stays, by Little's law."""
        fed, _, _, mean = (kg[self.first : self.last] for kg in self.balance)
        return too_short if self.is_steady and 5 * np.mean(mean) > np.sum(fed) else by_chance

    def steady(self) -> dict[str, Any]:
        return {
            "is_steady": self.is_steady,
            "reason": "" if self.is_steady else "it changes",
            "start_s": self.window_s[0],
            "end_s": self.window_s[1],
            "cycles": self.last - self.first,
            "imbalance_percent": 100 * self.imbalance,
            "drift_percent": 100 * self.drift,
        }

    @cached_property
    def cut_m(self) -> float:
        """The smaller side of the largest openings."""
        openings = [row["apertures"] for row in self.case["screen"]["panels"].values()]
        return max(min(row["length_m"], row["width_m"]) for row in openings)

    def product(self, name: str) -> npt.NDArray[np.bool_]:
        """Return which particles left with a product."""
        numbers = [i for i, (_, product) in enumerate(self.exits) if product == name]
        return np.isin(self.removed["exit"], numbers)

    def screening(self) -> dict[str, Any]:
        left, (fed, _, held, mean) = self.removed, self.balance
        time_s, kg, fine = left["time_s"], left["kg"], left["sieve_size_m"] < self.cut_m
        under, over = self.product("undersize"), self.product("oversize")
        counts = self.within(time_s) & (left["exit"] != LOST)

        def sums(mask: Array) -> Array:
            return self.by_cycle(time_s, kg, mask)

        def rate(name: str, per_cycle: Array) -> dict[str, Any]:
            columns = self.of_window(per_cycle, np.full(self.cycles, self.cycle_s))
            width = of_a_feed if name == "feed" else by_chance
            return self.estimate(lambda s: s[0] / s[1], columns, width=width)

        columns = self.of_window(
            sums(under & fine), sums(under & ~fine), sums(over & fine), sums(over & ~fine)
        )
        uf, uc, of, oc = range(4)
        shares: dict[str, Statistic] = {
            "oversize_yield": lambda s: divide(s[of] + s[oc], s.sum()),
            "efficiency": lambda s: divide(s[uf], s[uf] + s[of]) + divide(s[oc], s[uc] + s[oc]) - 1,
            "fine_placement": lambda s: divide(s[uf], s[uf] + s[of]),
            "coarse_placement": lambda s: divide(s[oc], s[uc] + s[oc]),
            "misplaced": lambda s: divide(s[of] + s[uc], s.sum()),
            "fines_in_oversize": lambda s: divide(s[of], s[of] + s[oc]),
        }
        of_all = columns.sum(axis=0)
        who = {"fine_placement": fine, "coarse_placement": ~fine, "fines_in_oversize": over}
        chance = {
            name: counted(share(of_all), kg[counts & who.get(name, counts)]) for name, share in shares.items()
        }
        chance["efficiency"] = np.hypot(chance["fine_placement"], chance["coarse_placement"])
        came = self.fed["sieve_size_m"] < self.cut_m
        came &= (self.fed["time_s"] > 0) | (not self.is_steady)
        recovered = self.of_window(
            sums(under & fine), self.by_cycle(self.fed["time_s"], self.fed["kg"], came)
        )
        passed, whole = recovered.sum(axis=0)
        of_fed = self.fed["kg"][came & self.within(self.fed["time_s"])]
        flows = {"feed": fed, "undersize": sums(under), "oversize": sums(over)}
        return {
            "cut_size_m": self.cut_m,
            "lost_particles": int((left["exit"] == LOST).sum()),
            "particles": int(counts.sum()),
            "fine_particles": int((counts & fine).sum()),
            **{f"{name}_kg_per_s": rate(name, kg) for name, kg in flows.items()},
            "hold_up_kg": self.estimate(
                lambda s: s[0] / s[1], self.of_window(mean, np.ones(self.cycles)), width=self.width
            ),
            "in_time": {
                "time_s": self.edges_s[1:],
                **{f"{name}_kg_per_s": kg / self.cycle_s for name, kg in flows.items()},
                "hold_up_kg": held[1:],
            },
            **{
                f"{name}_percent": self.estimate(lambda s, of=share: 100 * of(s), columns, 100 * chance[name])
                for name, share in shares.items()
            },
            "recovered_percent": self.estimate(
                lambda s: 100 * s[0] / s[1], recovered, 100 * counted(passed / whole, of_fed)
            ),
            "sections": self.sections(fine, sums),
            "partition": self.partition(counts, over),
        }

    def sections(self, fine: Array, sums: Callable[[Array], Array]) -> list[dict[str, Any]]:
        """The exits for undersize, in the case's order."""
        exit_number, rows = self.removed["exit"], []
        numbers = [i for i, (_, product) in enumerate(self.exits) if product == "undersize"]
        there = exit_number != LOST
        for place, i in enumerate(numbers):
            here, before = exit_number == i, np.isin(exit_number, numbers[:place])
            columns = self.of_window(
                *(sums(mask) for mask in (here, there, here & fine, before & fine, there & fine))
            )
            rows.append(
                {
                    "exit": self.exits[i][0],
                    "yield_percent": self.estimate(lambda s: 100 * divide(s[0], s[1]), columns),
                    "cumulative_efficiency_percent": self.estimate(
                        lambda s: 100 * divide(s[2] + s[3], s[4]), columns
                    ),
                    "local_efficiency_percent": self.estimate(
                        lambda s: 100 * divide(s[2], s[4] - s[3]), columns
                    ),
                }
            )
        return rows

    def partition(self, counts: Array, over: Array) -> dict[str, Any]:
        """Classes even in the logarithm, one edge at the cut size, joined until each has ten particles."""
        left = self.removed
        d = left["sieve_size_m"][counts]
        edges = np.exp(np.linspace(np.log(d.min()) - 1e-9, np.log(d.max()) + 1e-9, 13))
        inner = np.argmin(np.abs(np.log(edges[1:-1] / self.cut_m))) + 1
        edges[inner] = self.cut_m
        joined = [edges[0]]
        for edge in edges[1:]:
            enough = ((d >= joined[-1]) & (d < edge)).sum() >= 10
            if enough or edge == self.cut_m:
                joined.append(edge)
        if joined[-1] < edges[-1]:
            if joined[-1] != self.cut_m and len(joined) > 1:
                joined.pop()
            joined.append(edges[-1])
        limits, size = np.array(joined), np.digitize(left["sieve_size_m"], joined) - 1
        classes = range(len(limits) - 1)
        size = np.clip(size, 0, len(limits) - 2)
        mean_m = np.array([left["sieve_size_m"][counts & (size == k)].mean() for k in classes])
        there = left["exit"] != LOST
        columns = self.of_window(
            *(self.by_cycle(left["time_s"], left["kg"], there & (size == k)) for k in classes),
            *(self.by_cycle(left["time_s"], left["kg"], over & (size == k)) for k in classes),
        )

        def size_at(share: float, s: Array) -> float:
            """The size at which the share that goes to the oversize first rises through a share."""
            p = s[len(classes) :] / s[: len(classes)]
            for k in range(len(p) - 1):
                if p[k] < share <= p[k + 1]:
                    return float(mean_m[k] + (share - p[k]) / (p[k + 1] - p[k]) * (mean_m[k + 1] - mean_m[k]))
            return float("nan")

        total = columns.sum(axis=0)
        all_kg, over_kg = total[: len(classes)], total[len(classes) :]
        return {
            "edges_m": limits,
            "mean_m": mean_m,
            "particles": [int((counts & (size == k)).sum()) for k in classes],
            "feed_percent": 100 * all_kg / all_kg.sum(),
            "oversize_percent": 100 * over_kg / all_kg,
            "d50_m": self.estimate(lambda s: size_at(0.5, s), columns),
            "ep_m": self.estimate(lambda s: (size_at(0.75, s) - size_at(0.25, s)) / 2, columns),
        }

    def contacts(self) -> dict[str, Any]:
        """Stay, contacts, reach and chance of the fines, from the records of those that left."""
        left, (panel,) = self.removed, self.case["screen"]["panels"].values()
        rows = (left["exit"] != LOST) & (left["sieve_size_m"] < self.cut_m) & self.within(left["time_s"])
        d, kg, time_s, last = (left[name][rows] for name in ("sieve_size_m", "kg", "time_s", "last_panel"))
        hits, over_s, near_s = (
            left[name][rows].astype(float) for name in ("contacts", "over_s", "within_reach_s")
        )
        panels, holes = hits.shape[1], panel["apertures"]
        gaudin = (holes["length_m"] - d) * (holes["width_m"] - d)
        gaudin /= holes["pitch_along_m"] * holes["pitch_across_m"]
        passed = np.array([(last == k) & self.product("undersize")[rows] for k in range(panels)]).T
        farthest = np.array(
            [max(np.flatnonzero(s + h), default=-1) for s, h in zip(over_s, hits, strict=True)]
        )
        went_on = (np.arange(panels) <= farthest[:, None]) & ~passed

        def figures(s: Array) -> dict[str, float]:
            over, contacts, near, through, chances = s
            shares = {
                "within_reach": near / over,
                "chance": through / contacts,
                "geometric": chances / contacts,
            }
            rates = {"contacts_per_s": contacts / over, "rate_per_s": through / over}
            return rates | {f"{name}_percent": 100 * share for name, share in shares.items()}

        columns = [(kg * each.T).T for each in (over_s, hits, near_s, passed, hits * gaudin[:, None])]
        stay_s = [np.average(over_s[on, k], weights=kg[on]) for k, on in enumerate(went_on.T)]
        along = [
            {
                "panel": f"deck-{k + 1}",
                "stay_s": stay_s[k],
                **figures(np.array([c[:, k].sum() for c in columns])),
            }
            | {"came_percent": 100 * kg[farthest >= k].sum() / kg.sum()}
            | {"passed_percent": 100 * columns[3][:, : k + 1].sum() / kg.sum()}
            for k in range(panels)
        ]
        edges = np.exp(np.linspace(np.log(d.min()) - 1e-9, np.log(d.max()) + 1e-9, 13))
        number_in = np.histogram(d, edges)[0]
        assert (number_in >= 10).all(), "or classes would be joined"
        size = np.clip(np.digitize(d, edges) - 1, 0, 11)
        of_size = [figures(np.array([c[size == k].sum() for c in columns])) for k in range(12)]
        sizes = {name: np.array([part[name] for part in of_size]) for name in of_size[0]}
        hits_each = sum(row["contacts_per_s"] * row["stay_s"] for row in along)
        left_kg = np.bincount(size, kg) * np.exp(-sizes["chance_percent"] / 100 * hits_each)
        over_end = ~passed.any(axis=1)
        whole = [self.by_cycle(time_s, c.sum(axis=1)) for c in columns]
        whole += [self.by_cycle(time_s, w * over_end) for w in (kg * over_s.sum(axis=1), kg)]
        table = self.of_window(*whole)
        elapsed_s, shares = np.cumsum(stay_s), np.array([row["passed_percent"] for row in along]) / 100
        fit = minimize_scalar(
            lambda k: np.sum((1 - np.exp(-k * elapsed_s) - shares) ** 2),
            bounds=(0.0, 100.0),
            method="bounded",
            options={"xatol": 1e-12},
        )
        curve = 1 - np.exp(-fit.x * elapsed_s)
        return {
            "particles": int(rows.sum()),
            "counted_percent": 100 * columns[3].sum() / kg.sum(),
            "rebuilt_percent": 100 * (1 - left_kg.sum() / kg.sum()),
            **{name: self.estimate(lambda s, of=name: figures(s[:5])[of], table) for name in of_size[0]},
            "stay_s": self.estimate(lambda s: s[5] / s[6], table),
            "along": along,
            "fit": {
                "rate_per_s": fit.x,
                "rms_percent": 100 * np.sqrt(np.mean((curve - shares) ** 2)),
                "time_s": elapsed_s,
                "passed_percent": 100 * curve,
            },
            "sizes": {
                "mean_m": np.bincount(size, d) / number_in,
                "particles": number_in.astype(float),
                **sizes,
            },
        }

    def whole_feed(self) -> dict[str, Any]:
        """The fines completed by the partition curve, in which grains make attempts at the openings."""
        left, exits = self.removed, [product for _, product in self.exits]
        d, kg, there = left["sieve_size_m"], left["kg"], left["exit"] != LOST
        fine = there & (d < self.cut_m)
        edges = np.geomspace(d[fine].min(), self.cut_m, 13)
        size = np.clip(np.digitize(d, edges) - 1, 0, 11)
        mean_m = np.array([d[fine & (size == k)].mean() for k in range(12)])
        columns = []
        for k, own in enumerate(exits):
            here = fine & (left["exit"] == k)
            for c in range(12):
                for what in (np.ones(len(kg)), kg):
                    columns.append(self.by_cycle(left["time_s"], what, here & (size == c)))
            if own == "undersize":
                coarse_under = self.by_cycle(left["time_s"], kg, ~fine & there & self.product("undersize"))
        coarse = self.by_cycle(left["time_s"], kg, ~fine & there)
        table = self.of_window(*columns, coarse_under, coarse)
        unders = [k for k, own in enumerate(exits) if own == "undersize"]
        (row,) = self.case["screen"]["panels"].values()
        holes = row["apertures"]
        share = len(self.openings()) / row["count"] * holes["length_m"] * holes["width_m"]
        share /= row["length_m"] * row["width_m"]

        def passed(curve: Array, sizes: Array) -> Array:
            free = np.clip(1 - sizes / self.cut_m, 0, None)
            return np.asarray(1 - (1 - share * free ** curve[1]) ** np.exp(curve[0]))

        def parts(s: Array) -> tuple[Array, Array]:
            """Numbers and masses (exits, classes) of the fines."""
            both = s[:-2].reshape(len(exits), 12, 2)
            return both[:, :, 0], both[:, :, 1]

        def fit(s: Array, count: int, classes: slice) -> Array:
            numbers = parts(s)[0][:, classes]
            through = numbers[unders[:count]].sum(axis=0)
            above = numbers.sum(axis=0) - through

            def unlikely(curve: Array) -> float:
                p = np.clip(passed(curve, mean_m[classes]), 1e-300, 1 - 1e-16)
                return float(-np.sum(through * np.log(p) + above * np.log1p(-p)))

            options = {"xatol": 1e-10, "fatol": 1e-12, "maxiter": 4000}
            limits = ((-7.0, 7.0), (0.0, 20.0))
            starts = ((-np.log(share), 1.0), (0.5, 0.5))
            fits = [
                minimize(unlikely, x, method="Nelder-Mead", bounds=limits, options=options) for x in starts
            ]
            return np.asarray(min(fits, key=lambda fitted: fitted.fun).x)

        # a class is spread evenly over its diameters by number, so that its mass grows as their third power
        (feed,) = self.case["bed"]["feeds"].values()
        finest, limit = min(c["smallest_m"] for c in feed["sizes"]), feed["smallest_fed_m"]

        def mass(low: float, high: float) -> float:
            total = 0.0
            for c in feed["sizes"]:
                a, b = np.clip([low, high], c["smallest_m"], c["largest_m"])
                total += c["mass_fraction"] * (b**4 - a**4) / (c["largest_m"] ** 4 - c["smallest_m"] ** 4)
            return total

        total, out = mass(0, self.cut_m), mass(0, limit)
        grid = np.linspace(finest, limit, 4001)
        middle = (grid[1:] + grid[:-1]) / 2
        weight = np.array([mass(a, b) for a, b in pairwise(grid)])

        def placement(count: int, s: Array) -> float:
            kilos = parts(s)[1]
            computed = kilos[unders[:count]].sum() / kilos.sum()
            finer = weight @ passed(fit(s, count, slice(0, 12)), middle)
            return float(100 * ((total - out) * computed + finer) / total)

        whole, last = table.sum(axis=0), len(unders)
        reach, tested_reach = np.log(limit / finest), np.log(self.cut_m / limit) / 2
        tested = [0.0]
        for count in range(1, last + 1):
            curve, kilos = fit(whole, count, slice(6, 12)), parts(whole)[1][:, :6]
            too_much = kilos.sum(axis=0) @ passed(curve, mean_m[:6]) - kilos[unders[:count]].sum()
            tested.append(too_much / kilos.sum())
        error = 100 * out / total * np.array(tested) * (reach / tested_reach) ** 2

        def figure(of: Statistic, points: float) -> dict[str, Any]:
            figure_table = self.estimate(of, table)
            if figure_table["half_width"] is not None:
                figure_table["half_width"] += abs(points)
            return figure_table

        def section(place: int) -> dict[str, Any]:
            def passes(s: Array) -> float:
                return total * (placement(place + 1, s) - (placement(place, s) if place else 0.0))

            return {
                "exit": self.exits[unders[place]][0],
                "cumulative_efficiency_percent": figure(lambda s: placement(place + 1, s), error[place + 1]),
                "yield_percent": figure(passes, total * (error[place + 1] - error[place])),
            }

        curve = fit(whole, last, slice(0, 12))
        sizes = np.linspace(min(finest + (limit - finest) * FIRST_NODE, mean_m.min()), self.cut_m, 41)
        return {
            "left_out_percent": 100 * out,
            "smallest_m": finest,
            "smallest_computed_m": limit,
            "fines_percent": 100 * total,
            "fine_placement_percent": figure(lambda s: placement(last, s), error[last]),
            "efficiency_percent": figure(
                lambda s: placement(last, s) - 100 * divide(s[-2], s[-1]), error[last]
            ),
            "continuation": {
                "factor": limit / finest,
                "tested_factor": np.exp(tested_reach),
                "tested_error_percent": 100 * tested[last],
                "error_percent": error[last],
            },
            "sections": [section(place) for place in range(last)],
            "curve": {
                "attempts": np.exp(curve[0]),
                "exponent": curve[1],
                "opening_m": self.cut_m,
                "open_share": share,
                "sieve_size_m": sizes,
                "oversize_percent": 100 * (1 - passed(curve, sizes)),
            },
        }

    # ------------------------------------------------------------------ the bed on the deck

    @cached_property
    def line_at_rest(self) -> tuple[Array, Array, Array]:
        """The horizontal direction of the deck, and its line at t = 0: places along it and heights."""
        line = np.concatenate([self.data[f"panels/{name}/centre_line_m"][0] for name in self.panels])
        along = np.array([1.0, 0.0, 0.0])  # the deck slopes along its x axis
        return along, line @ along, line[:, 2]

    @cached_property
    def station_m(self) -> Array:
        _, over, level = self.line_at_rest
        return np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(over), np.diff(level)))])

    def transport(self) -> dict[str, Any]:
        left, length_m = self.removed, self.station_m[-1]
        came_s = dict(zip(self.fed["id"].tolist(), self.fed["time_s"].tolist(), strict=True))
        stay_s = left["time_s"] - np.array([came_s[i] for i in left["id"].tolist()])
        over = self.product("oversize")
        columns = self.of_window(
            self.by_cycle(left["time_s"], left["kg"] * stay_s, over),
            self.by_cycle(left["time_s"], left["kg"], over),
        )
        edges = np.linspace(0, length_m, 4 * len(self.panels) + 1)
        along, places, _ = self.line_at_rest
        under = self.product("undersize") & self.within(left["time_s"])
        station = np.interp(left["position_m"][under] @ along, places, self.station_m)
        row = np.clip(np.digitize(station, edges) - 1, 0, len(edges) - 2)
        passed = np.bincount(row, left["kg"][under], len(edges) - 1)
        return {
            "residence_s": self.estimate(lambda s: divide(s[0], s[1]), columns),
            "residence_velocity_m_per_s": self.estimate(lambda s: length_m * divide(s[1], s[0]), columns),
            "passing": {
                "along_m": edges[:-1] + np.diff(edges) / 2,
                "rate_kg_per_s_m": passed / np.diff(edges) / (self.window_s[1] - self.window_s[0]),
            },
        }

    def even_rows(self, group: str, window_s: tuple[float, float] | None = None) -> Array:
        """The rows of a group in the window at whole multiples of the output interval."""
        time_s = self.data[f"{group}/time_s"]
        phase = time_s / self.case["output"]["interval_s"]
        return np.flatnonzero(self.within(time_s, window_s) & (np.abs(phase - np.round(phase)) < 1e-3))

    def mean_over(self, time_s: Array, part: Array, whole: Array | None = None) -> dict[str, Any]:
        """A mean over output times, or a sum over another."""
        cycle = self.cycle(time_s) - self.first
        columns = [np.bincount(cycle, v) for v in (part, np.ones(len(part)) if whole is None else whole)]
        return self.estimate(lambda s: divide(s[0], s[1]), np.stack(columns, axis=1), width=self.width)

    @cached_property
    def snapshots(self) -> dict[int, dict[str, Array]]:
        """The particles at each output time at which there are some, by the number of the output time."""
        files = sorted((self.folder / "particles").glob("*.vtu"))
        there = np.flatnonzero(self.data["bed/particles"])
        meshes = {int(number): meshio.read(files[number]) for number in there}
        return {k: {"place_m": np.asarray(m.points, float), **m.point_data} for k, m in meshes.items()}

    def located(self, number: int) -> tuple[dict[str, Array], dict[str, Array]]:
        """The particles of an output time, and the deck's line below them, straight from panel to panel."""
        grains, time_s = self.snapshots[number], self.data["bed/time_s"][number]
        row = np.argmin(np.abs(self.data[f"shapes/{self.panels[0]}/time_s"] - time_s))
        lines = [self.data[f"panels/{name}/centre_line_m"][number] for name in self.panels]
        speeds = [self.middle_line(name, "velocity_m_per_s")[row] for name in self.panels]
        line, speed = np.concatenate(lines), np.concatenate(speeds)
        along = self.line_at_rest[0]
        u, z, at = line @ along, line[:, 2], grains["place_m"] @ along
        piece = np.clip(np.searchsorted(u, at) - 1, 0, len(u) - 2)
        tangent = np.stack([np.diff(u), np.diff(z)], axis=1)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        cosine, sine = tangent[piece].T
        rise = np.interp(at, u, speed[:, 2]) * cosine - np.interp(at, u, speed @ along) * sine
        own = grains["velocity_m_per_s"][:, 2] * cosine - grains["velocity_m_per_s"] @ along * sine
        return grains, {
            "height_m": (grains["place_m"][:, 2] - np.interp(at, u, z)) * cosine,
            "station_m": np.interp(at, u, self.station_m),
            "inside": (at >= u[0]) & (at <= u[-1]),
            "rise_m_per_s": rise,
            "against_m_per_s": own - rise,
        }

    def middle_line(self, panel: str, what: str) -> Array:
        """The middle line (rows, points, 3) of the surface at every sync point."""
        across = self.case["panel"]["surface_cells"][1] + 1
        return self.data[f"shapes/{panel}/{what}"][:, across // 2 :: across]

    def profile(self, number: int) -> dict[str, Array]:
        """A row of the group ``profile``, from a snapshot."""
        grains, at = self.located(number)
        d = np.asarray(grains["sieve_size_m"], float)
        there = at["inside"] & (at["height_m"] > -d / 2)
        kg = np.pi / 6 * d**3 * grains["density_kg_per_m3"]
        edges = np.linspace(0, self.station_m[-1], 4 * len(self.panels) + 1)
        row = np.clip(np.digitize(at["station_m"], edges) - 1, 0, len(edges) - 2)
        along, over, level = self.line_at_rest
        ends = [np.interp(edges, self.station_m, v) for v in (over, level)]
        slope = np.stack([np.diff(v) for v in ends], axis=1)
        slope /= np.linalg.norm(slope, axis=1)[:, None]
        pair = np.stack([grains["velocity_m_per_s"] @ along, grains["velocity_m_per_s"][:, 2]], axis=1)
        speed = np.sum(pair * slope[row], axis=1)
        mass, velocity, depth = (np.full(len(edges) - 1, np.nan) for _ in range(3))
        for k in range(len(mass)):
            mine = there & (row == k)
            mass[k] = kg[mine].sum()
            if mine.any():
                velocity[k] = np.average(speed[mine], weights=kg[mine])
                top = at["height_m"][mine] + d[mine] / 2
                order = np.argsort(top)
                share = np.cumsum(kg[mine][order]) / mass[k]
                depth[k] = top[order][np.argmax(share >= 0.95 - 1e-9)]
        return {"mass_kg": mass, "velocity_m_per_s": velocity, "depth_m": depth}

    def bed_in_time(self, number: int) -> dict[str, Any]:
        """A row of the group ``bed``, from a snapshot."""
        grains = self.snapshots[number]
        kg = np.pi / 6 * np.asarray(grains["sieve_size_m"], float) ** 3 * grains["density_kg_per_m3"]
        velocity = np.asarray(grains["velocity_m_per_s"], float)
        return {
            "particles": len(kg),
            "mass_kg": kg.sum(),
            "mean_speed_m_per_s": np.average(np.linalg.norm(velocity, axis=1), weights=kg),
            "mean_velocity_m_per_s": np.average(velocity, axis=0, weights=kg),
            "highest_m": grains["place_m"][:, 2].max(),
        }

    def held_in_time(self) -> dict[str, Array]:
        """The group ``held``, from the snapshots: who lay at one place for five cycles on a quick panel, and
        went with it."""
        lying: dict[int, tuple[float, float, float, float]] = {}  # since, station, across, fastest
        openings, slow = self.openings(), G * self.cycle_s / (2 * np.pi)  # of a panel at one g
        table: dict[str, list[float]] = {"stickers": [], "mass_kg": [], "openings": []}
        for number in self.snapshots:
            time_s, (grains, at) = self.data["held/time_s"][number], self.located(number)
            now, held_kg, seats = {}, [], set()
            for k, i in enumerate(grains["id"].tolist()):
                d, height = float(grains["sieve_size_m"][k]), abs(at["height_m"][k])
                place = at["station_m"][k], float(grains["place_m"][k, 1])
                rise = abs(at["rise_m_per_s"][k])
                now[i] = time_s, *place, rise
                if at["inside"][k] and height < 0.75 * d and i in lying:
                    since, station, across, fastest = lying[i]
                    fastest = max(rise, fastest)
                    hops = abs(at["against_m_per_s"][k]) > 0.1 * max(fastest, slow)
                    if not hops and max(abs(place[0] - station), abs(place[1] - across)) < d / 2:
                        now[i] = since, station, across, fastest
                since, _, _, fastest = now[i]
                if time_s - since >= 5 * self.cycle_s and fastest > 1.25 * slow:
                    held_kg.append(np.pi / 6 * d**3 * float(grains["density_kg_per_m3"][k]))
                    if height < 0.75 * d / 2:
                        seats.add(int(np.argmin(np.hypot(*(openings - place).T))))
            lying = now
            for name, value in zip(table, (len(held_kg), sum(held_kg), len(seats)), strict=True):
                table[name].append(value)
        return {name: np.array(values) for name, values in table.items()}

    def openings(self) -> Array:
        """The stations and places across of the openings' centres, by the pattern of the case."""
        (row,) = self.case["screen"]["panels"].values()
        holes = row["apertures"]
        free_m, pitches = (row["length_m"], row["width_m"]), (holes["pitch_along_m"], holes["pitch_across_m"])
        counts = [int(free / pitch + 1e-9) for free, pitch in zip(free_m, pitches, strict=True)]
        span_m = row["length_m"] + row["tension_m"]
        along = span_m / 2 + (np.arange(counts[0]) - (counts[0] - 1) / 2) * pitches[0] * span_m / free_m[0]
        across = (
            row["corner_m"][1] + free_m[1] / 2 + (np.arange(counts[1]) - (counts[1] - 1) / 2) * pitches[1]
        )
        places = []
        for panel in range(row["count"]):
            x = row["corner_m"][0] + panel * row["pitch_m"] + along
            world = np.stack([x, 0 * x, 0 * x + row["corner_m"][2]], axis=1) @ self.deck.T
            station = np.interp(world[:, 0], self.line_at_rest[1], self.station_m)
            places += [(s, y) for s in station for y in across]
        return np.array(places)

    def bed(self) -> dict[str, Any]:
        rows = self.even_rows("profile")
        time_s, along_m = self.data["profile/time_s"][rows], self.data["profile/along_m"][0]
        mass, velocity, depth = (
            np.nan_to_num(self.data[f"profile/{name}"][rows])
            for name in ("mass_kg", "velocity_m_per_s", "depth_m")
        )
        momentum = mass * velocity
        panels = self.case["screen"]["panels"].values()
        widths, lengths = zip(*((row["width_m"], row["length_m"]) for row in panels), strict=True)
        area_m2 = self.station_m[-1] * np.average(widths, weights=lengths)
        return {
            "output_times": len(rows),
            "particles": self.data["bed/particles"][rows].mean(),
            "on_deck_kg": self.mean_over(time_s, mass.sum(axis=1)),
            "load_kg_per_m2": self.mean_over(time_s, mass.sum(axis=1) / area_m2),
            "velocity_m_per_s": self.mean_over(time_s, momentum.sum(axis=1), mass.sum(axis=1)),
            "mean_depth_m": self.mean_over(time_s, depth.mean(axis=1)),
            "largest_depth_m": self.mean_over(time_s, depth.max(axis=1)),
            "profile": {
                "along_m": along_m,
                "mass_kg_per_m": mass.mean(axis=0) / np.diff(along_m)[0],
                "velocity_m_per_s": [divide(p, m) for p, m in zip(momentum.sum(0), mass.sum(0), strict=True)],
                "depth_m": depth.mean(axis=0),
            },
        }

    def held(self) -> dict[str, Any]:
        rows = self.even_rows("held")
        rows = rows[self.data["held/time_s"][rows] >= 5 * self.cycle_s * (1 - NEAR)]
        time_s = self.data["held/time_s"][rows]
        names = {"stickers": "stickers", "sticking_kg": "mass_kg", "blinded_openings": "openings"}
        means = {name: self.mean_over(time_s, self.data[f"held/{of}"][rows]) for name, of in names.items()}
        on_deck = np.nan_to_num(self.data["profile/mass_kg"][rows]).sum(axis=1)
        pegged, blinded = (self.data[f"held/{of}"][rows] for of in ("pegged_kg", "openings"))
        openings = len(self.openings())
        shares = {
            "pegged_percent": self.mean_over(time_s, 100 * pegged, on_deck),
            "blinded_percent": self.mean_over(time_s, 100 * blinded, np.full(len(rows), float(openings))),
        }
        return {"openings": openings, **means, **shares}

    def wear(self) -> dict[str, Any]:
        table, profile = {}, []
        for number, name in enumerate(self.panels):
            time_s = self.data[f"wear/{name}/time_s"]
            rows = self.even_rows(f"wear/{name}", self.moves_s)
            if rows[0] and time_s[rows[0] - 1] >= self.moves_s[0] - 1e-9:
                rows = np.append(rows[0] - 1, rows)
            time_s, hours = time_s[rows], np.ptp(time_s[rows]) / 3600
            mean, depth = (self.data[f"wear/{name}/{what}"][rows] for what in ("mean_m", "depth_m"))
            rate = (depth[-1] - depth[0]) / hours
            row, column = divmod(int(rate.argmax()), rate.shape[1])
            cycle = np.searchsorted(time_s[0] + self.edges_s[1:], time_s[1:] - NEAR * self.cycle_s)
            columns = [np.bincount(cycle, np.diff(v)) for v in (mean, time_s / 3600)]
            (described,) = self.case["screen"]["panels"].values()
            table[name] = {
                "worn_m3": self.data[f"wear/{name}/worn_m3"][-1],
                "mean_m_per_h": self.estimate(lambda s: s[0] / s[1], np.stack(columns, axis=1)),
                "largest_m_per_h": rate.max(),
                "largest_at": [(row + 0.5) / rate.shape[0], (column + 0.5) / rate.shape[1]],
                "worn_through_h": described["thickness_m"] / rate.max(),
                "depth_m_per_h": rate,
            }
            points = len(self.station_m) // len(self.panels)
            low, high = self.station_m[[number * points, (number + 1) * points - 1]]
            middle = (np.arange(len(rate)) + 0.5) / len(rate)
            profile.append((low + middle * (high - low), rate.mean(axis=1)))
        along, mean_rate = (np.concatenate(values) for values in zip(*profile, strict=True))
        ends = {"start_s": time_s[0], "end_s": time_s[-1]}
        return {**ends, "panels": table, "profile": {"along_m": along, "mean_m_per_h": mean_rate}}

    # ------------------------------------------------------------------ the machine

    @cached_property
    def time_s(self) -> Array:
        """The times of all sync points."""
        return self.data[f"frames/{self.frames[0]}/time_s"]

    def shafts(self, window_s: tuple[float, float]) -> dict[str, float]:
        """The mean speeds of motors' shafts: a straight line through their angles."""
        start_s, end_s = window_s
        rows = (self.time_s > start_s + NEAR * self.cycle_s) & (self.time_s <= end_s + NEAR * self.cycle_s)
        names = [name.split("/")[1] for name in self.data if name.startswith("shafts/") and "angle" in name]
        angles = {name: self.data[f"shafts/{name}/angle_rad"][rows] for name in names}
        t = self.time_s[rows]
        return {name: float(np.cov(t, angle)[0, 1] / np.var(t, ddof=1)) for name, angle in angles.items()}

    def turn_s(self, window_s: tuple[float, float]) -> float:
        """The period of the slowest shaft, by its own speed where a motor turns it."""
        speeds = {name: row["speed_rad_per_s"] for name, row in self.case["screen"]["exciters"].items()}
        shafts = self.shafts(window_s)
        if shafts and min(shafts.values()) * (window_s[1] - window_s[0]) >= 2 * np.pi:
            speeds |= shafts
        return 2 * np.pi / min(speeds.values())

    def harmonic(self, values: Array) -> Motion:
        return Motion(self.time_s, values, self.turn_s(self.moves_s), self.moves_s, self.width)

    @cached_property
    def pairs(self) -> dict[str, Array]:
        moved = {name: self.data[f"frames/{name}/displacement_m"] @ self.deck for name in self.frames}
        return {
            f"{second}-{first}": moved[second] - moved[first]
            for k, first in enumerate(self.frames)
            for second in self.frames[k + 1 :]
        }

    def motion(self) -> dict[str, Any]:
        probes = self.case["probes"]
        moved = {name: self.data[f"frames/{name}/displacement_m"] for name in self.frames}
        moved |= {n: self.data[f"probes/{n}/position_m"] for n, row in probes.items() if "frame" in row}
        single = {name: self.harmonic(place @ self.deck) for name, place in moved.items()}
        pairs = {name: self.harmonic(place) for name, place in self.pairs.items()}
        largest = max(np.abs(harmonic.phasor).max() for harmonic in single.values())
        drift = max(harmonic.change for harmonic in single.values()) / largest
        self.is_settled = bool(drift <= 0.05 and self.change_of_ranges() <= 0.05)
        return {
            "start_s": self.moves_s[0],
            "end_s": self.moves_s[1],
            "cycles": self.last - self.begin,
            "frames": {name: harmonic.table() for name, harmonic in single.items()},
            "relative": {
                name: harmonic.table() | {"along_m": harmonic.estimate(0)} for name, harmonic in pairs.items()
            },
            "drift": drift,
            "speed_rad_per_s": 2 * np.pi / self.turn_s(self.moves_s),
            "shafts_rad_per_s": self.shafts(self.moves_s),
            "ground": self.ground(),
            "run_down": None,
            "panel_points": {
                name: self.panel_point(name, row) for name, row in probes.items() if "panel" in row
            },
            "panels": {name: self.panel(name) for name in self.panels},
            "is_settled": self.is_settled,
            "reason": "" if self.is_settled else "it changes",
        }

    def change_of_ranges(self) -> float:
        """The largest change of a frame's range in a cycle, from the window's first half to its second."""
        changes = []
        for name in self.frames:
            moved = self.data[f"frames/{name}/displacement_m"]
            parts = [moved[self.cycle(self.time_s) == k] for k in range(self.begin, self.last)]
            ranges = np.array([np.linalg.norm(part.max(axis=0) - part.min(axis=0)) for part in parts])
            early, late = ranges[: len(ranges) // 2].mean(), ranges[-(len(ranges) // 2) :].mean()
            changes.append(abs(late - early) / early)
        return float(max(changes))

    def bushings(self) -> list[tuple[str, dict[str, Any], Array, Array]]:
        """All single bushings: name, table, place and axes (columns) in the world.

        The axes are turned from the deck's about its x axis, then its y axis, then its z axis.
        """
        rows = []
        for name, row in self.case["screen"]["bushings"].items():
            turn = self.deck
            for axis, angle_deg in reversed([*zip("xyz", row["rotation_deg"], strict=True)]):
                turn = turn @ Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
            for k, place in enumerate(row["positions_m"]):
                own = name if len(row["positions_m"]) == 1 else f"{name}-{k + 1}"
                rows.append((own, row, self.deck @ place, turn))
        return rows

    def carried(self, frame: str, place_m: Array) -> tuple[Array, Array, Rotation]:
        """The motion of a place on a frame: displacement and velocity (rows, 3), and the frame's rotation."""
        if frame == "ground":
            still = np.zeros((len(self.time_s), 3))
            return still, still, Rotation.from_rotvec(still)
        moved, velocity, turned, spin = (
            self.data[f"frames/{frame}/{what}"]
            for what in ("displacement_m", "velocity_m_per_s", "rotation_rad", "spin_rad_per_s")
        )
        rotation = Rotation.from_rotvec(turned)
        arm = place_m - self.deck @ self.case["screen"]["frames"][frame]["center_of_mass_m"]
        turned_arm = rotation.apply(arm)
        return moved + turned_arm - arm, velocity + np.cross(spin, turned_arm), rotation

    def deformation(self, row: dict[str, Any], place_m: Array, turn: Array) -> tuple[Array, Array]:
        """The deformation of a bushing along its axes, which turn with its first body, and its rate."""
        first, second = (self.carried(frame, place_m) for frame in row["between"])
        apart, rate, back = second[0] - first[0], second[1] - first[1], first[2].inv()
        return back.apply(apart) @ turn, back.apply(rate) @ turn

    def ground(self) -> dict[str, Any]:
        force = np.zeros((len(self.time_s), 3))
        for name, row, _, turn in self.bushings():
            first, second = row["between"]
            own = self.data[f"bushings/{name}/force_N"] @ turn.T
            if first == "ground":
                force += own  # what holds the second end pushes the first body
            elif second == "ground":
                force -= Rotation.from_rotvec(self.data[f"frames/{first}/rotation_rad"]).apply(own)
        wave, inside = self.harmonic(force), force[self.within(self.time_s, self.moves_s)]
        return {
            "amplitude_N": {axis: wave.estimate(k) for k, axis in enumerate("xyz")},
            "mean_N": inside.mean(axis=0),
            "largest_N": np.abs(inside - inside.mean(axis=0)).max(axis=0),
        }

    @property
    def step_s(self) -> float:
        """The sync interval."""
        return float(np.mean(np.diff(self.time_s)))

    def acceleration(self, name: str) -> Array:
        """The acceleration (rows, 3) of a frame's centre of mass or of a probe."""
        group = "frames" if name in self.frames else "probes"
        return acceleration(self.data[f"{group}/{name}/velocity_m_per_s"], self.step_s)

    def panel_point(self, name: str, row: dict[str, Any]) -> dict[str, Any]:
        step_s, all_g = self.step_s, self.acceleration(name) / G
        rows = self.within(self.time_s, self.moves_s)
        size = np.sqrt(np.sum(all_g**2, axis=1))
        normal = np.abs(all_g[rows] @ self.deck[:, 2])
        cycles = [size[rows & (self.cycle(self.time_s) == k)] for k in range(self.begin, self.last)]
        slow_g = acceleration(self.data[f"probes/{name}/velocity_m_per_s"], step_s, 100.0) / G
        slow_size = np.sqrt(np.sum(slow_g**2, axis=1))
        slow = [slow_size[rows & (self.cycle(self.time_s) == k)] for k in range(self.begin, self.last)]

        def mean(values: list[float]) -> dict[str, Any]:
            columns = np.stack([values, np.ones(len(values))], axis=1)
            return estimate(lambda s: s[0] / s[1], columns, width=self.width)

        rms, square = float(np.sqrt(np.mean(size[rows] ** 2))), mean([np.mean(c**2) for c in cycles])
        width = times(0.5 / rms, (square["half_width"], square.get("standard_error")))
        return {
            "panel": row["panel"],
            "at": row["at"],
            "band_Hz": min(500.0, 0.5 / step_s),
            "peak_g": size[rows].max(),
            "rms_g": with_width(rms, square["batches"], width),
            "peak_normal_g": normal.max(),
            "rms_normal_g": np.sqrt(np.mean(normal**2)),
            "cycle_peak_g": mean([c.max() for c in cycles]),
            "cycle_peak_100_Hz_g": mean([c.max() for c in slow]),
        }

    def in_cycles(self, values: Array, of: Callable[[Array], Any]) -> Array:
        """A statistic of the sync points of each cycle, of the last and perhaps cut one, too.

        The start belongs to the first cycle.
        """
        cycle = self.cycle(self.time_s)
        return np.array([of(values[cycle == k]) for k in range(cycle.max() + 1)])

    def panel_cycles(self, name: str) -> dict[str, Array]:
        """The rows of the group ``panel_cycles/<name>``."""
        first, second, load = (
            self.data[f"forces/{name}/{what}_N"] for what in ("first_clamp", "second_clamp", "load")
        )
        pull, line = (first - second) @ self.deck[:, 0] / 2, self.middle_line(name, "position_m")
        sizes = np.maximum(*(np.linalg.norm(force, axis=1) for force in (first, second)))
        chord = (line[:, -1] - line[:, 0]) @ self.deck
        upright = np.stack([-chord[:, 2], 0 * chord[:, 1], chord[:, 0]], axis=1)
        upright /= np.linalg.norm(upright, axis=1)[:, None]
        height = np.einsum("tpi,ti->tp", (line - line[:, :1]) @ self.deck, upright)
        middle, stretch = height[:, line.shape[1] // 2], self.stretch(name)
        least, most = (lambda v: v.min(axis=0)), (lambda v: v.max(axis=0))
        columns = {
            "sync_points": (pull, len),
            "pull_least_N": (pull, least),
            "pull_mean_N": (pull, np.mean),
            "pull_most_N": (pull, most),
            "clamp_most_N": (sizes, most),
            "load_mean_N": (load, lambda v: v.mean(axis=0)),
            "stretch_least": (stretch, least),
            "stretch_most": (stretch, most),
            "sag_most_m": (np.abs(height).max(axis=1), most),
            "middle_least_m": (middle, least),
            "middle_most_m": (middle, most),
        }
        return {column: self.in_cycles(values, of) for column, (values, of) in columns.items()}

    def point_cycles(self, name: str) -> dict[str, Array]:
        """The rows of the group ``point_cycles/<name>``."""
        group, what = ("frames", "displacement_m") if name in self.frames else ("probes", "position_m")
        moved = self.data[f"{group}/{name}/{what}"] - self.data[f"{group}/{name}/{what}"][0]
        speed = np.linalg.norm(self.data[f"{group}/{name}/velocity_m_per_s"], axis=1)
        return {
            "sync_points": self.in_cycles(moved, len),
            "least_m": self.in_cycles(moved, lambda v: v.min(axis=0)),
            "mean_m": self.in_cycles(moved, lambda v: v.mean(axis=0)),
            "most_m": self.in_cycles(moved, lambda v: v.max(axis=0)),
            "farthest_m": self.in_cycles(np.linalg.norm(moved, axis=1), np.max),
            "fastest_m_per_s": self.in_cycles(speed, np.max),
        }

    def stretch(self, name: str) -> Array:
        """The mean strain of a panel's middle line at every sync point, beside its clamps."""
        pieces = np.linalg.norm(np.diff(self.middle_line(name, "position_m"), axis=1), axis=2)
        (row,) = self.case["screen"]["panels"].values()
        return np.asarray((pieces.sum(axis=1) - 2 * row["clamp_m"]) / row["length_m"] - 1)

    def panel(self, name: str) -> dict[str, Any]:
        """The figures of a panel, from all sync points in the window."""
        rows = self.within(self.time_s, self.moves_s)
        first, second, load = (
            self.data[f"forces/{name}/{what}_N"][rows] for what in ("first_clamp", "second_clamp", "load")
        )
        pull = (first - second) @ self.deck[:, 0] / 2
        stretch = self.stretch(name)
        return {
            "tension_mean_N": pull.mean(),
            "tension_largest_N": pull.max(),
            "tension_smallest_N": pull.min(),
            "largest_clamp_force_N": max(np.linalg.norm(f, axis=1).max() for f in (first, second)),
            "stretch_largest_percent": 100 * stretch[rows].max(),
            "stretch_smallest_percent": 100 * stretch[rows].min(),
            "load_N": load.mean(axis=0) @ self.deck,
            **self.turns(name),
            "strain_range_percent": 100 * self.mean_range(name),
            "fatigue_share": None,
        }

    def mean_range(self, name: str) -> float:
        """The mean range of strain by the four-point method, which leaves a residue of half cycles."""
        cycles = self.panel_cycles(name)
        ends = [cycles[f"stretch_{end}"][self.begin : self.last] for end in ("least", "most")]
        series = np.stack(ends, axis=1).ravel()
        turns = np.flatnonzero(np.diff(np.sign(np.diff(series))) != 0) + 1
        left: list[float] = []
        ranges, counts = [], []
        for value in (series[0], *series[turns], series[-1]):
            left.append(float(value))
            while len(left) >= 4 and abs(left[-2] - left[-3]) <= min(
                abs(left[-1] - left[-2]), abs(left[-3] - left[-4])
            ):
                ranges.append(abs(left[-2] - left[-3]))
                counts.append(1.0)
                del left[-3:-1]
        ranges += list(np.abs(np.diff(left)))
        counts += [0.5] * (len(left) - 1)
        return float(np.average(ranges, weights=counts))

    def turns(self, name: str) -> dict[str, Any]:
        """The share of turns up, and after how many turns lowest and highest middle are as they were."""
        (row,) = self.case["screen"]["panels"].values()
        cycles = self.panel_cycles(name)
        least, most = (cycles[f"middle_{end}_m"][self.begin : self.last] for end in ("least", "most"))
        up = (least + most > 0) & (most >= 0.02 * row["length_m"])
        ends = np.stack([least, most])
        after = [
            n
            for n in range(1, min(8, len(up) // 2) + 1)
            if np.sum((ends[:, n:] - ends[:, :-n]) ** 2) / (len(up) - n)
            <= 0.01 * np.sum((ends - ends.mean()) ** 2) / len(up)
        ]
        return {"turns_up_share": np.mean(up), "repeats_after_turns": min(after, default=None)}

    def power(self) -> dict[str, Any]:
        """Differences of the ledger between the last sync points of cycles, and what was fed between them."""
        ledger = {n.split("/")[1]: v for n, v in self.data.items() if n.startswith("energy_cycles/")}
        ends = self.edges_s[self.begin : self.last + 1]
        rows = [int(np.flatnonzero(ledger["time_s"] <= end + NEAR * self.cycle_s)[-1]) for end in ends]
        time_s = ledger["time_s"][rows]
        paid = [f"supplied.frames.{kind}_J" for kind in ("exciter", "motor", "drive")]
        drives = sum(
            (np.diff(ledger[name][rows]) for name in paid if name in ledger), np.zeros(len(ends) - 1)
        )
        pairs = [*pairwise(time_s)]
        fed_s = self.fed["time_s"] - NEAR * self.cycle_s
        fed = [self.fed["kg"][(fed_s > a) & (fed_s < b)].sum() for a, b in pairs]

        def over(work: Array, whole: Sequence[float] | Array) -> dict[str, Any]:
            steady = self.is_steady and self.is_settled
            columns = np.stack([work, whole], axis=1)
            return estimate(lambda s: divide(s[0], s[1]), columns, None, steady, self.width)

        return {
            "start_s": time_s[0],
            "end_s": time_s[-1],
            "drives_W": over(drives, np.diff(time_s)),
            "lost_W": {
                name[5:-2]: over(np.diff(values[rows]), np.diff(time_s))
                for name, values in ledger.items()
                if name.startswith("lost.")
            },
            "drives_J_per_kg": over(drives, fed),
        }

    def course(self) -> dict[str, Any]:
        """Windows of twelve cycles, the last of which ends at the run's last whole cycle."""
        ends = self.edges_s[self.cycles % 12 :: 12]
        windows = [*pairwise(ends.tolist())]
        relative = {}
        for name, place in self.pairs.items():
            fits = [Motion(self.time_s, place[:, :1], self.turn_s(each), each) for each in windows]
            relative[name] = {
                "along_m": [abs(fit.phasor[0]) for fit in fits],
                "half_width_m": [fit.widths[0][0] for fit in fits],
            }
        time_s, close = self.data["profile/time_s"], NEAR * self.cycle_s
        mass, velocity = (np.nan_to_num(self.data[f"profile/{n}"]) for n in ("mass_kg", "velocity_m_per_s"))
        parts = [(time_s > a + close) & (time_s <= b + close) for a, b in windows]
        on_deck = np.array([mass[part].sum(axis=1).mean() for part in parts])
        momentum = np.array([(mass * velocity)[part].sum(axis=1).mean() for part in parts])
        speeds = [number(divide(p, m)) for p, m in zip(momentum, on_deck, strict=True)]
        return {"end_s": ends[1:], "relative": relative, "on_deck_kg": on_deck, "velocity_m_per_s": speeds}

    def results(self) -> dict[str, Any]:
        """The whole table."""
        motion = self.motion()
        return {
            "missing": {},
            "failed": {},
            "share_of_width": 1.0,
            "steady": self.steady(),
            "screening": self.screening() | {"whole_feed": self.whole_feed()},
            "contacts": self.contacts(),
            "transport": self.transport(),
            "bed": self.bed(),
            "held": self.held(),
            "motion": motion,
            "course": self.course(),
            "wear": self.wear(),
            "power": self.power(),
        }

    def probes(self) -> dict[str, Any]:
        """The table ``probes`` of the summary, from the rows of every sync point."""
        last = self.edges_s[-1] - 2 * self.cycle_s, self.edges_s[-1]
        close = NEAR * self.cycle_s
        rows = (self.time_s > last[0] + close) & (self.time_s <= last[1] + close)
        table = {}
        groups = {name: (f"frames/{name}", "displacement_m") for name in self.frames}
        groups |= {name: (f"probes/{name}", "position_m") for name in self.case["probes"]}
        for name, (group, what) in groups.items():
            moved = self.data[f"{group}/{what}"] - self.data[f"{group}/{what}"][0]
            table[name] = {
                "half_range_m": (moved[rows].max(axis=0) - moved[rows].min(axis=0)) / 2,
                "mean_m": moved[rows].mean(axis=0),
                "peak_m": np.linalg.norm(moved[1:], axis=1).max(),
                "peak_speed_m_per_s": np.linalg.norm(
                    self.data[f"{group}/velocity_m_per_s"][1:], axis=1
                ).max(),
                "reason": "",
            }
        return table


def differences(ours: Any, theirs: Any, where: str = "", tolerance: float = 1e-9) -> list[str]:
    """Return where two tables differ: in their keys, or in a number or list by more than a share of its
    size.

    Of reasons it only counts whether there is one.
    """
    if isinstance(theirs, dict) and isinstance(ours, dict):
        texts = [f"{where}.{key}: not in both" for key in sorted(ours.keys() ^ theirs.keys())]
        pairs = {key: (ours[key], theirs[key]) for key in ours.keys() & theirs.keys()}
    elif isinstance(theirs, list) and theirs and isinstance(theirs[0], dict):
        texts = [] if len(ours) == len(theirs) else [f"{where}: {len(ours)} rows and {len(theirs)}"]
        pairs = {str(number): pair for number, pair in enumerate(zip(ours, theirs, strict=False))}
    elif where.endswith("reason") or theirs is None or ours is None or isinstance(theirs, str | bool):
        same = bool(ours) == bool(theirs) if where.endswith("reason") else ours == theirs
        return [] if same else [f"{where}: {ours}, and the run says {theirs}"]
    else:
        own, other = (np.array(value, float) for value in (ours, theirs))
        if own.shape != other.shape:
            return [f"{where}: {own.shape}, and the run has {other.shape}"]
        limit = tolerance * np.nanmax(np.abs(other), initial=0.0)
        close = np.isclose(own, other, rtol=0.0, atol=limit, equal_nan=True)
        return [] if close.all() else [f"{where}: {own.tolist()}, and the run says {other.tolist()}"]
    for key, pair in pairs.items():
        texts += differences(*pair, f"{where}.{key}".lstrip("."), tolerance)
    return texts
