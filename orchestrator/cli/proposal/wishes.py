"""The wishes for a new case: the questions that are asked, their defaults, and the possible answers.

Each question has the name of its option on the command line.  All numbers are in SI units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from orchestrator.case.file.data_table import decode
from orchestrator.case.file.errors import CaseError, CaseProblem, Kind, did_you_mean, show_value
from orchestrator.case.file.sieve_analysis import curve_of
from orchestrator.case.file.units import parse_quantity, split_quantity
from orchestrator.case.materials.library import (
    MOISTURES,
    SIZE_EXPONENT,
    NamedMaterial,
    UnknownMaterial,
    find,
    materials,
    shapes,
)
from orchestrator.case.materials.typical_feed import Points, typical_feed
from orchestrator.case.tables.quantities import unit_of


@dataclass(frozen=True)
class Template:
    """A kind of machine: its title, what it is, the questions that it asks, and its own defaults.

    ``files`` is the folder of its files in ``templates/``.  ``fewest_panels`` are proposed where none are
    wished for, and more where the throughput wants them.  ``is_free`` says whether forces move its
    frames; otherwise drives prescribe their motion.
    """

    title: str
    about: str
    asks: tuple[str, ...]
    files: str
    is_free: bool
    defaults: Mapping[str, str] = field(default_factory=dict)
    fewest_panels: int = 4

    @property
    def has_material(self) -> bool:
        """Whether material is fed."""
        return "material" in self.asks


RANGE = " to "  # between the first and the last of several slopes, and between two sizes
USUAL_LARGEST = 2.5
"""Largest size of a feed that is not given, over the smaller side of the openings."""
_DECK = ("width", "panels", "length", "slope", "opening", "opening-length")
_MATERIAL = ("material", "shape", "moisture", "throughput", "feed", "cut")
_MOTION = ("speed", "stroke")
TEMPLATES = {
    "flip-flow": Template(
        "A vibrating flip-flow screen",
        "a vibrating flip-flow screen: an exciter, two frames on rubber bushings, and a straight deck",
        (*_DECK, *_MATERIAL, *_MOTION),
        "screen",
        True,
    ),
    "banana": Template(
        "A banana flip-flow screen",
        "the same machine with a deck of several slopes, from steep to flat",
        (*_DECK, *_MATERIAL, *_MOTION),
        "screen",
        True,
        {"slope": "30 deg, 20 deg, 12 deg"},
        fewest_panels=6,
    ),
    "crank-link": Template(
        "A crank-driven flip-flow screen",
        "a flip-flow screen whose two frames a crank moves against each other by prescribed strokes",
        (*_DECK, *_MATERIAL, *_MOTION),
        "screen",
        False,
        {"speed": "600 rpm"},
    ),
    "test-rig": Template(
        "A test rig",
        "one panel without material between a fixed and a driven clamp (with material: crank-link, 1 panel)",
        ("width", "length", "opening", "opening-length", *_MOTION),
        "test-rig",
        False,
        {"width": "0.5 m", "slope": "0 deg"},
        fewest_panels=1,
    ),
}


@dataclass(frozen=True)
class Question:
    """A question about one wish.

    ``sentence`` is the question as it is asked, and ``default`` the answer that is offered, as text with
    its unit; "" leaves the choice to the proposal.  ``key`` is the name of the number and ends with its unit;
    without a unit, it is a whole number.  ``limits`` are the smallest and the largest possible value.
    ``unit`` is the unit that people usually give; a number without any unit is then refused.
    """

    sentence: str
    default: str
    key: str
    limits: tuple[float, float] = (0.0, 0.0)
    unit: str = ""

    def range(self, unit: str) -> str:
        """Return the limits as text in a unit of the question's kind; "" stands for the key's own unit."""
        size = parse_quantity(f"1 {unit}", self.key) if unit else 1.0
        low, high = (limit / size for limit in self.limits)
        return f"{up(low):.15g} to {down(high):.15g} {unit or unit_of(self.key, '')}".rstrip()


def down(value: float, digits: int = 3) -> float:
    """Return the largest number of so many significant digits that is not above a value."""
    return _cut(value, digits, math.floor)


def up(value: float, digits: int = 3) -> float:
    """Return the smallest number of so many significant digits that is not below a value."""
    return _cut(value, digits, math.ceil)


def _cut(value: float, digits: int, whole: Callable[[float], int]) -> float:
    """Return a number of so many significant digits beside a value; one that differs by rounding is equal."""
    if value == 0:
        return 0.0
    places = digits - 1 - math.floor(math.log10(abs(value)))
    return round(whole(round(value * 10.0**places, 6)) / 10.0**places, max(0, places))


QUESTIONS = {
    "width": Question("How wide is the deck?", "2 m", "width_m", (0.1, 6.0), "m"),
    "panels": Question(
        "How many panels follow one another along the deck (nothing: as many as the throughput wants)?",
        "",
        "panels",
        (1, 40),
    ),
    "length": Question(
        "How long is the whole deck (nothing: as long as panels for this stroke are)?",
        "",
        "length_m",
        (0.15, 15.0),
        "m",
    ),
    "slope": Question(
        "How steeply does the deck slope down (several slopes from the upper end, separated by commas, "
        'or "30 to 12 deg")?',
        "20 deg",
        "slope_deg",
        (0.0, 45.0),
    ),
    "opening": Question(
        'How wide are the openings across the deck (or width x length, such as "8 x 20 mm")?',
        "12 mm",
        "opening_m",
        (5e-4, 0.2),
        "mm",
    ),
    "opening-length": Question(
        "How long are the openings along the deck (nothing: as long as wide)?",
        "",
        "opening_length_m",
        (5e-4, 0.5),
        "mm",
    ),
    "material": Question("Which material is screened?", "limestone", "material"),
    "shape": Question(
        "Which shape have its grains: round, rounded, angular or flaky (nothing: as it usually has)?",
        "",
        "shape",
    ),
    "throughput": Question(
        "How much material is fed?", "50 t/h", "throughput_kg_per_s", (0.003, 2000.0), "t/h"
    ),
    "moisture": Question(
        "How moist is it: dry, moist, wet or sticky (nothing: as the material's name says, else dry)?",
        "",
        "moisture",
    ),
    "feed": Question(
        'Which sizes are fed, such as "0-30 mm", or which file has the sieve analysis, such as lab.csv '
        "(nothing: 0 to 2.5 openings)?",
        "",
        "feed_m",
        (0.0, 0.5),
        "mm",
    ),
    "cut": Question(
        "From which size on is a grain coarse (nothing: from the openings' smaller side on)?",
        "",
        "cut_m",
        (1e-4, 0.3),
        "mm",
    ),
    "speed": Question("How fast does the shaft turn?", "750 rpm", "speed_rad_per_s", (5.0, 200.0), "rpm"),
    "stroke": Question(
        "How large shall the stroke be, the amplitude of one frame against the other along the deck "
        "(half of the whole travel)?",
        "6 mm",
        "stroke_m",
        (2e-4, 0.05),
        "mm",
    ),
}


@dataclass(frozen=True)
class Wishes:
    """The answers to the questions of a template, in SI units.

    None leaves the choice to the proposal.  A template that does not ask for something has its default.
    Without a wish, ``panels`` are the template's fewest (``deck_size.with_enough_panels``).
    ``feed_m`` are the points of the feed's curve, and ``feed_file`` is the text of the sieve analysis that
    gave them; "" stands for a typical curve.
    ``answers`` has the answers as text, by the names of the template's questions.
    """

    template: str
    answers: Mapping[str, str]
    width_m: float
    panels: int
    length_m: float | None
    slopes_deg: tuple[float, ...]
    opening_m: float
    opening_length_m: float
    material: str
    shape: str
    throughput_kg_per_s: float
    feed_m: Points
    feed_file: str
    cut_m: float | None
    speed_rad_per_s: float
    stroke_m: float

    @property
    def is_free(self) -> bool:
        """Whether forces move the frames."""
        return TEMPLATES[self.template].is_free

    @property
    def has_material(self) -> bool:
        """Whether material is fed."""
        return TEMPLATES[self.template].has_material

    @property
    def title(self) -> str:
        """The title of the case."""
        panels = f"{self.panels} panels" if self.panels > 1 else "one panel"
        under = f" under {self.material}" if self.has_material else ""
        return f"{TEMPLATES[self.template].title}: {panels} of {self.width_m:g} m width{under}"

    @property
    def smaller_m(self) -> float:
        """The smaller side of the openings, which decides what passes."""
        return min(self.opening_m, self.opening_length_m)

    @property
    def separation_m(self) -> float:
        """The cut size: that which is wished for, or the smaller side of the openings."""
        return self.cut_m or self.smaller_m

    @property
    def density_kg_per_m3(self) -> float:
        """The density of the material's particles."""
        return find_grains(self.material).material.quantities["density_kg_per_m3"].value


class ImpossibleWishes(CaseError):
    """An error for wishes that no machine can fulfil; ``problems`` lists every reason with its option."""

    where = "in the options"


def problem(option: str, what: str, hint: str = "", kind: Kind = "out-of-range") -> CaseProblem:
    """Return a problem with the answer to a question."""
    return CaseProblem((), what, hint, file=f"--{option}", kind=kind)


def default_answer(template: str, name: str, answers: Mapping[str, str]) -> str:
    """Return the answer that a template offers to a question where others are answered.

    Openings are as wide as the cut where one is wished for.
    """
    if name == "opening" and (cut := answers.get("cut", "").strip()):
        return cut
    return TEMPLATES[template].defaults.get(name, QUESTIONS[name].default)


def read_wishes(template: str, answers: Mapping[str, str]) -> Wishes:
    """Return the wishes from a template's answers as text; questions without an answer get their default.

    Raises ImpossibleWishes with every answer that cannot be read or is out of its limits, and for an
    unknown template.
    """
    if problems := find_wrong_answers(template, answers):
        raise ImpossibleWishes(problems)
    given = {name: answers.get(name, "").strip() for name in QUESTIONS}
    texts = {name: text or default_answer(template, name, given) for name, text in given.items()}
    numbers = {name: read_answer(name, text) for name, text in texts.items()}
    if len(numbers["opening"]) > 1:
        if numbers["opening-length"]:
            what = f"contradicts --opening {show_value(texts['opening'])}, which has a length"
            problems.append(problem("opening-length", what, "leave one of them out", kind="conflict"))
        numbers["opening"], numbers["opening-length"] = numbers["opening"][:1], numbers["opening"][1:]
    panels = int(numbers["panels"][0]) if numbers["panels"] else TEMPLATES[template].fewest_panels
    if RANGE in texts["slope"]:
        numbers["slope"] = _spread(numbers["slope"], panels)
    if (slopes := len(numbers["slope"])) > panels:
        what, hint = f"{slopes} slopes need at least {slopes} panels", "give fewer slopes, or more --panels"
        problems.append(problem("slope", what, hint))
    material = " ".join(texts["material"].split())
    if moisture := texts["moisture"].lower():
        if (said := find_grains(material).moisture) and said != moisture:
            hint = "leave one of them out"
            problems.append(
                problem("moisture", f"{moisture} contradicts --material {material!r}", hint, kind="conflict")
            )
        material = material if said else f"{moisture} {material}"
    if problems:
        raise ImpossibleWishes(problems)
    first = {name: row[0] if row else None for name, row in numbers.items()}
    smaller_m = min(_given(first["opening"]), _given(first["opening-length"] or first["opening"]))
    feed_m, feed_file = _read_feed(texts["feed"], numbers["feed"], material, smaller_m)
    return Wishes(
        template=template,
        answers={name: texts[name] for name in TEMPLATES[template].asks if texts[name]},
        width_m=_given(first["width"]),
        panels=panels,
        length_m=first["length"],
        slopes_deg=numbers["slope"],
        opening_m=_given(first["opening"]),
        opening_length_m=_given(first["opening-length"] or first["opening"]),
        material=material,
        shape=texts["shape"].lower() or find_grains(texts["material"]).material.shape,
        throughput_kg_per_s=_given(first["throughput"]),
        feed_m=feed_m,
        feed_file=feed_file,
        cut_m=first["cut"],
        speed_rad_per_s=_given(first["speed"]),
        stroke_m=_given(first["stroke"]),
    )


def _read_feed(text: str, ends_m: tuple[float, ...], material: str, smaller_m: float) -> tuple[Points, str]:
    """Return the points of the feed's curve, and the text of its sieve analysis, "" for a typical curve."""
    if is_file_name(text):
        analysis = decode(Path(text).read_bytes())
        return tuple((row["sieve_size_m"], row["passing"]) for row in curve_of(analysis)), analysis
    smallest_m, largest_m = ends_m or (0.0, USUAL_LARGEST * smaller_m)
    exponent = find_grains(material).material.quantities[SIZE_EXPONENT].value
    return typical_feed(smallest_m, largest_m, exponent), ""


def is_file_name(feed: str) -> bool:
    """Return whether an answer names the file of a sieve analysis, and not two sizes."""
    return Path(feed).suffix.lower() in (".csv", ".txt", ".tsv")


def _check_feed_file(name: str) -> None:
    """Raise ImpossibleWishes if a file is no sieve analysis."""
    try:
        curve_of(decode(Path(name).read_bytes()))
    except OSError as error:
        raise ImpossibleWishes(
            [problem("feed", f"{show_value(name)} cannot be read: {error.strerror}", kind="file")]
        ) from None
    except ValueError as error:
        raise ImpossibleWishes([problem("feed", f"{show_value(name)}: {error}", kind="file")]) from None


def find_wrong_answers(template: str | None, answers: Mapping[str, str]) -> list[CaseProblem]:
    """Return a problem for an unknown template and for each answer that is wrong in itself.

    None stands for a template that is not chosen yet.
    """
    problems: list[CaseProblem] = []
    asks = tuple(QUESTIONS)
    if template is not None:
        try:
            asks = read_template(template).asks
        except CaseError as error:
            problems += error.problems
    for name, text in answers.items():
        if name not in asks:
            hint = "leave it out"
            if name in _MATERIAL:
                hint += ", or take --template crank-link --panels 1 for one panel under material"
            problems.append(
                problem(name, f"the template {template} does not ask for it", hint, kind="unknown-key")
            )
        try:
            if text.strip():
                read_answer(name, text)
        except CaseError as error:
            problems += error.problems
    return problems


def read_template(name: str) -> Template:
    """Return the template of a name.  Raises ImpossibleWishes, which names the nearest, if there is none."""
    if name not in TEMPLATES:
        hint = did_you_mean(name, TEMPLATES, say="templates")
        raise ImpossibleWishes(
            [problem("template", f"no template {show_value(name)}", hint, kind="unknown-name")]
        )
    return TEMPLATES[name]


def _given(number: float | None) -> float:
    assert number is not None, "only lengths may be left to the proposal"
    return number


def read_answer(name: str, text: str) -> tuple[float, ...]:
    """Return the numbers of an answer in SI units; empty for a name, and for an answer that is left open.

    A range of slopes has its two ends, and an opening may have its width and its length.  Raises
    ImpossibleWishes with every reason why the answer is wrong.
    """
    question = QUESTIONS[name]
    if name == "material":
        find_grains(text)
        return ()
    if name == "shape":
        if (shape := text.strip().lower()) and shape not in shapes():
            hint = did_you_mean(shape, shapes(), say="shapes")
            raise ImpossibleWishes(
                [problem("shape", f"no shape {show_value(text)}", hint, kind="unknown-name")]
            )
        return ()
    if name == "moisture":
        if text.strip().lower() not in ("", *MOISTURES):
            hint = did_you_mean(text.strip().lower(), MOISTURES, say="classes")
            raise ImpossibleWishes(
                [problem(name, f"{show_value(text)} is not a class of moisture", hint, kind="unknown-name")]
            )
        return ()
    if name == "feed" and is_file_name(text.strip()):
        _check_feed_file(text.strip())
        return ()
    numbers, problems = [], []
    for part in _parts(name, text):
        try:
            numbers.append(_read_number(part.strip(), question))
        except ValueError as error:
            problems.append(problem(name, str(error), kind="wrong-type"))
    if name == "feed" and not problems and numbers and not (len(numbers) == 2 and numbers[0] < numbers[1]):
        what = f"{show_value(text)} is not a range of sizes"
        problems.append(
            problem(
                name, what, 'give two, such as "0-30 mm", or the file of a sieve analysis', kind="wrong-type"
            )
        )
    if problems:
        raise ImpossibleWishes(problems)
    return tuple(numbers)


def _parts(name: str, text: str) -> list[str]:
    """Return the texts of the numbers in an answer, each with its unit."""
    separator = {"slope": RANGE if RANGE in text else ",", "opening": " x "}.get(name)
    if name == "feed":
        separator = next((mark for mark in (RANGE, " - ", "-", "/") if mark in text.strip("-")), None)
    parts = text.split(separator) if separator and text.strip() else [text] if text.strip() else []
    unit = re.sub(r"^[\s0-9.eE+-]+", "", parts[-1]) if len(parts) > 1 else ""
    return [part if re.search(r"[A-Za-z]", part) else f"{part} {unit}" for part in parts] if unit else parts


def _spread(ends_deg: tuple[float, ...], panels: int) -> tuple[float, ...]:
    """Return slopes at equal steps between two ends, one for two panels, at least two and at most as many
    as there are panels."""
    first, *_, last = ends_deg
    count = min(panels, max(2, math.ceil(panels / 2)))
    steps = [number / max(1, count - 1) for number in range(count)]
    return tuple(round(first + (last - first) * share, 1) for share in steps)


def find_grains(name: str) -> NamedMaterial:
    """Return the material of the library that a name denotes.

    Raises ImpossibleWishes for a name that the library does not have, and for a material that is no grains.
    """
    grains = [row.name for row in materials().values() if row.kind == "grains"]
    try:
        named = find(name)
    except UnknownMaterial as error:
        hint = str(error) or did_you_mean(name, grains, say="materials")
        raise ImpossibleWishes(
            [problem("material", f"no material {show_value(name)}", hint, kind="unknown-name")]
        ) from None
    if named.material.kind != "grains":
        what = f"{show_value(name)} is not screened"
        raise ImpossibleWishes(
            [problem("material", what, f"take one of {', '.join(grains)}", kind="unknown-name")]
        )
    return named


def _read_number(text: str, question: Question) -> float:
    """Return a number in SI units.  Raises ValueError, whose message says what is wrong."""
    own, (_, unit) = unit_of(question.key, ""), split_quantity(text)
    try:
        number = parse_quantity(text, question.key) if unit and own else float(text)
    except ValueError as error:
        nothing = "is not a number with a unit" if own else "is not a number"
        raise ValueError(f"{show_value(text)} {(own and unit and str(error)) or nothing}") from None
    if question.unit and not unit:
        raise ValueError(f"{show_value(text)} has no unit; is {show_value(f'{text} {question.unit}')} meant?")
    low, high = question.limits
    if not low <= number <= high:
        raise ValueError(f"{show_value(text)} is out of the range {question.range(unit)}")
    if not own and number != int(number):
        raise ValueError(f"{show_value(text)} is not a whole number")
    return number
