# written by tools/write_stubs.py from public_names.py

from autobalancer import catalog as catalog
from autobalancer import chamber as chamber
from autobalancer import errors as errors
from autobalancer import flow as flow
from autobalancer import laws as laws
from autobalancer import machine as machine
from autobalancer import measure as measure
from autobalancer import plot as plot
from autobalancer import rotor as rotor
from autobalancer import stability as stability
from autobalancer import units as units
from autobalancer.api import check as check
from autobalancer.api import compare as compare
from autobalancer.api import design as design
from autobalancer.api import run_measures as run_measures
from autobalancer.api import simulate as simulate
from autobalancer.api import verdict as verdict
from autobalancer.app.view.widget import widget as widget
from autobalancer.assembly.quantities import with_parameter as with_parameter
from autobalancer.exchange import export as export
from autobalancer.files.examples import example as example
from autobalancer.files.machine_file import load_machine as load_machine
from autobalancer.files.machine_file import machine_text as machine_text
from autobalancer.files.machine_file import parse_machine as parse_machine
from autobalancer.files.machine_file import save_machine as save_machine
from autobalancer.machine.schema import keys as keys
from autobalancer.plots.film_frames import animate as animate
from autobalancer.reporting.report import report as report
from autobalancer.results.store import load_run as load_run
from autobalancer.results.store import save_run as save_run
from autobalancer.simulation.balancer_element import balancer_element as balancer_element
from autobalancer.simulation.record import Envelope as Envelope
from autobalancer.simulation.record import Event as Event
from autobalancer.simulation.record import LastRevolutions as LastRevolutions
from autobalancer.simulation.record import SampleTimes as SampleTimes
from autobalancer.simulation.record import Samples as Samples
from autobalancer.studies.basin import basin as basin
from autobalancer.studies.design.designs import designed_machine as designed_machine
from autobalancer.studies.ensemble.ensemble import ensemble as ensemble
from autobalancer.studies.random_starts import sweep as sweep
from autobalancer.studies.random_starts import worst_start as worst_start
from autobalancer.studies.stepped_response import stepped_response as stepped_response
from autobalancer.studies.study.study import envelopes as envelopes
from autobalancer.studies.study.study import sensitivity as sensitivity
from autobalancer.studies.study.study import study as study

__version__: str

__all__ = [
    "Envelope",
    "Event",
    "LastRevolutions",
    "SampleTimes",
    "Samples",
    "animate",
    "balancer_element",
    "basin",
    "catalog",
    "chamber",
    "check",
    "compare",
    "design",
    "designed_machine",
    "ensemble",
    "envelopes",
    "errors",
    "example",
    "export",
    "flow",
    "keys",
    "laws",
    "load_machine",
    "load_run",
    "machine",
    "machine_text",
    "measure",
    "parse_machine",
    "plot",
    "report",
    "rotor",
    "run_measures",
    "save_machine",
    "save_run",
    "sensitivity",
    "simulate",
    "stability",
    "stepped_response",
    "study",
    "sweep",
    "units",
    "verdict",
    "widget",
    "with_parameter",
    "worst_start",
]
