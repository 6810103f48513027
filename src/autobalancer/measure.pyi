# written by tools/write_stubs.py from public_names.py

from autobalancer.measurement.balancing.balance import balance as balance
from autobalancer.measurement.balancing.four_run import four_run as four_run
from autobalancer.measurement.balancing.four_run import trial_mass as trial_mass
from autobalancer.measurement.balancing.run_down import unbalance_from_run_down as unbalance_from_run_down
from autobalancer.measurement.balancing.runs import BalanceRun as BalanceRun
from autobalancer.measurement.balancing.runs import Reading as Reading
from autobalancer.measurement.balancing.runs import TrialMass as TrialMass
from autobalancer.measurement.balancing.runs import load_balance_runs as load_balance_runs
from autobalancer.measurement.balancing.runs import split_mass as split_mass
from autobalancer.measurement.equilibrium_angles import equilibrium_angle as equilibrium_angle
from autobalancer.measurement.equilibrium_angles import evaluate_angles as evaluate_angles
from autobalancer.measurement.equilibrium_angles import load_angle_series as load_angle_series
from autobalancer.measurement.film.drawn import Exposure as Exposure
from autobalancer.measurement.film.drawn import film_camera as film_camera
from autobalancer.measurement.film.drawn import film_setup as film_setup
from autobalancer.measurement.film.drawn import render_film as render_film
from autobalancer.measurement.film.photograph import Film as Film
from autobalancer.measurement.film.photograph import photographed_angles as photographed_angles
from autobalancer.measurement.film.photograph import rest_histogram as rest_histogram
from autobalancer.measurement.film.setup import load_film_setup as load_film_setup
from autobalancer.measurement.film.track import rectified_picture as rectified_picture
from autobalancer.measurement.film.track import track_balls as track_balls
from autobalancer.measurement.load_signals import load_signals as load_signals
from autobalancer.measurement.loop import equal_balls as equal_balls
from autobalancer.measurement.loop import receptance_border as receptance_border
from autobalancer.measurement.loop import receptance_loop as receptance_loop
from autobalancer.measurement.loop import receptance_stability as receptance_stability
from autobalancer.measurement.orbit import damping as damping
from autobalancer.measurement.orbit import envelope as envelope
from autobalancer.measurement.orbit import half_power as half_power
from autobalancer.measurement.orbit import orbit as orbit
from autobalancer.measurement.pairs import MeasuredRunUp as MeasuredRunUp
from autobalancer.measurement.race_measurements import drag_from_lag as drag_from_lag
from autobalancer.measurement.race_measurements import race_shape as race_shape
from autobalancer.measurement.race_measurements import rest_friction as rest_friction
from autobalancer.measurement.rubber import load_rubber as load_rubber
from autobalancer.measurement.rubber import rubber as rubber
from autobalancer.measurement.rubber import rubber_loops as rubber_loops
from autobalancer.measurement.rubber import rubber_resonances as rubber_resonances
from autobalancer.measurement.rubber import rubber_signals as rubber_signals
from autobalancer.measurement.run_up_fit import MeasuredOrders as MeasuredOrders
from autobalancer.measurement.run_up_fit import fit_run_up as fit_run_up
from autobalancer.measurement.sensors import Sensor as Sensor
from autobalancer.measurement.sensors import Tacho as Tacho
from autobalancer.measurement.sensors import record as record
from autobalancer.measurement.signals import Channel as Channel
from autobalancer.measurement.signals import signals as signals
from autobalancer.measurement.spectrum import converted as converted
from autobalancer.measurement.spectrum import decay_rate as decay_rate
from autobalancer.measurement.spectrum import order_map as order_map
from autobalancer.measurement.spectrum import spectrum as spectrum
from autobalancer.measurement.tacho import rotor_angle as rotor_angle
from autobalancer.measurement.tracking import orders as orders
from autobalancer.rotordynamics.rational_fit import modes_of as modes_of
from autobalancer.rotordynamics.rational_fit import receptance as receptance
from autobalancer.rotordynamics.receptances import load_receptance as load_receptance
from autobalancer.rotordynamics.receptances import receptance_rotor as receptance_rotor

__all__ = [
    "BalanceRun",
    "Channel",
    "Exposure",
    "Film",
    "MeasuredOrders",
    "MeasuredRunUp",
    "Reading",
    "Sensor",
    "Tacho",
    "TrialMass",
    "balance",
    "converted",
    "damping",
    "decay_rate",
    "drag_from_lag",
    "envelope",
    "equal_balls",
    "equilibrium_angle",
    "evaluate_angles",
    "film_camera",
    "film_setup",
    "fit_run_up",
    "four_run",
    "half_power",
    "load_angle_series",
    "load_balance_runs",
    "load_film_setup",
    "load_receptance",
    "load_rubber",
    "load_signals",
    "modes_of",
    "orbit",
    "order_map",
    "orders",
    "photographed_angles",
    "race_shape",
    "receptance",
    "receptance_border",
    "receptance_loop",
    "receptance_rotor",
    "receptance_stability",
    "record",
    "rectified_picture",
    "render_film",
    "rest_friction",
    "rest_histogram",
    "rotor_angle",
    "rubber",
    "rubber_loops",
    "rubber_resonances",
    "rubber_signals",
    "signals",
    "spectrum",
    "split_mass",
    "track_balls",
    "trial_mass",
    "unbalance_from_run_down",
]
