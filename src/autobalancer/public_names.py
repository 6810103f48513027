"""Where each public name lives: it is imported from there when it is first used."""

from __future__ import annotations

NAMES: dict[str, dict[str, str]] = {
    "": {
        "load_machine": "files.machine_file:read_machine",
        "save_machine": "files.machine_file",
        "machine_text": "files.machine_file",
        "parse_machine": "files.machine_file",
        "with_parameter": "assembly.quantities:with_named",
        "machine_schema": "machine.schema",
        "keys": "machine.schema:file_tables",
        "example": "files.examples",
        "check": "either_kind",
        "simulate": "either_kind",
        "sweep": "studies.sweep",
        "basin": "studies.basin",
        "worst_start": "studies.worst_start",
        "stepped_response": "studies.frequency_response:frequency_response",
        "verdict": "either_kind",
        "measures": "either_kind",
        "animate": "either_kind",
        "Event": "simulation.events",
        "Samples": "simulation.sampling",
        "SampleTimes": "simulation.sampling",
        "Envelope": "simulation.sampling",
        "LastRevolutions": "simulation.sampling",
        "load_run": "results.store",
        "save_run": "results.store",
        "vibration": "results.places",
        "static_deflection": "results.places",
        "residual_unbalance": "results.places",
        "support_forces": "results.places",
        "deflection_envelope": "results.measures",
        "residual_vibration": "results.measures",
        "peak_deflection": "results.measures",
        "settling_time": "results.measures",
        "release_speed": "results.measures",
        "ball_angle_to_unbalance": "results.measures",
    },
    "plot": {
        "run_up": "plots.run.run_up:plot_run_up",
        "race": "plots.run.race:plot_race",
        "orbit": "plots.run.orbit:plot_orbit",
        "basin": "plots.stability.basins:plot_basin",
        "eigenvalues": "plots.stability.growth:plot_stability",
        "map": "plots.stability.stability_map:plot_map",
        "border_curve": "plots.stability.border_curve:plot_border_curve",
        "receptance": "plots.measured.receptance:plot_receptance",
        "nyquist": "plots.measured.receptance:plot_nyquist",
        "branches": "plots.stability.branches:plot_branches",
        "bifurcation_curves": "plots.stability.bifurcation_curves:plot_bifurcation_curves",
        "campbell": "plots.rotor.campbell:plot_campbell",
        "modes": "plots.rotor.modes:plot_modes",
        "response": "plots.rotor.unbalance_response:plot_unbalance_response",
        "polar_response": "plots.rotor.unbalance_response:plot_polar_response",
        "whirl_orbits": "plots.rotor.whirl:plot_whirl_orbits",
        "whirl_along_axis": "plots.rotor.whirl:plot_whirl_along_axis",
        "identification": "plots.measured.identification:plot_identification",
        "equivalent_planar": "plots.rotor.equivalent_planar:plot_equivalent_planar",
        "stepped_response": "plots.run.frequency_response:plot_frequency_response",
        "flow": "plots.measured.flow:plot_flow",
        "spin_up": "plots.measured.flow:plot_spin_up",
        "velocity_profiles": "plots.measured.flow:plot_velocity_profiles",
        "secondary_flow": "plots.measured.flow:plot_secondary_flow",
        "drag_laws": "plots.measured.drag:plot_drag_laws",
        "ball_drag": "plots.measured.ball_drag:plot_ball_drag",
        "equilibrium_angle": "plots.measured.equilibrium_angle:plot_equilibrium_angles",
        "measured_drag": "plots.measured.equilibrium_angle:plot_measured_drag",
        "chamber_run": "plots.chamber.history:plot_chamber_run",
        "chamber_energy": "plots.chamber.history:plot_energy",
        "chamber_collisions": "plots.chamber.history:plot_collisions",
        "chamber_arrangement": "plots.chamber.arrangement:plot_arrangement",
        "chamber_reactions": "plots.chamber.reactions:plot_reactions",
        "chamber_bearing_forces": "plots.chamber.reactions:plot_bearing_forces",
        "chamber_amplitudes": "plots.chamber.study:plot_amplitudes",
        "chamber_optimal_means": "plots.chamber.study:plot_optimal_means",
        "chamber_carried": "plots.chamber.study:plot_carried",
    },
    "catalog": {
        "bearings": "catalog.bearing_table",
        "bearing": "catalog.bearing_table",
        "suitable_bearings": "catalog.bearing_table",
        "fluids": "catalog.fluid_table",
        "fluid": "catalog.fluid_table",
        "blend": "catalog.fluid_table",
        "materials": "catalog.material_table",
        "friction": "catalog.friction_table:friction_coefficients",
        "rig": "files.rigs",
        "rigs": "files.rigs",
        "rig_text": "files.rigs",
        "examples": "files.examples",
        "example_text": "files.examples",
        "example_path": "files.samples",
        "write_example": "files.samples",
    },
    "stability": {
        "eigenvalues": "stability.states.questions",
        "equilibria": "stability.states.questions",
        "borders": "stability.maps.speeds:border_speeds",
        "border_curve": "stability.maps.curve",
        "averaged_border": "stability.maps.averaged",
        "explicit_averaged_border": "stability.averaged.formulas",
        "map": "stability.maps.stability_map:stability_map",
        "branches": "stability.diagrams.branches",
        "bifurcation_curves": "stability.diagrams.curves",
        "minimum_viscosity": "stability.maps.minimum",
        "minimum_drag": "stability.maps.minimum",
        "stable_windows": "stability.maps.windows",
        "speed_windows": "stability.averaged.phase_windows",
        "held_by_friction": "stability.friction.held",
        "ranges": "stability.states.ranges:stability_ranges",
    },
    "rotor": {
        "modes": "rotordynamics.modes:eigenfrequencies",
        "campbell": "rotordynamics.campbell",
        "critical_speeds": "rotordynamics.critical",
        "response": "rotordynamics.response:unbalance_response",
        "response_peaks": "rotordynamics.peaks",
        "whirl_orbits": "rotordynamics.orbits",
        "identify": "rotordynamics.identification.identify",
        "FreeParameter": "rotordynamics.identification.free",
        "MeasuredMode": "rotordynamics.identification.measurements",
        "MeasuredCriticalSpeed": "rotordynamics.identification.measurements",
        "MeasuredResponse": "rotordynamics.identification.measurements",
        "MeasuredStiffness": "rotordynamics.identification.measurements",
        "KnownValue": "rotordynamics.identification.measurements",
        "load_measurements": "rotordynamics.identification.measurement_file",
        "equivalent_planar": "rotordynamics.equivalent_planar",
        "from_ross": "rotordynamics.from_ross",
        "lateral_model": "assembly.rotors",
    },
    "flow": {
        "annulus_flow": "flow.question",
        "Annulus": "flow.annulus",
        "ball_drag": "flow.ball.question",
        "Channel": "flow.ball.channel",
        "Walls": "flow.annulus",
        "annulus_of": "flow.annulus",
        "recorded_speed": "flow.speed",
        "relaxation_modes": "flow.relaxation",
        "RelaxationModes": "flow.relaxation",
        "spin_up": "flow.spinning_up",
        "SpinUp": "flow.spinning_up",
    },
    "chamber": {
        "Archive": "results.archive.folder",
        "archived_run": "studies.chamber_runs",
        "amplitudes": "studies.chamber_amplitudes:chamber_amplitudes",
        "variant": "studies.chamber_machines:chamber_variant",
        "optimal_means": "studies.chamber_means",
        "over_seeds": "studies.chamber_means",
        "pick_up_borders": "studies.chamber_means",
        "step_size": "studies.step_size:step_size_study",
        "collision_statistics": "results.chamber.measures",
        "balls_unbalance": "results.chamber.balls",
        "residual_of_balls": "results.chamber.balls",
        "unbalance_of": "results.chamber.shape",
        "unconstrained_motion": "results.chamber.unconstrained",
    },
    "measure": {
        "load_receptance": "measurement.receptance.measured",
        "equal_balls": "measurement.loop.balls",
        "RaceBalls": "measurement.loop.balls",
        "balls_of": "measurement.loop.balls",
        "modes_of": "measurement.receptance.rational_fit",
        "receptance": "measurement.receptance.rational_fit:fit_receptance",
        "receptance_border": "measurement.loop.border",
        "receptance_stability": "measurement.loop.growth",
        "receptance_loop": "measurement.loop.curve",
        "decay_rate": "measurement.decay",
        "TurnedRace": "measurement.angle.statics",
        "equilibrium_angles": "measurement.angle.statics",
        "drag_coefficients": "measurement.angle.statics",
        "fit_rolling_resistance": "measurement.angle.rolling_resistance",
        "rolling_resistance_deviation": "measurement.angle.rolling_resistance",
        "equilibrium_angle": "measurement.angle.curve:angle_against_speed",
        "load_angle_series": "measurement.angle.file",
        "evaluate_angles": "measurement.angle.evaluation",
    },
    "laws": {
        "capability": "laws.ball_capability",
        "largest_count": "laws.ball_capability",
        "largest_useful_count": "laws.ball_capability",
        "balance_grade": "laws.balance_quality",
        "permissible_unbalance": "laws.balance_quality",
        "register": "machine.leaves",
        "load": "files.own_leaves",
        "drag_laws": "drag",
        "sphere_on_plane": "drag.sphere_on_plane",
        "race_geometry": "drag.race_geometry",
        "discoidal": "drag.discoidal",
        "free_sphere": "drag.free_sphere",
        "linear_drag_law": "laws.drag_coefficient:linear",
        "sampled_drag_law": "laws.drag_coefficient:sampled",
        "DragCurve": "laws.drag_curve",
        "rest_interval": "laws.resting",
        "held_whirl": "laws.held_by_friction",
        "slipstream_factor": "laws.slipstream",
        "slipstream_factors": "laws.slipstream",
        "stall_ranges": "laws.stall",
        "stall_balance": "laws.stall",
        "holding_speed": "laws.stall",
        "StalledBall": "laws.stall",
        "planar_receptance": "laws.stall",
    },
}

ABOUT = {
    "plot": "Pictures of runs and results, each a Matplotlib figure; ``style`` is their common look.",
    "catalog": "Bearings, fluids, ball materials and typical friction, each with its source.",
    "stability": "From which speed on the balancer works, how sure that is, and what happens otherwise.",
    "rotor": "The rotor itself: modes, critical speeds, responses, and which rotor has measured ones.",
    "flow": "The fluid in a race that turns with the rotor, and the drag on a ball in it.",
    "chamber": "Deep chambers: archives of runs, studies over ball number and friction, measures of their own.",
    "measure": "From measured data to numbers: receptances, decays, ball angles, drag and rolling resistance.",
    "laws": "Closed formulas on plain numbers, each with its source.",
}
MODULES = {"": {"machine": "machine", "errors": "errors", "units": "units"}, "plot": {"style": "plots.drawing.style"}}
DRAWN = {
    "plot": "plot",
    "chamber archive": "chamber.Archive",
    "chamber reactions": "plot.chamber_reactions",
}  # no one function


def function_of(command: str) -> str:
    """The public function of a command, without ``ab.``: its last word, wherever it lives; empty if there is none."""
    if command in DRAWN:
        return DRAWN[command]
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
