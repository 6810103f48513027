"""Flow of the fluid in the annulus of a race that turns with the rotor, not disturbed by the balls.

``annulus_problem.py`` asks, ``annulus.py`` is the chamber, ``solve.py`` solves the full equations where ``choice.py`` finds
that a fluid that only diffuses is not enough. ``ball_problem.py`` is the fluid around a ball.

Symbols: r, z coordinates from the axis and from the bottom; a, b, H inner and outer radius and height; w speed of the
rotor; W = u_theta/r angular velocity of the fluid; G = r^2 W angular momentum, g = G - r^2 w its deviation from solid
rotation; psi stream function, u_r = -psi_z/r, u_z = psi_r/r; eta vorticity, q = r eta = -D2 psi;
D2 = d2/dr2 - (1/r) d/dr + d2/dz2; nu kinematic viscosity.
"""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("flow", globals())
