"""Shear laws of fluids, one in each file; the file has the name of its ``law``."""

import autobalancer.machine  # noqa: F401  (it reads the leaves of this package, so it comes first)
