"""``python -m reproductions [--only PATTERN]``: run the reproductions, show and keep their rows."""

from __future__ import annotations

import os
import shutil
import sys
from types import ModuleType

from tools.ledger import REPRODUCTIONS, ROOT, Row, main

PICTURES = ROOT / "build" / "reproductions"


def reproduce(module: ModuleType, name: str) -> list[Row]:
    out = PICTURES / name.split(".")[0]
    out.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = module.reproduce(out)
    return rows


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    if len(sys.argv) == 1:  # all of them; pictures of reproductions that are gone would stay
        shutil.rmtree(PICTURES, ignore_errors=True)
    sys.exit(main(REPRODUCTIONS, reproduce))
