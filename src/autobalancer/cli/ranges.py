"""Ranges of values on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import numpy as np

MOST = 1_000_000  # values along one axis


def speed_range(text: str) -> np.ndarray:
    """``"500 rpm:3000 rpm:200"`` (from, to, count) or one speed, in rad/s; the speeds ascend from above zero."""
    import numpy as np

    from autobalancer.units import option_to_si

    speeds = axis_range("--speeds", "speed", text) if ":" in text else np.array([option_to_si(text, "rad/s")])
    if not speeds[0] > 0.0 or np.any(np.diff(speeds) <= 0.0):
        raise QuestionError(f"--speeds: given {text!r}; must ascend from above zero")
    return speeds


def axis_range(option: str, name: str, text: str) -> np.ndarray:
    """``"1 mm^2/s:100 mm^2/s:200"`` (from, to, count), SI; ``:log`` at the end makes the steps equal ratios.

    A unit may stand with one of the ends only; a bare number is SI if none has one.
    """
    import numpy as np

    from autobalancer.assembly.quantities import label_of
    from autobalancer.units import option_to_si

    parts = [part.strip() for part in text.split(":")]
    log = len(parts) == 4 and parts[3] == "log"
    if not (len(parts) == 3 or log) or not parts[2].isdigit() or not 1 <= int(parts[2]) <= MOST:
        raise QuestionError(
            f'{option}: given {text!r}; write it as "from:to:count" or "from:to:count:log", '
            'such as "1 mm^2/s:100 mm^2/s:200:log"'
        )
    ends = _with_common_unit(parts[:2])
    if name == "count":
        low, high = (float(end) for end in ends)
        return np.arange(round(low), round(high) + 1)
    low, high = (option_to_si(end, label_of(name)[1]) for end in ends)
    if log and not (low > 0.0 and high > 0.0):
        raise QuestionError(f"{option}: given {text!r}; equal ratios need ends above zero")
    return np.geomspace(low, high, int(parts[2])) if log else np.linspace(low, high, int(parts[2]))


def _with_common_unit(parts: list[str]) -> list[str]:
    units = [part.lstrip("+-.0123456789eE ") for part in parts]
    common = next((unit for unit in units if unit), "")
    return [part if unit or not common else f"{part} {common}" for part, unit in zip(parts, units, strict=True)]
