"""Draw the pictures of docs/theory.

``python docs/pictures/draw.py [--out FOLDER] [NAME ...]``

Each picture is a module of this folder with a function ``draw``, and becomes NAME.svg.
"""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import matplotlib.pyplot as plt

HERE = Path(__file__).parent
NAMES = sorted(file.stem for file in HERE.glob("*.py") if file.stem not in ("draw", "drawing"))


def main() -> None:
    """Draw the pictures that are named, or all of them."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("names", nargs="*", help="pictures; all of them if none is named")
    words.add_argument("--out", type=Path, default=HERE.parent / "images" / "theory")
    given = words.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    for name in given.names or NAMES:
        importlib.import_module(name).draw()
        plt.savefig(given.out / f"{name}.svg", metadata={"Date": None, "Creator": None})
        plt.close("all")


if __name__ == "__main__":
    main()
