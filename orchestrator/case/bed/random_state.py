"""The state of a random generator as an array."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def words(generator: np.random.Generator) -> npt.NDArray[np.uint64]:
    """The state of a PCG64 generator: its two 128-bit numbers in halves, and what is left over of
    its last 64 bits."""
    state: Any = generator.bit_generator.state
    halves = [half for key in ("state", "inc") for half in divmod(state["state"][key], 2**64)]
    return np.array([*halves, state["has_uint32"], state["uinteger"]], dtype=np.uint64)


def set_words(generator: np.random.Generator, words: npt.NDArray[np.uint64]) -> None:
    high, low, inc_high, inc_low, has_more, more = map(int, words)
    numbers = {"state": high * 2**64 + low, "inc": inc_high * 2**64 + inc_low}
    generator.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": numbers,
        "has_uint32": has_more,
        "uinteger": more,
    }
