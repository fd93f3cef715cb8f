"""Sieve analyses: the tables of laboratories that a case names, and what a user is told of wrong ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.case.file.sieve_analysis import OPEN_END, curve_of
from orchestrator.cli.proposal.wishes import _read_feed
from orchestrator.preflight.judge import load_judged
from tests.cases import case_folder, keys_and_kinds, kinds, loaded, problems

MM = 1e-3
WHOLE = "sieve / mm, passing / %\n16,100\n8,70\n4,40\n2,20\n1,0\n"
POINTS = [(1.0, 0.0), (2.0, 0.2), (4.0, 0.4), (8.0, 0.7), (16.0, 1.0)]
FEED = (
    'material="coal", rate_kg_per_s=1.0, velocity_m_per_s=[0, 0, -1], '
    "box_m=[[0.05, 0.05, 0.2], [0.15, 0.15, 0.3]]"
)


def points(text: str) -> list[tuple[float, float]]:
    """Return the points of a table in mm and shares."""
    return [(point["sieve_size_m"] / MM, point["passing"]) for point in curve_of(text)]


@pytest.mark.parametrize(
    "text",
    [
        WHOLE,
        "passing,sieve (mm)\n0.2,2\n1,16\n0.7,8\n0,1\n0.4,4\n",
        "Sieve size;Cumulative passing [%]\n4 mm;40,0\n1000 µm;0,0\n16 mm;100\n8,0 mm;70,0\n2 mm;20\n",
        "sieve_mm\tretained per class / %\n16\t0\n8\t30\n4\t30\n2\t20\n1\t20\n",
        "sieve_mm,retained\n16,0\n8,0.3\n4,0.3\n2,0.2\n1,0.2\n",
        "sieve / mm;cumulative retained / %\n1;100\n2;80\n4;60\n8;30\n16;0\n",
        "sieve,retained / g\n16 mm,0\n8 mm,150\n4 mm,150\n2 mm,100\n1 mm,100\npan,0\n",
        "sieve / mm,retained / g,cumulative retained / %,passing / %\n16,0,0,100\n8,150,30,70\n4,150,60,40\n"
        "2,100,80,20\n1,100,100,0\npan,0,100,0\n",
        "Siebweite [mm];Durchgang [%]\n16;100\n8;70\n4;40\n2;20\n1;0\n",
        "sieve,finer\n16 mm,100 %\n8 mm,70 %\n4 mm,40 %\n2 mm,20 %\n1 mm,0 %\n",
    ],
    ids=[
        "passing",
        "any order",
        "decimal commas",
        "per class",
        "shares",
        "cumulative",
        "masses",
        "all",
        "German",
        "signs",
    ],
)
def test_one_curve_in_all_its_forms(text: str) -> None:
    assert points(text) == [pytest.approx(point) for point in POINTS]


def test_the_openings_are_those_of_astm_e11() -> None:
    """ASTM E11-20, table 1: an inch of a sieve's name is not 25.4 mm; No. 200 is 75 µm."""
    text = (
        'sieve,passing / %\n1 1/2 in,100\n1-in.,98\n3/4 in,95\n1/2",90\n3/8 in,85\n1/4 inch,80\nNo. 4,70\n'
        "No. 8,60\n#16,50\nNo.30,40\nno 50,30\nNo. 100,20\nNo. 200,10\n0.265 in,81\n45 mm,100\n"
    )
    openings_mm = [opening_mm for opening_mm, _ in points(text)][1:]
    table_mm = [0.075, 0.15, 0.3, 0.6, 1.18, 2.36, 4.75, 6.3, 6.7, 9.5, 12.5, 19.0, 25.0, 37.5]
    assert openings_mm == pytest.approx(table_mm)


def test_an_open_lower_end_is_spread_evenly_below_the_finest_sieve() -> None:
    """4 % pass 63 µm: the curve goes on to half of that, and ends at the first sieve that all pass."""
    curve = points("sieve / mm;passing / %\n31,5;100\n63 µm;4\n16;100\n4;50\n")
    expected = [(0.063 * OPEN_END, 0.0), (0.063, 0.04), (4.0, 0.5), (16.0, 1.0)]
    assert curve == [pytest.approx(point) for point in expected]


def test_what_the_pan_holds_is_below_the_finest_sieve() -> None:
    text = "sieve,retained per class / %\n8 mm,0\n4 mm,60.1\n2 mm,30\npan,10\n"
    expected = [(2.0 * OPEN_END, 0.0), (2.0, 10 / 100.1), (4.0, 40 / 100.1), (8.0, 1.0)]
    assert points(text) == [pytest.approx(point) for point in expected]


@pytest.mark.parametrize(
    ("text", "clue"),
    [
        ("sieve / mm,passing / %\n16,100\n8,40\n4,45\n", r"\b40\b.*\b45\b"),
        ("sieve / mm,passing / %,cumulative retained / %\n16,100,0\n8,40,50\n", "contradict"),
        ("sieve / mm,passing / retained\n16,100\n8,40\n", "mixes"),
        ("sieve / mm,passing / %\n16,97\n8,40\n", r"\b3\b.*\b16\b"),
        ("sieve,passing\n16,1\n8,0.4\n", "'16'.*unit"),
        ("sieve,passing\nNo. 4,1\nNo. 11,0.4\n", r"\b11\b.*\b10\b"),
        ("sieve,passing\n4 mesh,1\n8 mm,0.4\n", "Tyler.*ASTM"),
        ("sieve / mm,passing\n16,1\ncoarse,0.4\n", r"\b3:.*'coarse'"),
        ("sieve / mm,passing\n16,1\n8,x\n", r"\b3:.*'x'"),
        ("sieve / mm,passing\n16,1\n8,-0.1\n", r"\b3:.*'-0\.1'"),
        ("sieve / mm,passing / %\n16,120\n8,10\n", r"\b120\b.*\b100\b"),
        ("sieve / mm,passing\n16,1\n16 mm,0.4\n", r"\b3:.*\b16\b.*twice"),
        ("sieve / mm,passing\n16,1\n8,0.4,3\n", r"\b3:.*\b3\b.*\b2\b"),
        ("sieve / mm,weight\n16,1\n8,0.4\n", "'weight'"),
        ("16,1\n8,0.4\n", "'16'"),
        ("sieve / mm,passing\n", "rows"),
        ("", "rows"),
        ("sieve / mm,passing\n16,1\n", "sieves"),
        ("sieve / mm,retained / %\n16,0\n8,20\n4,30\n", "retained"),
        ("sieve,retained / %\n16 mm,0\n8 mm,40\n4 mm,40\npan,10\n", r"\b90\b.*\b100\b"),
        ("sieve / mm,retained per class / %\n16,0\n8,60\n4,60\n", r"\b120\b.*\b100\b"),
        ("sieve / mm,retained / g\n16,0\n8,60\n4,30\n", "pan"),
    ],
)
def test_a_wrong_table_is_refused(text: str, clue: str) -> None:
    with pytest.raises(ValueError, match=clue):
        curve_of(text)


def test_a_case_names_the_file(tmp_path: Path) -> None:
    """A feed, a block, ``--set`` over sizes and over a curve: the curve of the file takes their place."""
    (tmp_path / "lab.csv").write_text(WHOLE)
    (tmp_path / "other.csv").write_text(WHOLE.replace("16,", "31.5,"))
    given = f'bed.feeds.more={{{FEED}, curve={{file="lab.csv"}}}}'
    curve = loaded(tmp_path, [given]).case.bed.feeds["more"].curve
    assert [(point.sieve_size_m / MM, point.passing) for point in curve] == [pytest.approx(p) for p in POINTS]
    sizes = f"bed.feeds.more={{{FEED}, sizes=[{{smallest_m=0.01, largest_m=0.02, mass_fraction=1.0}}]}}"
    replaced = loaded(tmp_path, [sizes, "bed.feeds.more.curve.file=lab.csv"]).case.bed.feeds["more"]
    assert (replaced.sizes, replaced.curve) == ((), curve)
    again = f"bed.feeds.more.curve.file={'other.csv'}"
    assert loaded(tmp_path, [given, again]).case.bed.feeds["more"].curve[-1].sieve_size_m == 31.5 * MM
    points = "{sieve_size_m=0.01, passing=0}, {sieve_size_m=0.02, passing=1}"
    points_given = f"bed.feeds.more={{{FEED}, curve=[{points}]}}"
    assert loaded(tmp_path, [points_given, again]).case.bed.feeds["more"].curve[-1].sieve_size_m == 31.5 * MM
    back = "bed.feeds.more.sizes=[{smallest_m=0.01, largest_m=0.02, mass_fraction=1.0}]"
    assert loaded(tmp_path, [given, back]).case.bed.feeds["more"].curve == ()


def test_a_level_and_a_base_name_files_in_their_own_folder(tmp_path: Path) -> None:
    case_folder(tmp_path / "below")
    (tmp_path / "below" / "lab.csv").write_text(WHOLE)
    text = (tmp_path / "below" / "case.toml").read_text()
    box = "box_m = [[0.05, 0.05, 0.2], [0.15, 0.15, 0.3]]\nvelocity_m_per_s = [0, 0, -1]"
    more = f'\n[bed.feeds.more]\nmaterial = "coal"\nrate_kg_per_s = 1.0\n{box}\ncurve.file = "lab.csv"\n'
    (tmp_path / "below" / "case.toml").write_text(text + more)
    (tmp_path / "above").mkdir()
    (tmp_path / "above" / "case.toml").write_text('base = "../below"\n')
    assert len(load_judged(tmp_path / "above").case.bed.feeds["more"].curve) == len(POINTS)


def test_a_wrong_file_is_named_with_its_key(tmp_path: Path) -> None:
    (tmp_path / "lab.csv").write_text(WHOLE.replace("4,40", "4,90"))
    given = f'bed.feeds.more={{{FEED}, curve={{file="lab.csv"}}}}'
    for name, file in (("lab", "lab.csv"), ("none", "none.csv"), ("../lab", "--set")):
        (problem,) = problems(tmp_path, given.replace("lab", name))
        assert keys_and_kinds([problem]) == ["bed.feeds.more.curve.file: file"]
        assert problem.file == file
    assert "bed.feeds.more.curve: wrong-type" in kinds(tmp_path, given.replace("file=", "fiel="))


@pytest.mark.parametrize("code", ["utf-8-sig", "utf-16", "cp1252"])
def test_a_new_case_takes_a_file_in_any_code(tmp_path: Path, code: str) -> None:
    (tmp_path / "lab.csv").write_text("Sieve [µm];Passing [%]\n16000;100\n8000;0\n", encoding=code)
    (points, _) = _read_feed(str(tmp_path / "lab.csv"), (), "coal", 0.01)
    assert points == ((8e-3, 0.0), (16e-3, 1.0))
