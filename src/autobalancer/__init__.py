"""Automatic ball balancers: describe the machine, simulate it, see what the balls do.

    >>> import autobalancer as ab
    >>> machine = ab.load_machine("machine.toml")
    >>> run = ab.simulate(machine)

The names below are the public interface; each is imported when it is first used, so that
``import autobalancer`` is light and has no side effects.
"""

from __future__ import annotations

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

from autobalancer.public_names import HOME as _HOME
from autobalancer.public_names import hint as _hint

__version__ = "0.1.0"

_MODULES = {"machine": "machine", "errors": "errors", "units": "units", "style": "plots.drawing.style"}

__all__ = [
    "Annulus",
    "Archive",
    "DragCurve",
    "Envelope",
    "Event",
    "FreeParameter",
    "KnownValue",
    "LastRevolutions",
    "MeasuredCriticalSpeed",
    "MeasuredMode",
    "MeasuredResponse",
    "MeasuredStiffness",
    "RaceBalls",
    "RelaxationModes",
    "SampleTimes",
    "Samples",
    "SpinUp",
    "StalledBall",
    "TurnedRace",
    "Walls",
    "angle_against_speed",
    "animate",
    "animate_chamber",
    "annulus_flow",
    "annulus_of",
    "archived_run",
    "averaged_border",
    "balance_grade",
    "ball_angle_to_unbalance",
    "balls_of",
    "balls_unbalance",
    "basin",
    "bearing",
    "bearings",
    "bifurcation_curves",
    "blend",
    "border_curve",
    "border_speeds",
    "branches",
    "campbell",
    "capability",
    "chamber_amplitudes",
    "chamber_measures",
    "chamber_summary",
    "chamber_variant",
    "chamber_verdict",
    "collision_statistics",
    "critical_speeds",
    "decay_rate",
    "deflection_envelope",
    "discoidal",
    "drag_coefficients",
    "drag_laws",
    "eigenfrequencies",
    "eigenvalues",
    "equal_balls",
    "equilibria",
    "equilibrium_angles",
    "equivalent_planar",
    "errors",
    "evaluate_angles",
    "example",
    "example_path",
    "example_text",
    "examples",
    "explicit_averaged_border",
    "fit_receptance",
    "fit_rolling_resistance",
    "fluid",
    "fluids",
    "free_sphere",
    "frequency_response",
    "friction_coefficients",
    "from_ross",
    "held_by_friction",
    "held_whirl",
    "holding_speed",
    "identify",
    "largest_count",
    "largest_useful_count",
    "lateral_model",
    "load_angle_series",
    "load_chamber_machine",
    "load_machine",
    "load_measurements",
    "load_receptance",
    "load_run",
    "machine",
    "machine_schema",
    "machine_text",
    "materials",
    "measures",
    "minimum_drag",
    "minimum_viscosity",
    "modes_of",
    "optimal_means",
    "over_seeds",
    "parse_machine",
    "peak_deflection",
    "permissible_unbalance",
    "pick_up_borders",
    "planar_receptance",
    "plot_amplitudes",
    "plot_arrangement",
    "plot_basin",
    "plot_bearing_forces",
    "plot_bifurcation_curves",
    "plot_border_curve",
    "plot_branches",
    "plot_campbell",
    "plot_carried",
    "plot_chamber_run",
    "plot_collisions",
    "plot_drag_laws",
    "plot_energy",
    "plot_equilibrium_angles",
    "plot_equivalent_planar",
    "plot_flow",
    "plot_frequency_response",
    "plot_identification",
    "plot_map",
    "plot_measured_drag",
    "plot_modes",
    "plot_nyquist",
    "plot_optimal_means",
    "plot_orbit",
    "plot_polar_response",
    "plot_race",
    "plot_reactions",
    "plot_receptance",
    "plot_run_up",
    "plot_secondary_flow",
    "plot_spin_up",
    "plot_stability",
    "plot_unbalance_response",
    "plot_velocity_profiles",
    "plot_whirl_along_axis",
    "plot_whirl_orbits",
    "race_geometry",
    "receptance_border",
    "receptance_loop",
    "receptance_stability",
    "recorded_speed",
    "relaxation_modes",
    "release_speed",
    "residual_of_balls",
    "residual_unbalance",
    "residual_vibration",
    "response_peaks",
    "rest_interval",
    "rig",
    "rig_text",
    "rigs",
    "rolling_resistance_deviation",
    "run_down_capture",
    "save_machine",
    "save_run",
    "settling_time",
    "simulate",
    "simulate_chamber",
    "slipstream_factor",
    "slipstream_factors",
    "speed_windows",
    "sphere_on_plane",
    "spin_up",
    "stability_map",
    "stability_ranges",
    "stable_windows",
    "stall_balance",
    "stall_ranges",
    "static_deflection",
    "step_size_study",
    "style",
    "suitable_bearings",
    "summary",
    "support_forces",
    "sweep",
    "unbalance_of",
    "unbalance_response",
    "unconstrained_motion",
    "units",
    "verdict",
    "vibration",
    "whirl_orbits",
    "with_parameter",
    "worst_start",
    "write_example",
]


def __getattr__(name: str) -> _Any:
    if name in _HOME:
        value = getattr(_import_module(f"{__name__}.{_HOME[name]}"), name)
    elif name in _MODULES:
        value = _import_module(f"{__name__}.{_MODULES[name]}")
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{_hint(name)}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, *_MODULES, "__version__"])


if _TYPE_CHECKING:
    from autobalancer import errors, machine, units
    from autobalancer.assembly.parameters import with_parameter
    from autobalancer.assembly.rotors import lateral_model
    from autobalancer.catalog.bearings import bearing, bearings, suitable_bearings
    from autobalancer.catalog.fluids import blend, fluid, fluids
    from autobalancer.catalog.friction import friction_coefficients
    from autobalancer.catalog.materials import materials
    from autobalancer.files.examples import example, example_text, examples
    from autobalancer.files.machine_file import (
        load_chamber_machine,
        load_machine,
        machine_text,
        parse_machine,
        save_machine,
    )
    from autobalancer.files.rigs import rig, rig_text, rigs
    from autobalancer.files.samples import example_path, write_example
    from autobalancer.flow.annulus import Annulus, Walls, annulus_of
    from autobalancer.flow.question import annulus_flow
    from autobalancer.flow.relaxation import RelaxationModes, relaxation_modes
    from autobalancer.flow.speed import recorded_speed
    from autobalancer.flow.spin_up import SpinUp, spin_up
    from autobalancer.laws.balance_quality import balance_grade, permissible_unbalance
    from autobalancer.laws.capability import capability, largest_count, largest_useful_count
    from autobalancer.laws.drag_coefficient import discoidal, drag_laws, free_sphere, race_geometry, sphere_on_plane
    from autobalancer.laws.drag_curve import DragCurve
    from autobalancer.laws.held_by_friction import held_whirl
    from autobalancer.laws.rest_interval import rest_interval
    from autobalancer.laws.slipstream import slipstream_factor, slipstream_factors
    from autobalancer.laws.stall import (
        StalledBall,
        holding_speed,
        planar_receptance,
        run_down_capture,
        stall_balance,
        stall_ranges,
    )
    from autobalancer.machine.schema import machine_schema
    from autobalancer.measurement.angle.curve import angle_against_speed
    from autobalancer.measurement.angle.evaluation import evaluate_angles
    from autobalancer.measurement.angle.file import load_angle_series
    from autobalancer.measurement.angle.rolling_resistance import fit_rolling_resistance, rolling_resistance_deviation
    from autobalancer.measurement.angle.statics import TurnedRace, drag_coefficients, equilibrium_angles
    from autobalancer.measurement.decay import decay_rate
    from autobalancer.measurement.loop.balls import RaceBalls, balls_of, equal_balls
    from autobalancer.measurement.loop.border import receptance_border
    from autobalancer.measurement.loop.curve import receptance_loop
    from autobalancer.measurement.loop.growth import receptance_stability
    from autobalancer.measurement.receptance.measured import load_receptance
    from autobalancer.measurement.receptance.rational_fit import fit_receptance, modes_of
    from autobalancer.plots.chamber.arrangement import plot_arrangement
    from autobalancer.plots.chamber.film import animate_chamber
    from autobalancer.plots.chamber.history import plot_chamber_run, plot_collisions, plot_energy
    from autobalancer.plots.chamber.reactions import plot_bearing_forces, plot_reactions
    from autobalancer.plots.chamber.study import plot_amplitudes, plot_carried, plot_optimal_means
    from autobalancer.plots.drawing import style
    from autobalancer.plots.film.animation import animate
    from autobalancer.plots.measured.drag import plot_drag_laws
    from autobalancer.plots.measured.equilibrium_angle import plot_equilibrium_angles, plot_measured_drag
    from autobalancer.plots.measured.flow import plot_flow, plot_secondary_flow, plot_spin_up, plot_velocity_profiles
    from autobalancer.plots.measured.identification import plot_identification
    from autobalancer.plots.measured.receptance import plot_nyquist, plot_receptance
    from autobalancer.plots.rotor.campbell import plot_campbell
    from autobalancer.plots.rotor.equivalent_planar import plot_equivalent_planar
    from autobalancer.plots.rotor.modes import plot_modes
    from autobalancer.plots.rotor.unbalance_response import plot_polar_response, plot_unbalance_response
    from autobalancer.plots.rotor.whirl import plot_whirl_along_axis, plot_whirl_orbits
    from autobalancer.plots.run.frequency_response import plot_frequency_response
    from autobalancer.plots.run.orbit import plot_orbit
    from autobalancer.plots.run.race import plot_race
    from autobalancer.plots.run.run_up import plot_run_up
    from autobalancer.plots.stability.basins import plot_basin
    from autobalancer.plots.stability.bifurcation_curves import plot_bifurcation_curves
    from autobalancer.plots.stability.border_curve import plot_border_curve
    from autobalancer.plots.stability.branches import plot_branches
    from autobalancer.plots.stability.growth import plot_stability
    from autobalancer.plots.stability.stability_map import plot_map
    from autobalancer.results.archive.folder import Archive
    from autobalancer.results.chamber.balls import balls_unbalance, residual_of_balls
    from autobalancer.results.chamber.measures import chamber_measures, collision_statistics
    from autobalancer.results.chamber.shape import unbalance_of
    from autobalancer.results.chamber.unconstrained import unconstrained_motion
    from autobalancer.results.measures import (
        ball_angle_to_unbalance,
        deflection_envelope,
        measures,
        peak_deflection,
        release_speed,
        residual_vibration,
        settling_time,
    )
    from autobalancer.results.places import residual_unbalance, static_deflection, support_forces, vibration
    from autobalancer.results.store import load_run, save_run
    from autobalancer.results.verdict.judged import verdict
    from autobalancer.rotordynamics.campbell import campbell
    from autobalancer.rotordynamics.critical import critical_speeds
    from autobalancer.rotordynamics.equivalent_planar import equivalent_planar
    from autobalancer.rotordynamics.from_ross import from_ross
    from autobalancer.rotordynamics.identification.free import FreeParameter
    from autobalancer.rotordynamics.identification.identify import identify
    from autobalancer.rotordynamics.identification.measurement_file import load_measurements
    from autobalancer.rotordynamics.identification.measurements import (
        KnownValue,
        MeasuredCriticalSpeed,
        MeasuredMode,
        MeasuredResponse,
        MeasuredStiffness,
    )
    from autobalancer.rotordynamics.modes import eigenfrequencies
    from autobalancer.rotordynamics.orbits import whirl_orbits
    from autobalancer.rotordynamics.peaks import response_peaks
    from autobalancer.rotordynamics.response import unbalance_response
    from autobalancer.simulation.chamber.run import simulate_chamber
    from autobalancer.simulation.chamber.summary import chamber_summary
    from autobalancer.simulation.chamber.verdict import chamber_verdict
    from autobalancer.simulation.events import Event
    from autobalancer.simulation.run import simulate
    from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples, SampleTimes
    from autobalancer.stability.averaged.border import averaged_border
    from autobalancer.stability.averaged.formulas import explicit_averaged_border
    from autobalancer.stability.averaged.phase_windows import speed_windows
    from autobalancer.stability.borders.curve import border_curve
    from autobalancer.stability.borders.minimum import minimum_drag, minimum_viscosity
    from autobalancer.stability.borders.speeds import border_speeds
    from autobalancer.stability.borders.stability_map import stability_map
    from autobalancer.stability.borders.windows import stable_windows
    from autobalancer.stability.diagrams.branches import branches
    from autobalancer.stability.diagrams.curves import bifurcation_curves
    from autobalancer.stability.friction.held import held_by_friction
    from autobalancer.stability.states.questions import eigenvalues, equilibria
    from autobalancer.stability.states.ranges import stability_ranges
    from autobalancer.stability.summary.summary import summary
    from autobalancer.studies.basin import basin
    from autobalancer.studies.chamber_amplitudes import chamber_amplitudes
    from autobalancer.studies.chamber_machines import chamber_variant
    from autobalancer.studies.chamber_means import optimal_means, over_seeds, pick_up_borders
    from autobalancer.studies.chamber_runs import archived_run
    from autobalancer.studies.frequency_response import frequency_response
    from autobalancer.studies.step_size import step_size_study
    from autobalancer.studies.sweep import sweep
    from autobalancer.studies.worst_start import worst_start
