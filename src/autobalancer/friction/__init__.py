"""Friction laws of balls that slide or roll on their race, one in each file; the file has the name of its ``kind``."""

import autobalancer.machine  # noqa: F401  (it reads the leaves of this package, so it comes first)
