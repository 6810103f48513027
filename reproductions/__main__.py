"""``python -m reproductions [--only PATTERN]``: run the reproductions, show and keep their rows."""

from __future__ import annotations

import os
import sys
from types import ModuleType

from tools.ledger import REPRODUCTIONS, ROOT, Row, main


def reproduce(module: ModuleType, name: str) -> list[Row]:
    out = ROOT / "build" / "reproductions" / name.split(".")[0]
    out.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = module.reproduce(out)
    return rows


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "Agg")
    sys.exit(main(REPRODUCTIONS, reproduce))
