"""``python -m reproductions.pakula2021.lost --minutes 60 [--folder DIR]``: search, or go on with a search."""

from __future__ import annotations

import argparse
from pathlib import Path

from reproductions.pakula2021.lost.search import search

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, required=True, help="processor time")
    parser.add_argument("--folder", type=Path, default=Path("build/lost_machine"), help="where runs are kept")
    asked = parser.parse_args()
    search(asked.folder, asked.minutes)
