"""The one reader of tables: forms of one table, and what it asks rather than guesses."""

from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.case.file.bushing_loop import points_of
from orchestrator.case.file.data_table import Answers, DataTable, TableError, decode, read_text, split_head
from orchestrator.case.file.sieve_analysis import curve_of

KEYS = {"amplitude": "amplitude_m", "stiffness": "stiffness_N_per_m"}
PLAIN = "amplitude_m,stiffness_N_per_m\n0.001,262000\n0.0125,225500\n"
TWINS = {
    "as it is": PLAIN,
    "semicolons and commas": "amplitude_m;stiffness_N_per_m\n0,001;262000\n0,0125;225500\n",
    "quoted commas": 'amplitude_m,stiffness_N_per_m\n"0,001",262000\n"0,0125",225500\n',
    "tabs": PLAIN.replace(",", "\t"),
    "blanks": PLAIN.replace(",", "   "),
    "one blank and commas": "amplitude_m stiffness_N_per_m\n0,001 262000\n0,0125 225500\n",
    "bars": PLAIN.replace(",", "|"),
    "sep=": "sep=;\n" + PLAIN.replace(",", ";"),
    "quoted sep=": '"sep=;"\n' + PLAIN.replace(",", ";"),
    "old Macintosh": PLAIN.replace("\n", "\r"),
    "comments": "# bench 3, 2023-05-02\n// by hand\n" + PLAIN.replace("262000", "262000 # soft"),
    "lines above": "Report 7,\n,\nTest of,2023\n" + PLAIN,
    "mm and kN": "Amplitude [mm];Stiffness [kN/mm]\n1;0,262\n12,5;0,2255\n",
    "brackets": "Amplitude (mm),Stiffness (N/mm)\n1,262\n12.5,225.5\n",
    "slashes": "amplitude / mm,stiffness / kN/m\n1,262\n12.5,225.5\n",
    "underscores": "amplitude_mm,stiffness_kN_per_m\n1,262\n12.5,225.5\n",
    "in": "amplitude in mm,stiffness in kN/m\n1,262\n12.5,225.5\n",
    "a line of units": "Amplitude;Stiffness\nmm;N/mm\n1;262\n12,5;225,5\n",
    "a line of units in brackets": "Amplitude\tStiffness\n[mm]\t[N/mm]\n1\t262\n12.5\t225.5\n",
    "units in cells": "amplitude_m,stiffness_N_per_m\n1 mm,262 kN/m\n0.0125,225500\n",
    "a head in two lines": '"Amplitude\n[mm]","Stiffness\n[N/mm]"\n1,262\n12.5,225.5\n',
    "spare commas": "amplitude_m,stiffness_N_per_m,,\n0.001,262000,,\n0.0125,225500,,\n,,,\n",
    "an index": ",amplitude_m,stiffness_N_per_m\n0,0.001,262000\n1,0.0125,225500\n",
    "exponents": "amplitude_m,stiffness_N_per_m\n1e-3,2.62E+5\n1.25e-2,225.5e3\n",
    "a head in a comment": "#amplitude_m stiffness_N_per_m\n0.001\t262000\n0.0125\t225500\n",
    "thousands that cannot be": "amplitude_mm;stiffness_N_per_m\n1,000;262000\n12,5;225500\n",
}


def numbers(table: DataTable) -> dict[str, list[float]]:
    return {column.name: column.numbers(KEYS[column.name]).tolist() for column in table.columns}


@pytest.mark.parametrize("name", TWINS)
def test_one_table_in_all_its_forms(name: str) -> None:
    """To the last bit."""
    assert numbers(read_text(TWINS[name])) == {
        "amplitude": [0.001, 0.0125],
        "stiffness": [262000.0, 225500.0],
    }


@pytest.mark.parametrize(
    "code", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1", "cp1252"]
)
def test_one_text_in_all_its_codes(code: str) -> None:
    text = "Amplitude [µm];Prüfer\n1,5;Jürgen\n"
    assert decode(text.encode(code)) == text


@pytest.mark.parametrize(
    ("data", "clue"),
    [
        (b"PK\x03\x04\x14\x00", "CSV"),
        (b"\xd0\xcf\x11\xe0\xa1", "CSV"),
        (b"\x1f\x8b\x08\x00", "unpack"),
        (b"PAR1\x15\x04\x15\x00\x00", "not text"),
        (b"a,b\n1,\x00\x812\n", "not text"),
        (b"\xff\xfea", "not text"),
    ],
)
def test_what_is_no_text_is_refused(data: bytes, clue: str) -> None:
    with pytest.raises(TableError, match=clue):
        decode(data)


@pytest.mark.parametrize(
    ("text", "clue"),
    [
        ("a,b\n1.234.567,5\n", "thousands"),
        ('a;b\n"1.234,5";5\n', "thousands"),
        ("a;b\n1.234;5\n", r"1\.234.*decimal ="),
        ("a;b\n1,234;5\n", r"1,234.*decimal ="),
        ('a,b\n"1,234",5\n', r"1,234.*decimal ="),
        ("a;b\n0,5;1.234\n", r"1\.234.*decimal ="),
        ("a;b\n0,5;0.5\n", "decimal ="),
        ("a,b\n0,5,1\n", "2: 3.*2.*commas"),
        ("a,b\n5\n", "2: 1.*2"),
        ("a_mm,b\nm,\n1,2\n", "mm.*m "),
        ("1,2\n3,4\n", "names"),
        ("a,b\n", "rows"),
        ("", "rows"),
        ("a,,b\n1,x,2\n", "without a name.*'x'"),
    ],
)
def test_what_is_unsure_is_asked(text: str, clue: str) -> None:
    with pytest.raises(TableError, match=clue):
        read_text(text)


@pytest.mark.parametrize(
    ("cell", "clue"),
    [("1 s", "'1 s'"), ("ten", "'ten'"), ("inf", "'inf'"), ("nan", "'nan'"), ("1_0", "'1_0'"), ("", "empty")],
)
def test_a_cell_that_is_no_length(cell: str, clue: str) -> None:
    table = read_text(f"amplitude_mm,b\n1,2\n{cell},2\n")
    with pytest.raises(TableError, match=f"line 3: amplitude_mm .*{clue}"):
        table.columns[0].numbers("amplitude_m")


def test_answers() -> None:
    """The decimal mark, what a column is, and which is left out."""
    answers = Answers({"A": "amplitude / mm", "no": "ignore"}, ",")
    (column,) = read_text("A;no\n1,234;7\n", answers).columns
    assert column.numbers("amplitude_m").tolist() == [0.001234]
    with pytest.raises(TableError, match=r'"B".*A'):
        read_text("A\n1\n", Answers({"B": "ignore"}))


@pytest.mark.parametrize(
    ("head", "name", "unit"),
    [
        ("Particle X-Coordinate [m]", "particle x coordinate", "m"),
        ("Position X (mm)", "position x", "mm"),
        ("velocity_m_per_s:0", "velocity 0", "m/s"),
        ("Points:2", "points 2", ""),
        ("Points_1", "points 1", ""),
        ("velocity_m_per_s_0", "velocity 0", "m/s"),
        ("tan d", "tan d", ""),
        ("Displacement mm", "displacement", "mm"),
        ("Damping [Ns/mm]", "damping", "N s/mm"),
        ("retained [wt.-%]", "retained", "%"),
        ("% passing", "passing", "%"),
        ("passing / retained", "passing retained", ""),
        ("Loss factor [-]", "loss factor", "1"),
        ("sieve_size_m", "sieve size", "m"),
        ("loss_factor", "loss factor", ""),
    ],
)
def test_heads(head: str, name: str, unit: str) -> None:
    assert split_head(head) == (name, unit)


@settings(deadline=None, max_examples=200)
@given(
    data=st.one_of(
        st.binary(max_size=200),
        st.text(alphabet='ab,;\t .0123456789eE+-"#[]()/%_mN=\n', max_size=200).map(str.encode),
    ),
    seed=st.sampled_from(
        [
            "",
            "sieve / mm;passing / %\n",
            "amplitude_mm,frequency_Hz,stiffness_N_per_mm\n",
            "time_s,displacement_mm,force_kN\n",
        ]
    ),
)
def test_any_file_is_read_or_refused(data: bytes, seed: str) -> None:
    for read in (curve_of, points_of, read_text):
        with suppress(TableError):
            read(decode(seed.encode() + data), Answers())
