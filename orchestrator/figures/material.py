"""The tables of what happens to the material: steady state, screening, contacts, transport and bed.

docs/theory/screening.md has the definitions, methods and sources.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import PlainValidator

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.figure import figure
from orchestrator.ports import Array

Numbers = Annotated[Array, PlainValidator(lambda values: np.array(values, dtype=float))]
"""An array, which is a list in JSON; NaN is null."""


@dataclass(frozen=True, kw_only=True)
class Steady:
    """The cycles over which figures of bed and screening are averaged."""

    is_steady: bool = figure(
        "whether there is a steady state", "else they cover the whole run, without intervals"
    )
    reason: str = figure("why not, or empty")
    start_s: float = figure("beginning of the first averaged cycle")
    end_s: float = figure("end of the last one")
    cycles: int = figure("number of averaged cycles", "0 without a drive")
    imbalance_percent: float | None = figure(
        "in less out", "of the mass in these cycles, over what came in; null if nothing was fed"
    )
    drift_percent: float | None = figure("slope of the hold-up over the rate of feed")


@dataclass(frozen=True, kw_only=True)
class FlowsInTime:
    """The mass flows of each cycle."""

    time_s: Numbers = figure("end of each cycle")
    feed_kg_per_s: Numbers = figure("feed", is_extensive=True)
    undersize_kg_per_s: Numbers = figure("undersize", is_extensive=True)
    oversize_kg_per_s: Numbers = figure("oversize", is_extensive=True)
    hold_up_kg: Numbers = figure("hold-up at the end of the cycle", is_extensive=True)


@dataclass(frozen=True, kw_only=True)
class CohortShares:
    """Grains fed so early that nearly all have left; `reason` has the interval of their chance."""

    fed_until_s: float = figure("time until which they were fed")
    remaining_percent: float = figure("share of their mass that has not left")
    particles: int = figure("number of those that have")
    efficiency_percent: Estimate | None = figure(
        "screening efficiency η", optional=True, resolution=0.1, is_of_cut=True
    )
    fine_placement_percent: Estimate | None = figure("undersize recovery", optional=True, is_of_cut=True)
    oversize_yield_percent: Estimate | None = figure("oversize yield", optional=True)


@dataclass(frozen=True, kw_only=True)
class Section:
    """The shares of mass at an exit for undersize."""

    exit: str = figure("exit")
    yield_percent: Estimate = figure("yield", "what passes there over the feed")
    cumulative_efficiency_percent: Estimate | None = figure(
        "efficiency up to here", "fines passed so far over those of the feed", optional=True, is_of_cut=True
    )
    local_efficiency_percent: Estimate | None = figure(
        "local efficiency", "fines that pass there over those that arrive", optional=True, is_of_cut=True
    )


@dataclass(frozen=True, kw_only=True)
class Partition:
    """The partition curve, in size classes."""

    edges_m: Numbers = figure("edges of the classes", shown_in="mm")
    mean_m: Numbers = figure("mean sizes", shown_in="mm")
    particles: Numbers = figure("numbers of particles")
    feed_percent: Numbers = figure("shares of the feed")
    oversize_percent: Numbers = figure("partition numbers", "share of each class that stays above")
    d50_m: Estimate = figure("cut size reached, d50", shown_in="mm")
    ep_m: Estimate = figure("probable error Ep", shown_in="mm")


@dataclass(frozen=True, kw_only=True)
class Continuation:
    """How far the partition curve is continued, and by what it is wrong there."""

    factor: float = figure("ratio of sizes over which the curve is continued")
    tested_factor: float = figure(
        "same in the test", "from the coarser half of the computed fines to the finer"
    )
    tested_error_percent: float = figure("what the curve of the coarser half lets pass too much of the finer")
    error_percent: float = figure(
        "error of `fine_placement_percent` that follows, in points",
        "beyond a factor of 2 with the bounds of what passes",
    )


@dataclass(frozen=True, kw_only=True)
class WholeFeedSection:
    """The fines of the whole feed at an exit for undersize."""

    exit: str = figure("exit")
    cumulative_efficiency_percent: Estimate = figure("efficiency up to here")
    yield_percent: Estimate = figure("yield", "the fines that pass there over the whole feed")


@dataclass(frozen=True, kw_only=True)
class Curve:
    """The partition curve between the openings' width and the finest fed size."""

    attempts: float = figure("attempts to pass")
    exponent: float = figure("exponent")
    opening_m: float = figure("width of the openings")
    open_share: float = figure("open share of the deck")
    sieve_size_m: Numbers = figure("sieve sizes")
    oversize_percent: Numbers = figure("partition numbers")


@dataclass(frozen=True, kw_only=True)
class WholeFeed:
    """The run's fines with those that `smallest_fed_m` leaves out. Openings must have one width, and the
    continuation be within 25 points, which half widths include."""

    left_out_percent: float = figure("share of the feed's mass that is not computed")
    smallest_computed_m: float = figure("finest size that is computed")
    smallest_m: float = figure("finest size of the feed", "down to which the curve is continued")
    fines_percent: float = figure("share of the feed's mass that is fine")
    fine_placement_percent: Estimate = figure("undersize recovery", "share of all fines that pass")
    efficiency_percent: Estimate = figure(
        "screening efficiency η", "less the coarse particles that pass", resolution=0.1
    )
    continuation: Continuation = figure("how far the curve is continued, and how well")
    sections: list[WholeFeedSection] = figure("each exit for undersize")
    curve: Curve | None = figure(
        "partition curve",
        ("between the openings' width and the finest size; null if the particles do not determine it"),
    )


@dataclass(frozen=True, kw_only=True)
class Screening:
    """The feed and the products. Shares are of the feed as listed ([why](theory/screening.md#separation)),
    `*_kg_per_s` and `hold_up_kg` of what is computed."""

    cut_size_m: float | None = figure(
        "size below which a particle is fine",
        "`output.cut_size_m`, else the openings' smaller side",
        shown_in="mm",
    )
    lost_particles: int = figure("particles lost", "elsewhere than through an exit")
    particles: int = figure("number of particles that left through an exit in the averaged cycles")
    fine_particles: int | None = figure(
        "number of these that are fine", "null without a cut size", is_of_cut=True
    )
    feed_kg_per_s: Estimate = figure("feed", is_extensive=True, resolution=1e-6, shown_in="t/h")
    undersize_kg_per_s: Estimate = figure("undersize", is_extensive=True, resolution=1e-6, shown_in="t/h")
    oversize_kg_per_s: Estimate = figure("oversize", is_extensive=True, resolution=1e-6, shown_in="t/h")
    hold_up_kg: Estimate = figure("hold-up in the machine", "fed and not left", is_extensive=True)
    in_time: FlowsInTime = figure("in each cycle")
    efficiency_percent: Estimate | None = figure(
        "screening efficiency η",
        "fine plus coarse placement less 100; like the next five with a cut size",
        optional=True,
        resolution=0.1,
        is_of_cut=True,
    )
    fine_placement_percent: Estimate | None = figure(
        "undersize recovery",
        "fine placement, the share of the fines that pass",
        optional=True,
        is_of_cut=True,
    )
    recovered_percent: Estimate | None = figure(
        "fines recovered, of what came in",
        "fines on the deck are not",
        optional=True,
        resolution=0.1,
        is_of_cut=True,
    )
    coarse_placement_percent: Estimate | None = figure(
        "coarse placement",
        "share of the coarse that stays above; null if none left",
        optional=True,
        is_of_cut=True,
    )
    misplaced_percent: Estimate | None = figure(
        "misplaced material", "fines above and coarse below, over the feed", optional=True, is_of_cut=True
    )
    fines_in_oversize_percent: Estimate | None = figure(
        "fines left in the oversize", "its share that is fine", optional=True, is_of_cut=True
    )
    oversize_yield_percent: Estimate = figure("oversize yield", "over the feed")
    cohort: CohortShares | None = figure(
        "of a run that is fed and not steady", "else `missing` says why", optional=True
    )
    sections: list[Section] = figure("each exit for undersize")
    partition: Partition | None = figure("partition curve", "null as long as nothing has left")
    whole_feed: WholeFeed | None = figure(
        "separation of the whole feed",
        "where `smallest_fed_m` leaves out fines",
        optional=True,
        is_of_cut=True,
    )


@dataclass(frozen=True, kw_only=True)
class PanelContacts:
    """The contacts of fine particles with a panel of the deck."""

    panel: str = figure("panel")
    came_percent: float = figure("of all fines come", "to the panel")
    stay_s: float = figure("stay of those that go on", "mean time over it")
    contacts_per_s: float = figure("contacts")
    within_reach_percent: float = figure("within reach")
    chance_percent: float = figure("chance of a contact")
    geometric_percent: float = figure("geometric")
    rate_per_s: float = figure("rate k")
    passed_percent: float = figure("passed up to here", "to its end")


@dataclass(frozen=True, kw_only=True)
class RateFit:
    """The rate *k* with which 1 − exp(−*k t*) fits the shares passed."""

    rate_per_s: float = figure("rate")
    rms_percent: float = figure("root mean square of what it leaves over")
    time_s: Numbers = figure("sum of `stay_s` up to each panel's end")
    passed_percent: Numbers = figure("share passed by the fit")


@dataclass(frozen=True, kw_only=True)
class ContactSizes:
    """The contacts over the whole deck in size classes."""

    mean_m: Numbers = figure("mean sizes", shown_in="mm")
    particles: Numbers = figure("numbers of particles")
    contacts_per_s: Numbers = figure("contacts")
    within_reach_percent: Numbers = figure("within reach")
    chance_percent: Numbers = figure("chance of a contact")
    geometric_percent: Numbers = figure("geometric")
    rate_per_s: Numbers = figure("rate k")


@dataclass(frozen=True, kw_only=True)
class Contacts:
    """Why so much of the fines passes ([definitions](theory/screening.md#why-so-much-passes)): of those that
    left in the averaged cycles, or the cohort."""

    particles: int = figure("number of fine particles")
    counted_percent: float = figure(
        "share of their mass that passed after a contact", "the fine placement without what fell elsewhere"
    )
    rebuilt_percent: float = figure(
        "same, rebuilt from `along` (`stay_s`, `contacts_per_s`) and the chances of `sizes`"
    )
    stay_s: Estimate = figure("time over the deck of the fines that go over its end", resolution=1e-3)
    contacts_per_s: Estimate = figure(
        "contacts of a fine particle with the open mat", "in a second over the deck", resolution=1e-2
    )
    within_reach_percent: Estimate = figure(
        "time of the fines within reach of the mat", "gap below an opening's width", resolution=1e-2
    )
    chance_percent: Estimate = figure(
        "chance of a fine particle to pass in a contact", "passed over contacts", resolution=0.1
    )
    geometric_percent: Estimate = figure(
        "geometric chance", "of spheres that fall straight onto openings (Gaudin)"
    )
    rate_per_s: Estimate = figure(
        "rate at which fines pass", "contacts a second times chance", resolution=1e-3
    )
    along: list[PanelContacts] = figure("each panel, in the deck's order")
    fit: RateFit = figure("rate *k* with which 1 − exp(−*k t*) fits best")
    sizes: ContactSizes = figure("same in size classes")


@dataclass(frozen=True, kw_only=True)
class Passing:
    """The undersize along the deck."""

    along_m: Numbers = figure("middles of the bins along the deck")
    rate_kg_per_s_m: Numbers = figure("passing rate", is_extensive=True)


@dataclass(frozen=True, kw_only=True)
class Transport:
    """How long the oversize stays, and where the undersize passes."""

    residence_s: Estimate = figure("residence time of the oversize", "without a bed at the start")
    residence_velocity_m_per_s: Estimate | None = figure(
        "velocity from it", "deck's length over it", optional=True
    )
    passing: Passing | None = figure("along the deck", optional=True)


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Means along the deck."""

    along_m: Numbers = figure("distance along the deck")
    mass_kg_per_m: Numbers = figure("bed mass", is_extensive=True)
    velocity_m_per_s: Numbers = figure("velocity")
    depth_m: Numbers = figure("95 % lies below", shown_in="mm")


@dataclass(frozen=True, kw_only=True)
class Bed:
    """Means of the bed over output times."""

    output_times: int = figure("number of output times")
    particles: float = figure("mean number of particles in them")
    on_deck_kg: Estimate = figure("mass on the deck", is_extensive=True, resolution=1e-6)
    load_kg_per_m2: Estimate = figure("load per area of the deck")
    velocity_m_per_s: Estimate = figure(
        "material velocity", "along the deck, weighted by mass", resolution=1e-3
    )
    mean_depth_m: Estimate = figure(
        "height below which 95 % of the material lies, mean along the deck",
        "with thrown particles",
        shown_in="mm",
        resolution=1e-4,
    )
    largest_depth_m: Estimate = figure(
        "largest depth of the bed", "of that height along the deck", shown_in="mm", resolution=1e-4
    )
    profile: Profile = figure("along the deck")


@dataclass(frozen=True, kw_only=True)
class BulkMean:
    """The grains in a box of `[bulk]`, as means over the output times in the second half of the run."""

    mass_kg: float = figure("mass in the box", is_extensive=True)
    density_kg_per_m3: float = figure(
        "mass over the volume of the box", "the bulk density, where grains fill it"
    )
    slope_deg: float | None = figure(
        "slope of the free surface",
        "plane through the highest grains that touch others; null where four columns of them are never there",
    )


@dataclass(frozen=True, kw_only=True)
class Held:
    """What the openings hold."""

    openings: int = figure("number of openings", is_extensive=True)
    stickers: Estimate = figure("stuck particles", is_extensive=True)
    sticking_kg: Estimate = figure("mass of stuck particles", is_extensive=True)
    blinded_openings: Estimate = figure("blinded openings", "that hold a stuck particle", is_extensive=True)
    pegged_percent: Estimate = figure(
        "pegged", "their mass in openings over that on the deck", resolution=0.1
    )
    blinded_percent: Estimate = figure("openings blocked", "over all openings", resolution=0.1)
