"""Make the site: ``python -m tools.site [FOLDER]``."""

from __future__ import annotations

import logging
import sys
from pathlib import Path

from tools.site.build import build_site

OUT = Path("build/site")

if __name__ == "__main__":
    logging.basicConfig(format="%(levelname)s: %(message)s")
    index = build_site(Path(sys.argv[1]) if len(sys.argv) > 1 else OUT)
    print(f"made: {index}")
