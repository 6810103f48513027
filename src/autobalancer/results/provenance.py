"""Who made a result."""

from __future__ import annotations

import datetime
from importlib.metadata import version

MAKER = "autobalancer"


def provenance() -> dict[str, str]:
    """Attributes that every result carries: the package with its version, and the moment."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    return {"source": f"{MAKER} {version(MAKER)}", "created": now}
