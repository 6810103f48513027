"""Flow around a ball in its race by finite elements, and the drag on it.

``question.py`` asks, ``channel.py`` is the race as the ball sees it, ``mesh.py`` makes tetrahedra, ``spaces.py`` the matrices of
quadratic velocities and linear pressures (Taylor and Hood) on them, ``slow.py`` solves without inertia of the fluid and
``inertia.py`` with it, ``forces.py`` has the force and torque on a ball, ``result.py`` the labels.

Lengths are in radii of the ball, velocities in its velocity U along the walls, stresses in mu U / r. The frame is that of the
ball center: x along the race in the direction in which the ball moves, y from the outer wall inward, z along the axis; the plane
z = 0 at mid-height is one of symmetry, and only z > 0 is solved. Walls and undisturbed fluid move with w, -1 along x at the ball
center, and what is solved is the deviation from w.
"""
