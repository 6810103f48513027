"""Run-out of a shaft: what displacement sensors see although nothing vibrates, found at slow roll and subtracted."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.noise_density import independent
from autobalancer.results.signals.orders import Orders
from autobalancer.units.arguments import ends_argument

SPREADS = (
    1.3,
    1.7,
)  # ratios of speeds from which parts that grow with the second and the fourth power are told from the rest
STEADY = 1.05  # a ratio below which not even the first of them can be told
LEAST = 4  # points


def subtracted(found: Orders, slow_roll: Any) -> Orders:
    """Orders without run-out.

    Within the interval the complex amplitude is R + D w² + E w⁴ of the speed w: unbalance below the resonance grows in even
    powers, and what is left at speed zero, R, is run-out. Where the speed changes less, the last terms are left out; where
    it hardly changes, R is the mean. The deviation of R contains the noise of the points that are independent, and
    how far R would move with one more term. All points share this error of R, ``runout_deviation``; it is part of
    the deviation of each of them.

    Parameters
    ----------
    found
        Orders with run-out.
    slow_roll
        Interval of time, s, or orders measured at slow roll.

    Raises
    ------
    QuestionError
        If the interval holds fewer than four points, or the other orders lack a channel or an order.
    """
    if isinstance(slow_roll, xr.Dataset):
        slow, where = _matching(found, slow_roll), "of its own measurement"
    else:
        start, end = ends_argument("slow_roll", slow_roll, "s")
        at = found["time"].values
        slow = found.isel(time=(at >= start) & (at <= end))
        where = f"from {start:g} s to {end:g} s"
    if slow.sizes["time"] < LEAST:
        span = f"{found['time'].values[0]:.4g} s to {found['time'].values[-1]:.4g} s"
        raise QuestionError(f"slow_roll: {slow.sizes['time']} points {where}; the orders have {span}")
    speed = slow["speed"].values
    values = (slow["amplitude"].values * np.exp(1j * slow["phase"].values)).reshape(-1, speed.size).T
    noise = slow["amplitude_deviation"].values.reshape(-1, speed.size).T
    grows = sum(speed.max() > ratio * speed.min() for ratio in SPREADS)
    runout, spread = _at_speed_zero(speed, values, noise, 1 + grows, independent(slow).sizes["time"])
    if speed.max() > STEADY * speed.min() and speed.size > LEAST:
        spread = np.hypot(spread, np.abs(_at_speed_zero(speed, values, noise, 2 + grows, speed.size)[0] - runout))
    shape = slow["amplitude"].shape[:2]
    return _without(found, runout.reshape(shape), spread.reshape(shape), where)


def _at_speed_zero(
    speed: np.ndarray, values: np.ndarray, noise: np.ndarray, terms: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """R of each column of ``values`` (point, column), and one standard deviation of its parts if ``count`` points count."""
    design = ((speed / speed.max()) ** 2)[:, None] ** np.arange(terms)
    parts, *_ = np.linalg.lstsq(design.astype(np.complex128), values, rcond=None)
    rest = (np.abs(values - design @ parts) ** 2).sum(axis=0) / (2.0 * max(1, speed.size - terms))
    own = np.linalg.inv(design.T @ design)[0, 0] * speed.size / max(1, count)
    return parts[0], np.sqrt(own * np.maximum(rest, (noise**2).mean(axis=0)))


def _without(found: Orders, runout: np.ndarray, spread: np.ndarray, where: str) -> Orders:
    left = found["amplitude"].values * np.exp(1j * found["phase"].values) - runout[:, :, None]
    before, size = found["amplitude_deviation"].values, np.abs(left)
    deviation = np.hypot(before, spread[:, :, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        added = np.minimum(deviation / size, np.pi / np.sqrt(3.0))
        of_angle = found["phase_deviation"].values ** 2 - (before / found["amplitude"].values) ** 2
    found = found.copy()
    for name, values in (
        ("amplitude", size),
        ("phase", np.angle(left)),
        ("amplitude_deviation", deviation),
        ("phase_deviation", np.sqrt(added**2 + np.maximum(0.0, of_angle))),
    ):
        found[name] = (found[name].dims, values, found[name].attrs)
    found["runout_amplitude"] = (("order", "channel"), np.abs(runout), {"long_name": "run-out that was subtracted"})
    about = {"long_name": "standard deviation of its parts, which all points share"}
    found["runout_deviation"] = (("order", "channel"), spread, about)
    found["runout_phase"] = (
        ("order", "channel"),
        np.angle(runout),
        {"long_name": "its lead over the mark", "units": "rad"},
    )
    return Orders.of(found.assign_attrs(runout=f"subtracted, found at slow roll {where}"))


def _matching(found: Orders, slow: xr.Dataset) -> xr.Dataset:
    if "amplitude" not in slow or "order" not in slow.coords:
        raise QuestionError("slow_roll: give an interval of time, or orders from ab.measure.orders")
    for name in ("order", "channel"):
        lacking = [value for value in found[name].values if value not in slow[name].values]
        if lacking:
            raise QuestionError(f"slow_roll: its orders lack {name} {lacking[0]}")
    return slow.sel(order=found["order"].values, channel=found["channel"].values)
