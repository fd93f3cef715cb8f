"""Make the site: ``python -m tools.site [FOLDER]``."""

from __future__ import annotations

import argparse
import logging
from collections.abc import Sequence
from pathlib import Path

from tools.site.build import build_site

OUT = Path("build/site")


def main(words: Sequence[str] | None = None) -> None:
    """Make the site in the folder that the command names."""
    parser = argparse.ArgumentParser(
        "python -m tools.site", description="Make the site of the documentation."
    )
    parser.add_argument(
        "folder", nargs="?", type=Path, default=OUT, help=f"folder of the site, made anew [default: {OUT}]"
    )
    given = parser.parse_args(words)
    logging.basicConfig(format="%(levelname)s: %(message)s")
    print(f"made: {build_site(given.folder)}")


if __name__ == "__main__":
    main()
