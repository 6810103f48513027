"""Numbers of results as people read them."""

from __future__ import annotations

import re

LARGE = 1e4 * (1.0 + 1e-9)  # in one unit of an unbalance, from which on the next one is taken
LENGTHS = (("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9))


def length_text(value: float) -> str:
    """A length in m as text in its natural unit: ``"8.8 nm"``."""
    if abs(value) < 1e-11:
        return "0" if value == 0.0 else "< 0.01 nm"
    sign, factor = next(((sign, factor) for sign, factor in LENGTHS if abs(value) * factor >= 1.0), LENGTHS[-1])
    return f"{significant(value * factor)} {sign}"


def moment_text(value: float, digits: int = 3) -> str:
    """An unbalance in kg m as text: ``"500 g mm"``, above 10 000 g mm ``"124 kg mm"``, above 10 000 kg mm in kg m."""
    shown, unit = value * 1e6, "g mm"
    if 0.0 < abs(shown) < 1e-3:
        return "< 0.001 g mm"
    for larger in ("kg mm", "kg m"):
        if abs(shown) > LARGE:
            shown, unit = 1e-3 * shown, larger
    return f"{significant(shown, digits)} {unit}"


def couple_text(value: float) -> str:
    """A couple unbalance in kg m^2 as text: ``"10 kg mm²"``."""
    shown = value * 1e6
    return "< 0.001 kg mm²" if 0.0 < abs(shown) < 1e-3 else f"{significant(shown)} kg mm²"


def share_text(value: float) -> str:
    """A share as text in percent: ``"12.3 %"``."""
    return "< 0.01 %" if 0.0 < value < 1e-4 else f"{significant(100.0 * value)} %"


def velocity_text(value: float) -> str:
    """A velocity in m/s as text: ``"1.2 mm/s"``."""
    return "< 0.001 mm/s" if 0.0 < value < 1e-6 else f"{significant(value * 1e3)} mm/s"


def force_text(value: float) -> str:
    """A force in N as text."""
    return "< 0.001 N" if 0.0 < abs(value) < 1e-3 else f"{significant(value)} N"


def significant(value: float, digits: int = 3) -> str:
    """So many digits without an exponent where people would write none."""
    return f"{value:.0f}" if 10.0 ** (digits - 1) <= abs(value) < 1e6 else f"{value:.{digits}g}"


def worded(text: str, bodies: str) -> str:
    """A text about balls as one about these ``bodies``, such as "cylinders"."""
    return re.sub(r"\bball(s?)\b", rf"{bodies[:-1]}\1", text)
