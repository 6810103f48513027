"""Long names and units of what films and photographs give; the rest has those of runs."""

from __future__ import annotations

import xarray as xr

from autobalancer.results.labels import LABELS, Label

OWN = {
    "ball_angle": Label("ball angle in the rotor, measured", "rad", "rotor"),
    "ball_speed": Label("ball speed in the rotor, measured", "rad/s", "rotor"),
    "ball_angle_deviation": Label("standard deviation of the ball angle in the rotor", "rad", "rotor"),
    "ball_speed_deviation": Label("standard deviation of the ball speed in the rotor", "rad/s", "rotor"),
    "seen": Label("whether the ball was seen in the picture", ""),
    "identity_margin": Label("what the second best match of balls would cost more, in squares of deviations", ""),
    "fault": Label("why the picture is of no use; empty if it is", ""),
}


def labeled(found: xr.Dataset) -> xr.Dataset:
    """The same data with long names, units and frames."""
    for name, variable in found.variables.items():
        entry = OWN.get(str(name)) or LABELS[str(name)]
        variable.attrs.update(long_name=entry.long_name, units=entry.units)
        if entry.frame:
            variable.attrs["frame"] = entry.frame
    return found
