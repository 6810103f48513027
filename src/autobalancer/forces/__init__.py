"""Built-in forces on the balls of a race, one in each file; the file has the name of its ``kind``."""

import autobalancer.machine  # noqa: F401  (it reads the leaves of this package, so it comes first)
