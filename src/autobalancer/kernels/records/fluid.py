"""What the fluid around a ball does: drag curves, lag, slipstream; and tables over time."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.fields import Field, Record

NONE = -1  # in place of the number of a table or a line: there is none

TABLE = Record(
    Field("start", "of its axis", "where the grid begins"),
    Field("step", "of its axis", "between two points of the grid"),
    Field("count", "", "how many points", kind=np.int64),
    Field("first", "", "number of its first point", kind=np.int64),
)
"""A curve over a uniform grid, cubic between its points. A drag curve is log force over log velocity."""

POINT = Record(
    Field("value", "of the table", "the value there"),
    Field("slope", "of the table", "its change per step of the grid"),
)
"""A point of a table."""

RELAXATION = Record(
    Field("state", "", "its place in the state vector", kind=np.int64),
    Field("rate", "1/s", "how fast it dies out"),
    Field("gain", "1", "what the rotor's acceleration adds to it"),
)
"""A relaxation mode of the fluid in a race: c' = gain w' - rate c, and the fluid lags by the sum of all c."""

LINE = Record(
    Field("ball", "", "its number", kind=np.int64),
    Field("first", "", "place of the first number of the others", kind=np.int64),
    Field("others", "", "how many others there are", kind=np.int64),
    Field("per_speed", "s/m", "Reynolds number over speed"),
    Field("greatest", "1", "the greatest Reynolds number of the fit"),
    Field("per_angle", "1/rad", "distance in diameters over angle"),
    Field("reach", "1", "the greatest distance of the fit, in diameters"),
)
"""A ball and the others of its race, of which the one ahead lessens its drag."""

IN_FLUID = (
    Field("drag_curve", "", "number of the table of its drag; NONE: linear", kind=np.int64),
    Field("slipstream", "", "number of its line; NONE: no slipstream", kind=np.int64),
    Field("lag_table", "", "number of the table of the fluid's lag; NONE: none", kind=np.int64),
    Field("modes", "", "how many relaxation modes its fluid has", kind=np.int64),
    Field("first_mode", "", "number of the first of them", kind=np.int64),
)
"""What any ball knows of its fluid: where its tables, its line and its modes are."""
