# written by tools/write_stubs.py from public_names.py

from autobalancer.plots.chamber.arrangement import plot_arrangement as chamber_arrangement
from autobalancer.plots.chamber.history import plot_chamber_run as chamber_run
from autobalancer.plots.chamber.history import plot_collisions as chamber_collisions
from autobalancer.plots.chamber.history import plot_energy as chamber_energy
from autobalancer.plots.chamber.reactions import plot_bearing_forces as chamber_bearing_forces
from autobalancer.plots.chamber.reactions import plot_reactions as chamber_reactions
from autobalancer.plots.chamber.study import plot_amplitudes as chamber_amplitudes
from autobalancer.plots.chamber.study import plot_carried as chamber_carried
from autobalancer.plots.chamber.study import plot_optimal_means as chamber_optimal_means
from autobalancer.plots.drawing import style as style
from autobalancer.plots.measured.ball_drag import plot_ball_drag as ball_drag
from autobalancer.plots.measured.drag import plot_drag_laws as drag_laws
from autobalancer.plots.measured.equilibrium_angle import plot_equilibrium_angles as equilibrium_angle
from autobalancer.plots.measured.equilibrium_angle import plot_measured_drag as measured_drag
from autobalancer.plots.measured.flow import plot_flow as flow
from autobalancer.plots.measured.flow import plot_secondary_flow as secondary_flow
from autobalancer.plots.measured.flow import plot_spin_up as spin_up
from autobalancer.plots.measured.flow import plot_velocity_profiles as velocity_profiles
from autobalancer.plots.measured.identification import plot_identification as identification
from autobalancer.plots.measured.receptance import plot_nyquist as nyquist
from autobalancer.plots.measured.receptance import plot_receptance as receptance
from autobalancer.plots.rotor.campbell import plot_campbell as campbell
from autobalancer.plots.rotor.equivalent_planar import plot_equivalent_planar as equivalent_planar
from autobalancer.plots.rotor.modes import plot_modes as modes
from autobalancer.plots.rotor.unbalance_response import plot_polar_response as polar_response
from autobalancer.plots.rotor.unbalance_response import plot_unbalance_response as response
from autobalancer.plots.rotor.whirl import plot_whirl_along_axis as whirl_along_axis
from autobalancer.plots.rotor.whirl import plot_whirl_orbits as whirl_orbits
from autobalancer.plots.run.comparison import plot_comparison as comparison
from autobalancer.plots.run.orbit import plot_orbit as orbit
from autobalancer.plots.run.race import plot_race as race
from autobalancer.plots.run.run_up import plot_run_up as run_up
from autobalancer.plots.run.stepped_response import plot_stepped_response as stepped_response
from autobalancer.plots.stability.basins import plot_basin as basin
from autobalancer.plots.stability.bifurcation_curves import plot_bifurcation_curves as bifurcation_curves
from autobalancer.plots.stability.border_curve import plot_border_curve as border_curve
from autobalancer.plots.stability.branches import plot_branches as branches
from autobalancer.plots.stability.growth import plot_stability as eigenvalues
from autobalancer.plots.stability.stability_map import plot_map as map

__all__ = [
    "ball_drag",
    "basin",
    "bifurcation_curves",
    "border_curve",
    "branches",
    "campbell",
    "chamber_amplitudes",
    "chamber_arrangement",
    "chamber_bearing_forces",
    "chamber_carried",
    "chamber_collisions",
    "chamber_energy",
    "chamber_optimal_means",
    "chamber_reactions",
    "chamber_run",
    "comparison",
    "drag_laws",
    "eigenvalues",
    "equilibrium_angle",
    "equivalent_planar",
    "flow",
    "identification",
    "map",
    "measured_drag",
    "modes",
    "nyquist",
    "orbit",
    "polar_response",
    "race",
    "receptance",
    "response",
    "run_up",
    "secondary_flow",
    "spin_up",
    "stepped_response",
    "style",
    "velocity_profiles",
    "whirl_along_axis",
    "whirl_orbits",
]
