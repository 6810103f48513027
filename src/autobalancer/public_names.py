"""The public interface: where each name lives, from where it is imported when it is first used, and its namespaces."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

NAMES: dict[str, dict[str, str]] = {
    "": {
        "load_machine": "files.machine_file",
        "save_machine": "files.machine_file",
        "machine_text": "files.machine_file",
        "parse_machine": "files.machine_file",
        "with_parameter": "assembly.quantities",
        "keys": "machine.schema",
        "example": "files.examples",
        "check": "api",
        "simulate": "api",
        "sweep": "studies.random_starts",
        "ensemble": "studies.ensemble.ensemble",
        "study": "studies.study.study",
        "sensitivity": "studies.study.study",
        "envelopes": "studies.study.study",
        "design": "api",
        "designed_machine": "studies.design.designs",
        "report": "reporting.report",
        "compare": "api",
        "basin": "studies.basin",
        "worst_start": "studies.random_starts",
        "stepped_response": "studies.stepped_response",
        "verdict": "api",
        "balancer_element": "simulation.balancer_element",
        "run_measures": "api",
        "export": "exchange",
        "animate": "plots.film_frames",
        "widget": "app.view.widget",
        "Event": "simulation.record",
        "Samples": "simulation.record",
        "SampleTimes": "simulation.record",
        "Envelope": "simulation.record",
        "LastRevolutions": "simulation.record",
        "load_run": "results.store",
        "save_run": "results.store",
    },
    "plot": {
        "answer": "plots.answer",
        "machine": "sketch",
        "run_up": "plots.run.run_up",
        "race": "plots.run.race_and_orbit",
        "orbit": "plots.run.race_and_orbit",
        "design": "plots.studies",
        "map": "plots.stability_map",
        "borders": "plots.stability_map",
        "branches": "plots.branches",
        "campbell": "plots.rotor",
        "modes": "plots.rotor",
        "response": "plots.rotor",
        "stepped_response": "plots.run.stepped_response",
        "drag_laws": "plots.drag",
        "orders": "plots.signals",
        "spectrum": "plots.signals",
        "order_map": "plots.signals",
        "chamber_run": "plots.chamber_runs",
        "chamber_arrangement": "plots.chamber_view",
    },
    "catalog": {
        "bearings": "catalog.product_tables",
        "bearing": "catalog.product_tables",
        "suitable_bearings": "catalog.product_tables",
        "fluids": "catalog.product_tables",
        "fluid": "catalog.product_tables",
        "blend": "catalog.product_tables",
        "materials": "catalog.product_tables",
        "friction": "catalog.product_tables",
        "examples": "files.examples",
        "example_path": "files.samples",
    },
    "stability": {
        "eigenvalues": "stability.states.questions",
        "equilibria": "stability.states.questions",
        "borders": "stability.maps.exact",
        "border_curve": "stability.maps.curve",
        "averaged_border": "stability.maps.exact",
        "explicit_averaged_border": "stability.averaged",
        "map": "stability.maps.stability_map",
        "branches": "stability.branch_diagrams",
        "bifurcation_curves": "stability.branch_diagrams",
        "minimum_viscosity": "stability.maps.curve",
        "minimum_drag": "stability.maps.curve",
        "stable_windows": "stability.maps.exact",
        "speed_windows": "stability.averaged",
        "held_by_friction": "stability.friction",
        "ranges": "stability.states.questions",
    },
    "rotor": {
        "modes": "rotordynamics.campbell",
        "campbell": "rotordynamics.campbell",
        "critical_speeds": "rotordynamics.campbell",
        "response": "rotordynamics.response",
        "response_peaks": "rotordynamics.response",
        "whirl_orbits": "rotordynamics.response",
        "liquid_response": "rotordynamics.liquid",
        "torsional_modes": "rotordynamics.torsion",
        "torsional_critical_speeds": "rotordynamics.torsion",
        "torsional_response": "rotordynamics.torsion",
        "identify": "rotordynamics.identify",
        "FreeParameter": "rotordynamics.parameter_fit",
        **dict.fromkeys(
            ("MeasuredMode", "MeasuredCriticalSpeed", "MeasuredResponse", "MeasuredStiffness", "KnownValue"),
            "rotordynamics.parameter_fit",
        ),
        "load_measurements": "measurement.run_up_fit",
        "equivalent_planar": "rotordynamics.equivalent_planar",
        "from_matrices": "files.matrix_files",
        "from_ross": "rotordynamics.equivalent_planar",
        "lateral_model": "assembly.rotors",
    },
    "flow": {
        "annulus_flow": "flow.annulus_problem",
        "ball_drag": "flow.ball_problem",
        "Channel": "flow.ball_problem",
        "recorded_speed": "flow.relaxation",
        "spin_up": "flow.relaxation",
    },
    "chamber": {
        "Archive": "results.archive",
        "archived_run": "studies.chamber_study",
        "amplitudes": "studies.chamber_study",
        "variant": "studies.chamber_study",
        "optimal_means": "studies.chamber_study",
        "over_seeds": "studies.chamber_study",
        "pick_up_borders": "studies.chamber_study",
        "step_size": "studies.chamber_study",
        "bounds": "simulation.chamber.bounds",
        "design_sensitivity": "studies.design.chambers",
        "unbalance_of": "results.chamber_measures",
    },
    "measure": {
        "load_receptance": "rotordynamics.receptances",
        "equal_balls": "measurement.loop",
        "modes_of": "rotordynamics.rational_fit",
        "receptance": "rotordynamics.rational_fit",
        "receptance_rotor": "rotordynamics.receptances",
        "receptance_border": "measurement.loop",
        "receptance_stability": "measurement.loop",
        "receptance_loop": "measurement.loop",
        "decay_rate": "measurement.spectrum",
        "equilibrium_angle": "measurement.equilibrium_angles",
        "load_angle_series": "measurement.equilibrium_angles",
        "evaluate_angles": "measurement.equilibrium_angles",
        "rubber": "measurement.rubber",
        "rubber_loops": "measurement.rubber",
        "rubber_resonances": "measurement.rubber",
        "rubber_signals": "measurement.rubber",
        "load_rubber": "measurement.rubber",
        **dict.fromkeys(("Exposure", "film_camera", "film_setup", "render_film"), "measurement.film.drawn"),
        "load_film_setup": "measurement.film.setup",
        **dict.fromkeys(("photographed_angles", "rest_histogram"), "measurement.film.photograph"),
        "Film": "measurement.film.photograph",
        "track_balls": "measurement.film.track",
        "rectified_picture": "measurement.film.track",
        "Channel": "measurement.signals",
        "signals": "measurement.signals",
        "load_signals": "measurement.load_signals",
        **dict.fromkeys(("TrialMass", "Reading", "BalanceRun"), "measurement.balancing.runs"),
        "load_balance_runs": "measurement.balancing.runs",
        "balance": "measurement.balancing.balance",
        "four_run": "measurement.balancing.four_run",
        "split_mass": "measurement.balancing.runs",
        "trial_mass": "measurement.balancing.four_run",
        "race_shape": "measurement.race_measurements",
        "rest_friction": "measurement.race_measurements",
        "drag_from_lag": "measurement.race_measurements",
        "unbalance_from_run_down": "measurement.balancing.run_down",
        "Sensor": "measurement.sensors",
        "Tacho": "measurement.sensors",
        "record": "measurement.sensors",
        "rotor_angle": "measurement.tacho",
        "orders": "measurement.tracking",
        "fit_run_up": "measurement.run_up_fit",
        "MeasuredRunUp": "measurement.pairs",
        "MeasuredOrders": "measurement.run_up_fit",
        "spectrum": "measurement.spectrum",
        "order_map": "measurement.spectrum",
        "converted": "measurement.spectrum",
        "damping": "measurement.orbit",
        "half_power": "measurement.orbit",
        "orbit": "measurement.orbit",
        "envelope": "measurement.orbit",
    },
    "laws": {
        "capability": "laws.capabilities",
        "largest_count": "laws.capabilities",
        "largest_useful_count": "laws.capabilities",
        "balance_grade": "laws.capabilities",
        "permissible_unbalance": "laws.capabilities",
        "register": "machine.plugins",
        "load": "machine.plugins",
        "drag_laws": "drag",
        "sphere_on_plane": "drag.sphere_on_plane",
        "race_geometry": "drag.race_geometry",
        "discoidal": "drag.discoidal",
        "free_sphere": "drag.free_sphere",
        "linear_drag_law": "laws.drag_coefficient",
        "sampled_drag_law": "laws.drag_coefficient",
        "DragCurve": "laws.drag_coefficient",
        "rest_interval": "laws.stall",
        "slipstream_factor": "laws.drag_coefficient",
        "slipstream_factors": "laws.drag_coefficient",
        "stall_ranges": "laws.stall",
        "stall_balance": "laws.stall",
        "StalledBall": "laws.stall",
        "planar_receptance": "laws.stall",
        "yielding_factor": "laws.impacts",
        "first_yield": "laws.impacts",
        "stokes_number": "laws.impacts",
        "wet_factor": "laws.impacts",
        "RubberLaw": "laws.rubber",
    },
}

ABOUT = {
    "plot": "Pictures of runs and results, each a Matplotlib figure; ``style`` is their common look.",
    "catalog": "Bearings, fluids, ball materials and typical friction, each with its source.",
    "stability": "From which speed on the balancer works, how sure that is, and what happens otherwise.",
    "rotor": "The rotor itself: modes, critical speeds, responses, and which rotor has measured ones.",
    "flow": "The fluid in a race that turns with the rotor, and the drag on a ball in it.",
    "chamber": "Deep chambers: archives of runs, studies over ball number and friction, measures of their own.",
    "measure": "From measured data to numbers: signals, receptances, decays, ball angles, drag and rolling resistance.",
    "laws": "Closed formulas on plain numbers, each with its source.",
}
MODULES = {"": {"machine": "machine", "errors": "errors", "units": "units"}, "plot": {"style": "plots.style"}}
FIGURES = {
    "plot": "plot",
    "catalog rigs": "catalog.examples",
    "catalog rig": "example",
    "measure run-down": "measure.unbalance_from_run_down",
    "chamber archive": "chamber.Archive",
    "chamber reactions": "chamber.archived_run",
    "measure signals": "measure.load_signals",
    "measure balls": "measure.track_balls",
    "measure film": "measure.render_film",
}  # no one function

# Namespaces: a name is imported when it is first used.


PACKAGE = "autobalancer"


def public(space: str, names: dict[str, Any]) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module whose public names are those of ``space``.

    ``names`` are the globals of the module, which keep what was imported. The types are in the stub beside the module, which
    ``tools/write_stubs.py`` writes from the same table.
    """
    homes, modules = NAMES[space], dict(MODULES.get(space, {}))
    if not space:
        modules |= {name: name for name in ABOUT}
    listed = sorted([*homes, *modules])

    def get(name: str) -> Any:
        if name in modules:
            value: Any = import_module(f"{PACKAGE}.{modules[name]}")
        elif name in homes:
            value = getattr(import_module(f"{PACKAGE}.{homes[name]}"), name)
        else:
            raise AttributeError(f"module {names['__name__']!r} has no attribute {name!r}{hint(space, name)}")
        names[name] = value
        return value

    return get, lambda: sorted([*listed, *(["__version__"] if not space else [])]), listed


def function_of(command: str) -> str:
    """The public function of a command, without ``ab.``: its last word, wherever it lives; empty if there is none."""
    if command in FIGURES:
        return FIGURES[command]
    *group, last = command.replace("-", "_").split()
    spaces = [*group, *(space for space in ("", *ABOUT) if space not in group and space != "plot")]
    return next((f"{space}.{last}".lstrip(".") for space in spaces if last in NAMES.get(space, ())), "")


def hint(space: str, name: str) -> str:
    """Where a name is that somebody looked for in a namespace, or which one was meant; empty if there is none."""
    if name.startswith("_"):
        return ""
    places = [_path(other, name) for other in NAMES if name in NAMES[other]]
    if places:
        return f"; there is {' and '.join(places)}"
    from difflib import get_close_matches

    near = [_path(space, one) for one in get_close_matches(name, NAMES[space], n=2, cutoff=0.75)]
    near += [
        _path(other, one) for other in NAMES if other != space for one in get_close_matches(name, NAMES[other], 1, 0.85)
    ]
    return f"; did you mean {' or '.join(near[:3])}?" if near else ""


def _path(space: str, name: str) -> str:
    return f"ab.{space}.{name}" if space else f"ab.{name}"
