"""Studies of a table: what is read, and what is refused."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import Study
from orchestrator.studies.design.table_data import read_published, read_table
from orchestrator.studies.points import Crew
from tests.cases import keys_and_kinds
from tests.design.campaigns import belt

HEAD = "slope,stroke,speed,share\n"
ROWS = "10,2,0.5,80\n30,2,1.9,45\n10,6,0.8,62\n30,6,2.3,30\n20,4,1.3,70\n20,4,1.31,71\n"


def study_of(folder: Path, text: str, **changes: object) -> Study:
    """Return a study of a table with a text."""
    (folder / "belt.csv").write_text(text, encoding="utf-8")
    own = {"responses/speed/result": None, "responses/share/result": "share"}
    return belt(folder, **{"case": None, "table": "belt.csv", "set": {}, **own, **changes})


def refused(study: Study) -> tuple[CaseProblem, ...]:
    """Return the problems of a table."""
    with pytest.raises(CaseError) as raised:
        read_table(study)
    return raised.value.problems


def complaint(study: Study) -> str:
    """Return the message about a table."""
    return str(CaseError(refused(study)))


def test_each_row_is_a_trial(tmp_path: Path) -> None:
    text = "# measured by hand\nspeed, share, remark, slope, stroke\n0.5, 80, dry, 10, 2\n1.9, 45, , 30, 6\n"
    first, second = read_table(study_of(tmp_path, text))
    assert first.trial.setting == (-1.0, -1.0)
    assert second.trial.setting == (1.0, 1.0)
    assert {name: each.value for name, each in second.responses.items()} == {"speed": 1.9, "share": 45.0}
    assert second.responses["speed"].deviation is None


def test_the_noise_is_read_from_its_column_or_the_study(tmp_path: Path) -> None:
    text = "slope,stroke,speed,speed deviation,share\n10,2,0.5,0.03,80\n30,6,1.9,,45\n"
    study = study_of(tmp_path, text, **{"responses/share/noise": 0.7, "responses/speed/noise": 0.1})
    first, second = read_table(study)
    assert first.responses["speed"].deviation == 0.03
    assert second.responses["speed"].deviation == 0.1
    assert second.responses["share"].deviation == 0.7


def test_an_empty_cell_of_a_response_was_not_measured(tmp_path: Path) -> None:
    half, none = read_table(study_of(tmp_path, HEAD + "10,2,,80\n30,6,,\n"))
    assert list(half.responses) == ["share"]
    assert half.is_data
    assert not none.is_data
    assert none.why == "no response was measured"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("slope,strok,speed,share\n10,2,1,1\n", ['belt.csv has no column "stroke"', 'did you mean "strok"?']),
        ("slope,stroke,speed\n10,2,1\n", ['belt.csv has no column "share"']),
        (HEAD + "10,2,0.5 m/s,80\n", ['row 1 of belt.csv: "0.5 m/s" is not a number of speed', "unit"]),
        (HEAD + "10,2,0.5,80\n10,many,0.5,80\n", ['row 2 of belt.csv: "many" is not a number of stroke']),
        (HEAD + "10,2,1e300,80\n", ["row 1 of belt.csv", "is not a number of speed"]),
        (HEAD + "10,2,1e-300,80\n", ["row 1 of belt.csv", "is not a number of speed"]),
        (HEAD + "10,,0.5,80\n", ["row 1 of belt.csv", "is not a number of stroke"]),
        (
            "slope,stroke,speed,speed deviation,share\n10,2,0.5,-1,80\n",
            ["row 1 of belt.csv: speed deviation = -1 is negative"],
        ),
        (HEAD + "10,inf,0.5,80\n", ["row 1 of belt.csv", '"inf" is not a number of stroke']),
        (HEAD + "10,2,0,5,80\n", ["more cells than columns", "decimals have points"]),
        ("slope,stroke,speed,share,speed\n10,2,1,1,2\n", ['belt.csv has 2 columns "speed"']),
        (HEAD, ["belt.csv", "has no rows"]),
        ("", ["belt.csv cannot be read"]),
    ],
    ids=[
        *["a misspelt column", "a missing column", "a unit in a cell", "text for a factor"],
        *["a huge response", "a tiny response"],
        *[
            "an empty factor",
            "a negative deviation",
            "an endless factor",
            "a decimal comma",
            "a column twice",
            "no rows",
            "no table",
        ],
    ],
)
def test_a_table_is_refused_for(text: str, words: list[str], tmp_path: Path) -> None:
    message = complaint(study_of(tmp_path, text))
    assert "table" in message
    for word in words:
        assert word in message


@pytest.mark.parametrize(("scale", "share"), [("percent", 130.0), ("percent", -11.0), ("logarithm", 0.0)])
def test_values_that_a_scale_does_not_have_are_refused(scale: str, share: float, tmp_path: Path) -> None:
    study = study_of(tmp_path, HEAD + f"10,2,0.5,{share}\n", **{"responses/share/scale": scale})
    (problem,) = refused(study)
    assert keys_and_kinds([problem]) == ["table: out-of-range"]
    assert {"1", "belt.csv:", "share", f"{share:g}", f'"{scale}"'} <= {*problem.what.split()}


def test_all_wrong_cells_stand_in_one_message(tmp_path: Path) -> None:
    problems = refused(study_of(tmp_path, HEAD + "a,2,b,80\n1,2,3,c\n"))
    assert keys_and_kinds(problems) == ["table: wrong-type"] * 3
    assert [problem.what.split('"')[1] for problem in problems] == ["a", "b", "c"]


def test_a_missing_table_is_told(tmp_path: Path) -> None:
    study = study_of(tmp_path, "")
    (tmp_path / "belt.csv").unlink()
    assert keys_and_kinds(refused(study)) == ["table: file"]


def test_the_data_of_a_table_are_not_run(tmp_path: Path) -> None:
    design = DesignStudy(study_of(tmp_path, HEAD + ROWS), Crew(), tmp_path / "out")
    with pytest.raises(CaseError, match=r"the data of a table cannot be run; flipflow study fit takes it"):
        list(design.run(search=True))
    assert not (tmp_path / "out").exists()


def test_six_rows_are_too_few_for_a_quadratic_of_two_factors(tmp_path: Path) -> None:
    design = DesignStudy(study_of(tmp_path, HEAD + ROWS), Crew(), tmp_path / "out")
    design.load_finished()
    lines = [str(line) for line in design.write()]
    assert any("support no optimum" in line and "6 points" in line for line in lines)
    assert "6 points" in (tmp_path / "out" / "design.html").read_text(encoding="utf-8")


def test_the_best_setting_of_a_table_is_predicted(tmp_path: Path) -> None:
    rows = "20,2,1.1,79\n20,6,1.5,61\n10,4,0.7,85\n30,4,2.0,49\n"
    design = DesignStudy(study_of(tmp_path, HEAD + ROWS + rows), Crew(), tmp_path / "out")
    design.load_finished()
    lines = [str(line) for line in design.write()]
    assert any("not yet measured" in line for line in lines)
    assert not (tmp_path / "out" / "recommended.toml").exists()


def test_data_out_of_all_ranges_have_no_optimum(tmp_path: Path) -> None:
    """A single row within the ranges is enough: the others are data, too."""
    outside = HEAD + ROWS.replace("\n10,", "\n110,").replace("10,2,", "50,2,").replace("0,4,", "0,14,")
    design = DesignStudy(study_of(tmp_path, outside.replace("30,", "130,")), Crew(), tmp_path / "out")
    design.load_finished()
    with pytest.raises(CaseError, match=r"factors\.slope\.range: no data .*: slope is 20 to 130 there; comp"):
        list(design.write())
    assert not (tmp_path / "out").exists()


def test_a_missing_published_table_is_told_before_anything_is_written(tmp_path: Path) -> None:
    published = [{"source": "Table 5", "response": "speed", "table": "printed.csv"}]
    study = study_of(tmp_path, HEAD + ROWS, published=published)
    with pytest.raises(CaseError, match=r"printed\.csv") as refused:
        DesignStudy(study, Crew(), tmp_path / "out").load_finished()
    assert keys_and_kinds(refused.value.problems) == ["published.0.table: file"]
    assert not (tmp_path / "out").exists()


def test_a_study_that_names_its_case_from_inside_goes_on(tmp_path: Path) -> None:
    """``case = ".."``, as in all shipped studies, is the case that the folder names in full."""
    inside, out = tmp_path / "machine" / "studies", tmp_path / "out"
    for folder in (inside, out):
        folder.mkdir(parents=True)
    (out / "study.toml").write_text('case = "../machine"\n')
    study = study_of(inside, HEAD + ROWS)
    file = study.file.model_copy(update={"table": "", "case": ".."})
    DesignStudy(replace(study, file=file), Crew(), out)
    file = study.file.model_copy(update={"table": "", "case": "../other"})
    with pytest.raises(FolderUnusable, match=str(out)):
        DesignStudy(replace(study, file=file), Crew(), out)


def test_the_folder_of_a_study_of_another_table_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    stored = tmp_path / "out" / "study.toml"
    stored.write_text('table = "../belt.csv"\n')
    DesignStudy(study_of(tmp_path, HEAD + ROWS), Crew(), tmp_path / "out")
    stored.write_text('table = "../others.csv"\n')
    with pytest.raises(FolderUnusable, match=r"out: .*\.\./others\.csv"):
        DesignStudy(study_of(tmp_path, HEAD + ROWS), Crew(), tmp_path / "out")


def with_published(folder: Path, text: str) -> Study:
    """Return a study of a case with a published table of the speed."""
    (folder / "belt.csv").write_text(text, encoding="utf-8")
    return belt(folder, published=[{"source": "Table 5", "response": "speed", "table": "belt.csv"}])


def test_a_published_table_has_a_column_with_the_response_s_name(tmp_path: Path) -> None:
    """The run's result, ``results.speed``, is no name of a column."""
    (outcomes,) = read_published(with_published(tmp_path, HEAD + ROWS))
    assert [each.responses["speed"].value for each in outcomes] == [0.5, 1.9, 0.8, 2.3, 1.3, 1.31]


def test_a_wrong_published_table_is_told_before_anything_runs(tmp_path: Path) -> None:
    study = with_published(tmp_path, (HEAD + ROWS).replace("speed", "sped"))
    with pytest.raises(CaseError, match=r'published\.0\.table: belt.csv has no column "speed".*sped'):
        list(DesignStudy(study, Crew(), tmp_path / "out").run(search=False))
    assert not (tmp_path / "out").exists()


def test_two_responses_may_share_a_column(tmp_path: Path) -> None:
    """The same numbers, on a plain scale and as shares of a whole."""
    shared = {"responses/speed/result": "share", "responses/share/scale": "percent"}
    first, *_ = read_table(study_of(tmp_path, HEAD + ROWS, **shared))
    assert {name: each.value for name, each in first.responses.items()} == {"speed": 80.0, "share": 80.0}


def test_a_pipe_is_no_table(tmp_path: Path) -> None:
    """A pipe would be waited for."""
    study = study_of(tmp_path, HEAD + ROWS)
    (tmp_path / "belt.csv").unlink()
    os.mkfifo(tmp_path / "belt.csv")
    assert keys_and_kinds(refused(study)) == ["table: file"]


def test_a_simpler_design_without_a_value_is_refused_with_the_file(tmp_path: Path) -> None:
    """The design is refused for a table as for a case, at a corner of the ranges: slope is 10 there."""
    with pytest.raises(CaseError, match=r"\b10,.*\b2:") as refused:
        study_of(tmp_path, HEAD + ROWS, simpler={"stroke": "4 + 0 / (slope - 10)"})
    (problem,) = refused.value.problems
    assert (Path(problem.file).name, problem.key, problem.kind) == ("study.toml", ("simpler",), "conflict")
