"""The values of a sweep."""

from __future__ import annotations

import pytest

from orchestrator.casefile.errors import CaseError
from orchestrator.studies.points import parsed


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a.b_m=1,2.5,-3", ("1", "2.5", "-3")),
        ("a.b_m=58:70:4", ("58.0", "62.0", "66.0", "70.0")),
        ("a.b_m=0.1:0.3:0.1", ("0.1", "0.2", "0.3")),  # floats would lose the last
        ("a.b_m=3:1:-1", ("3.0", "2.0", "1.0")),
        ("a.b_m=5:5:1", ("5.0",)),
        ("a.b_m=[1, 2],[3, 4]", ("[1, 2]", "[3, 4]")),
        ("panel.solver=strip,rigid", ("strip", "rigid")),
    ],
)
def test_values(text: str, values: tuple[str, ...]) -> None:
    found = parsed(text)
    assert found.values == values
    assert found.key == text.partition("=")[0]
    assert len({found.folder(value) for value in values}) == len(values)


@pytest.mark.parametrize(
    "text", ["a", "=1", "a=", "a=1,,2", "a=1,1", "a=1:2:0", "a=1:2:-1", "a=x:2:1"]
)
def test_what_is_no_list_of_values(text: str) -> None:
    with pytest.raises(CaseError, match="--vary"):
        parsed(text)
