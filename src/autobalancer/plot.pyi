# written by tools/write_stubs.py from public_names.py

from autobalancer.plots import style as style
from autobalancer.plots.answer import answer as answer
from autobalancer.plots.branches import branches as branches
from autobalancer.plots.chamber_runs import chamber_run as chamber_run
from autobalancer.plots.chamber_view import chamber_arrangement as chamber_arrangement
from autobalancer.plots.drag import drag_laws as drag_laws
from autobalancer.plots.rotor import campbell as campbell
from autobalancer.plots.rotor import modes as modes
from autobalancer.plots.rotor import response as response
from autobalancer.plots.run.race_and_orbit import orbit as orbit
from autobalancer.plots.run.race_and_orbit import race as race
from autobalancer.plots.run.run_up import run_up as run_up
from autobalancer.plots.run.stepped_response import stepped_response as stepped_response
from autobalancer.plots.signals import order_map as order_map
from autobalancer.plots.signals import orders as orders
from autobalancer.plots.signals import spectrum as spectrum
from autobalancer.plots.stability_map import borders as borders
from autobalancer.plots.stability_map import map as map
from autobalancer.plots.studies import design as design
from autobalancer.sketch import machine as machine

__all__ = [
    "answer",
    "borders",
    "branches",
    "campbell",
    "chamber_arrangement",
    "chamber_run",
    "design",
    "drag_laws",
    "machine",
    "map",
    "modes",
    "orbit",
    "order_map",
    "orders",
    "race",
    "response",
    "run_up",
    "spectrum",
    "stepped_response",
    "style",
]
