"""What the tilt of a race adds to the equations of its balls, in the frame of the rotor.

With the slope s of the race, its rate e in space, the ball at r = E + eps e^(i phi) from the center, u = t phi' + iW r, along
t = dr/d phi, and the acceleration a of gravity along the axis, the kinetic energy of a ball grows by
m/2 ((e.r)^2 + (r x u) (e x s)) and its potential by m a s.r; see :mod:`autobalancer.kernels.balls.guided`. So

    moment on the station  -m (e'.r) r - 2 m (e.u) r - m a r + m/2 (r x u)' i s
    torque on the ball     m (e.r) (e.t) + m W (r.t) (e x s) - m a s.t - m/2 (r x t) (e' x s)
"""

from __future__ import annotations

from typing import NamedTuple

from autobalancer.stability.host.series import Numbers, Series


class Feels(NamedTuple):
    """A ball and its race; every entry counts the balls last."""

    mass: Numbers  # effective
    across: Series  # r
    up: Series
    along_x: Series  # t
    along_y: Series
    bend: Series  # d(r x t)/d phi
    rate: Series  # phi'
    slope_x: Series  # s
    slope_y: Series
    rate_x: Series  # e
    rate_y: Series


class Adds(NamedTuple):
    """Inertia (lean: between slope and ball angle) and forces; moments have parts along x and y."""

    xx: Series
    xy: Series
    yy: Series
    lean_x: Series
    lean_y: Series
    moment_x: Series
    moment_y: Series
    torque: Series


def tilted(b: Feels, speed: float, weight: float) -> Adds:
    """What the tilt adds; ``weight`` is the acceleration of gravity along the axis."""
    m = b.mass
    spin = b.rate_x * b.slope_y - b.rate_y * b.slope_x  # e x s
    rise, arm = b.across * b.along_x + b.up * b.along_y, 0.5 * m * (b.across * b.along_y - b.up * b.along_x)
    moving_x, moving_y = b.along_x * b.rate - speed * b.up, b.along_y * b.rate + speed * b.across
    known = 2.0 * m * (b.rate_x * moving_x + b.rate_y * moving_y) + m * weight
    spun = 0.5 * m * (b.bend * b.rate * b.rate + 2.0 * speed * (rise * b.rate))
    torque = m * ((b.rate_x * b.across + b.rate_y * b.up) * (b.rate_x * b.along_x + b.rate_y * b.along_y))
    torque = torque + m * speed * (rise * spin) - m * weight * (b.slope_x * b.along_x + b.slope_y * b.along_y)
    return Adds(
        xx=m * (b.across * b.across),
        xy=m * (b.across * b.up),
        yy=m * (b.up * b.up),
        lean_x=arm * b.slope_y,
        lean_y=-arm * b.slope_x,
        moment_x=-known * b.across - spun * b.slope_y,
        moment_y=-known * b.up + spun * b.slope_x,
        torque=torque,
    )
