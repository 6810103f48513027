# written by tools/write_stubs.py from public_names.py

from autobalancer.plots import style as style
from autobalancer.plots.chamber.chamber_runs import chamber_amplitudes as chamber_amplitudes
from autobalancer.plots.chamber.chamber_runs import chamber_archive as chamber_archive
from autobalancer.plots.chamber.chamber_runs import chamber_bearing_forces as chamber_bearing_forces
from autobalancer.plots.chamber.chamber_runs import chamber_carried as chamber_carried
from autobalancer.plots.chamber.chamber_runs import chamber_collisions as chamber_collisions
from autobalancer.plots.chamber.chamber_runs import chamber_energy as chamber_energy
from autobalancer.plots.chamber.chamber_runs import chamber_optimal_means as chamber_optimal_means
from autobalancer.plots.chamber.chamber_runs import chamber_reactions as chamber_reactions
from autobalancer.plots.chamber.chamber_runs import chamber_run as chamber_run
from autobalancer.plots.chamber.chamber_runs import chamber_step_size as chamber_step_size
from autobalancer.plots.chamber.view import chamber_arrangement as chamber_arrangement
from autobalancer.plots.measured.balancing import balancing as balancing
from autobalancer.plots.measured.balancing import ball_film as ball_film
from autobalancer.plots.measured.balancing import four_run as four_run
from autobalancer.plots.measured.balancing import race_shape as race_shape
from autobalancer.plots.measured.balancing import rectified_picture as rectified_picture
from autobalancer.plots.measured.balancing import rest_histogram as rest_histogram
from autobalancer.plots.measured.balancing import rests as rests
from autobalancer.plots.measured.balancing import run_down as run_down
from autobalancer.plots.measured.drag import ball_drag as ball_drag
from autobalancer.plots.measured.drag import drag_laws as drag_laws
from autobalancer.plots.measured.drag import equilibrium_angle as equilibrium_angle
from autobalancer.plots.measured.drag import flow as flow
from autobalancer.plots.measured.drag import measured_drag as measured_drag
from autobalancer.plots.measured.drag import secondary_flow as secondary_flow
from autobalancer.plots.measured.drag import spin_up as spin_up
from autobalancer.plots.measured.drag import velocity_profiles as velocity_profiles
from autobalancer.plots.measured.fits import identification as identification
from autobalancer.plots.measured.fits import nyquist as nyquist
from autobalancer.plots.measured.fits import overlay as overlay
from autobalancer.plots.measured.fits import receptance as receptance
from autobalancer.plots.measured.fits import rubber as rubber
from autobalancer.plots.rotor import campbell as campbell
from autobalancer.plots.rotor import equivalent_planar as equivalent_planar
from autobalancer.plots.rotor import liquid_response as liquid_response
from autobalancer.plots.rotor import modes as modes
from autobalancer.plots.rotor import polar_response as polar_response
from autobalancer.plots.rotor import response as response
from autobalancer.plots.rotor import torsional_response as torsional_response
from autobalancer.plots.rotor import whirl_along_axis as whirl_along_axis
from autobalancer.plots.rotor import whirl_orbits as whirl_orbits
from autobalancer.plots.run.race_and_orbit import orbit as orbit
from autobalancer.plots.run.race_and_orbit import race as race
from autobalancer.plots.run.run_up import comparison as comparison
from autobalancer.plots.run.run_up import drive_train as drive_train
from autobalancer.plots.run.run_up import impacts as impacts
from autobalancer.plots.run.run_up import run_up as run_up
from autobalancer.plots.run.stepped_response import stepped_response as stepped_response
from autobalancer.plots.signals import damping as damping
from autobalancer.plots.signals import measured_orbit as measured_orbit
from autobalancer.plots.signals import order_map as order_map
from autobalancer.plots.signals import orders as orders
from autobalancer.plots.signals import spectrum as spectrum
from autobalancer.plots.stability.branches import branches as branches
from autobalancer.plots.stability.ensembles import basin as basin
from autobalancer.plots.stability.ensembles import ensemble as ensemble
from autobalancer.plots.stability.ensembles import ensemble_distribution as ensemble_distribution
from autobalancer.plots.stability.ensembles import ensemble_scatter as ensemble_scatter
from autobalancer.plots.stability.stability_map import bifurcation_curves as bifurcation_curves
from autobalancer.plots.stability.stability_map import border_curve as border_curve
from autobalancer.plots.stability.stability_map import borders as borders
from autobalancer.plots.stability.stability_map import eigenvalues as eigenvalues
from autobalancer.plots.stability.stability_map import map as map
from autobalancer.plots.studies import design as design
from autobalancer.plots.studies import envelopes as envelopes
from autobalancer.plots.studies import rest_positions as rest_positions
from autobalancer.plots.studies import sensitivity as sensitivity
from autobalancer.plots.studies import study as study
from autobalancer.sketch import machine as machine

__all__ = [
    "balancing",
    "ball_drag",
    "ball_film",
    "basin",
    "bifurcation_curves",
    "border_curve",
    "borders",
    "branches",
    "campbell",
    "chamber_amplitudes",
    "chamber_archive",
    "chamber_arrangement",
    "chamber_bearing_forces",
    "chamber_carried",
    "chamber_collisions",
    "chamber_energy",
    "chamber_optimal_means",
    "chamber_reactions",
    "chamber_run",
    "chamber_step_size",
    "comparison",
    "damping",
    "design",
    "drag_laws",
    "drive_train",
    "eigenvalues",
    "ensemble",
    "ensemble_distribution",
    "ensemble_scatter",
    "envelopes",
    "equilibrium_angle",
    "equivalent_planar",
    "flow",
    "four_run",
    "identification",
    "impacts",
    "liquid_response",
    "machine",
    "map",
    "measured_drag",
    "measured_orbit",
    "modes",
    "nyquist",
    "orbit",
    "order_map",
    "orders",
    "overlay",
    "polar_response",
    "race",
    "race_shape",
    "receptance",
    "rectified_picture",
    "response",
    "rest_histogram",
    "rest_positions",
    "rests",
    "rubber",
    "run_down",
    "run_up",
    "secondary_flow",
    "sensitivity",
    "spectrum",
    "spin_up",
    "stepped_response",
    "study",
    "style",
    "torsional_response",
    "velocity_profiles",
    "whirl_along_axis",
    "whirl_orbits",
]
