"""Points of tracked orders whose noise is independent: neighbors share samples, so that they do not count as so many readings."""

from __future__ import annotations

import numpy as np
import xarray as xr

OF_WINDOW = 0.345  # of the window: the area of the autocorrelation of the local fit of second degree, weighted by Hann
OF_BANDWIDTH = 0.963  # over the bandwidth: the same of 1 / (1 + (f / f0)^4), which is at -3 dB at half of the bandwidth


def independent(orders: xr.Dataset) -> xr.Dataset:
    """Points so far apart that as many independent readings would know as much as all points together.

    That distance is the area below the autocorrelation of the noise of an amplitude. With the local fit the autocorrelation is
    zero there, too. Orders of which it is not known how they were tracked, such as tables, are returned as they are.

    Parameters
    ----------
    orders
        From :func:`autobalancer.measure.orders`, over ``time``.
    """
    if "time" not in orders.dims or "speed" not in orders.variables:
        return orders
    time, speed = np.asarray(orders["time"].values, np.float64), np.asarray(orders["speed"].values, np.float64)
    if "window_revolutions" in orders.attrs:
        turns = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))] / (2.0 * np.pi)
        place = turns / (OF_WINDOW * float(orders.attrs["window_revolutions"]))
    elif "bandwidth" in orders.attrs:
        place = (time - time[:1]) * float(orders.attrs["bandwidth"]) / OF_BANDWIDTH
    else:
        return orders
    kept, last = [], -np.inf
    for row, at in enumerate(place):
        if at - last > 1.0 - 1e-9:
            kept.append(row)
            last = at
    return orders.isel(time=kept)
