"""Ranges of values on the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import numpy as np

MOST = 1_000_000  # values along one axis


def speed_range(text: str) -> np.ndarray:
    """``"500 rpm:3000 rpm:50 rpm"`` (from, to, step) or one speed, in rad/s."""
    import numpy as np

    from autobalancer.units import option_to_si

    parts = [part.strip() for part in text.split(":")]
    if len(parts) == 1:
        return np.array([option_to_si(parts[0], "rad/s")])
    if len(parts) != 3:
        raise QuestionError(f'--speeds: given {text!r}; write it as "from:to:step", such as "500 rpm:3000 rpm:50 rpm"')
    low, high, step = (option_to_si(part, "rad/s") for part in _with_common_unit(parts))
    if not (0.0 < low <= high and step > 0.0):
        raise QuestionError(f"--speeds: given {text!r}; must ascend from above zero by a step above zero")
    if (high - low) / step > MOST:
        raise QuestionError(f"--speeds: given {text!r}, more than {MOST} speeds; take a larger step")
    return low + step * np.arange(int((high - low) / step * (1.0 + 1e-12) + 1e-9) + 1)


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
