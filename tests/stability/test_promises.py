"""A seeded part of the bank of promises: at the interval that a scheme promises, random scenes are sound.

``tools.promise_bank`` tries hundreds.  At their limits of growth, robin created 2 to 10 % in the scenes 1, 4
and 80, and of the tries of aitken one broke the panel of 1078.  serial-staggered created 1.3 % in 3436 at
twice its promise.  80 is the one of a hundred that particles-first leaves: 1.5 %, and 0.2 % at 0.7 of its
promise.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tools.promise_bank import trial

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    ("scheme", "seeds"),
    [("particles-first", (10,)), ("robin", (1, 4, 80)), ("aitken", (4, 1078)), ("serial-staggered", (3436,))],
)
def test_the_promise_holds(scheme: str, seeds: tuple[int, ...], tmp_path: Path) -> None:
    rows = [trial(seed, scheme, 1.0, tmp_path) for seed in seeds]
    assert {row["status"] for row in rows} <= {"done", "other doubts"}, rows
    assert max(abs(row["created"]) for row in rows) < 0.01
