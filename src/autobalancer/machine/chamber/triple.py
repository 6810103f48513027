"""Quantities along the three axes: x along the rotor, y and z across it."""

from __future__ import annotations

from typing import Annotated

from autobalancer.machine.quantity import Quantity

Triple = tuple[float, float, float]
Place3 = Annotated[Triple, Quantity("m", shape="three")]
Stiffness3 = Annotated[Triple, Quantity("N/m", non_negative=True, shape="three")]
Damping3 = Annotated[Triple, Quantity("N*s/m", non_negative=True, shape="three")]
Inertia3 = Annotated[Triple, Quantity("kg*m^2", positive=True, shape="three")]
Acceleration3 = Annotated[Triple, Quantity("m/s^2", shape="three")]
