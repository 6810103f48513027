"""``python -m benchmarks [--only PATTERN]``: run the benchmarks, show and keep their rows."""

from __future__ import annotations

import sys
from types import ModuleType

from tools.ledger import BENCHMARKS, Row, main


def bench(module: ModuleType, name: str) -> list[Row]:
    rows: list[Row] = module.bench()
    return rows


if __name__ == "__main__":
    sys.exit(main(BENCHMARKS, bench))
