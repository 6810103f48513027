"""What is loaded before the first thread of the server starts."""

from __future__ import annotations

from contextlib import suppress
from importlib import import_module

from numba import njit

PACKAGES = (
    "PIL.Image",
    "autobalancer.api",
    "autobalancer.assembly.chamber",
    "autobalancer.assembly.rotors",
    "autobalancer.flow",
    "autobalancer.simulation.chamber",
    "autobalancer.stability",
    "contourpy",
    "dask.array",  # Pint and xarray ask for it where it is installed
    "distributed",  # xarray asks for it before it writes a file
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
    "netCDF4",
    "pint",
    "scipy.integrate",
    "scipy.interpolate",
    "scipy.io",
    "scipy.linalg",
    "scipy.optimize",
    "scipy.signal",
    "scipy.special",
    "scipy.stats",
    "xarray.namedarray._array_api",
)


def load_packages() -> None:
    """Load the packages that threads would else load at need, perhaps two threads at the same time.

    Python 3.11 can give both of them a package of which half is missing, and it may stay so: files could not be written any
    more where Pint and xarray met in Dask. That happens to packages that load their own modules, of which the modules are
    asked for, too.
    """
    for name in PACKAGES:
        with suppress(ImportError):  # not all of them need to be there
            import_module(name)
    njit(lambda number: number)(1.0)  # Numba loads most of itself with its first function
