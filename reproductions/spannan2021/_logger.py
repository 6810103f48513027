"""Sensors on the simulated rig: laser at the shaft, accelerometer on the lid, one pulse a turn of the encoder.

The source names them and prints no noise; here it is that of usual sensors of the kind. What they give is evaluated by the
functions for signals of a logger, and by nothing else.
"""

from __future__ import annotations

import autobalancer as ab

LASER = ab.measure.Sensor("displacement", "laser", noise="2 um")
LID = ab.measure.Sensor("acceleration", "accelerometer", noise=0.02)
ENCODER = ab.measure.Tacho()
RATE = "1 kHz"
KEPT = 400.0  # samples of a run per second
SURE = 3.0  # standard deviations
