"""Automatic ball balancers: describe the machine, simulate it, see what the balls do.

    >>> import autobalancer as ab
    >>> machine = ab.load_machine("machine.toml")
    >>> run = ab.simulate(machine)

The names below are the public interface; each is imported when it is first used, so that
``import autobalancer`` is light and has no side effects.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    # describe
    "load_machine": "files.machine_file",
    "save_machine": "files.machine_file",
    "machine_text": "files.machine_file",
    # catalogs and design basics
    "bearings": "catalog.bearings",
    "suitable_bearings": "catalog.bearings",
    "fluids": "catalog.fluids",
    "fluid": "catalog.fluids",
    "blend": "catalog.fluids",
    "materials": "catalog.materials",
    "capability": "laws.capability",
    "largest_useful_count": "laws.capability",
    # solve
    "simulate": "simulation.run",
    "Event": "simulation.events",
    "Samples": "simulation.sampling",
    "SampleTimes": "simulation.sampling",
    "Envelope": "simulation.sampling",
    "LastRevolutions": "simulation.sampling",
    "with_parameter": "assembly.parameters",
    "summary": "stability.summary",
    "border_speeds": "stability.borders",
    "equilibria": "stability.states",
    "eigenvalues": "stability.states",
    "basin": "stability.basins",
    # results
    "load_run": "results.store",
    "save_run": "results.store",
    "measures": "results.measures",
    "deflection_envelope": "results.measures",
    "residual_vibration": "results.measures",
    "peak_deflection": "results.measures",
    "settling_time": "results.measures",
    "release_speed": "results.measures",
    "ball_angle_to_unbalance": "results.measures",
    # study
    "sweep": "studies.sweep",
    # show
    "plot_run_up": "plots.run_up",
    "plot_race": "plots.race",
    "plot_orbit": "plots.orbit",
    "plot_basin": "plots.basins",
    "animate": "plots.animation",
}
_MODULES = {"machine", "errors", "units"}

__all__ = [
    "Envelope",
    "Event",
    "LastRevolutions",
    "SampleTimes",
    "Samples",
    "animate",
    "ball_angle_to_unbalance",
    "basin",
    "bearings",
    "blend",
    "border_speeds",
    "capability",
    "deflection_envelope",
    "eigenvalues",
    "equilibria",
    "errors",
    "fluid",
    "fluids",
    "largest_useful_count",
    "load_machine",
    "load_run",
    "machine",
    "machine_text",
    "materials",
    "measures",
    "peak_deflection",
    "plot_basin",
    "plot_orbit",
    "plot_race",
    "plot_run_up",
    "release_speed",
    "residual_vibration",
    "save_machine",
    "save_run",
    "settling_time",
    "simulate",
    "suitable_bearings",
    "summary",
    "sweep",
    "units",
    "with_parameter",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        value = getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = import_module(f"{__name__}.{name}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])


if TYPE_CHECKING:
    from autobalancer import errors, machine, units
    from autobalancer.assembly.parameters import with_parameter
    from autobalancer.catalog.bearings import bearings, suitable_bearings
    from autobalancer.catalog.fluids import blend, fluid, fluids
    from autobalancer.catalog.materials import materials
    from autobalancer.files.machine_file import load_machine, machine_text, save_machine
    from autobalancer.laws.capability import capability, largest_useful_count
    from autobalancer.plots.animation import animate
    from autobalancer.plots.basins import plot_basin
    from autobalancer.plots.orbit import plot_orbit
    from autobalancer.plots.race import plot_race
    from autobalancer.plots.run_up import plot_run_up
    from autobalancer.results.measures import (
        ball_angle_to_unbalance,
        deflection_envelope,
        measures,
        peak_deflection,
        release_speed,
        residual_vibration,
        settling_time,
    )
    from autobalancer.results.store import load_run, save_run
    from autobalancer.simulation.events import Event
    from autobalancer.simulation.run import simulate
    from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples, SampleTimes
    from autobalancer.stability.basins import basin
    from autobalancer.stability.borders import border_speeds
    from autobalancer.stability.states import eigenvalues, equilibria
    from autobalancer.stability.summary import summary
    from autobalancer.studies.sweep import sweep
