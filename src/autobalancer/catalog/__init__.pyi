# written by tools/write_stubs.py from public_names.py

from autobalancer.catalog.product_tables import bearing as bearing
from autobalancer.catalog.product_tables import bearings as bearings
from autobalancer.catalog.product_tables import blend as blend
from autobalancer.catalog.product_tables import fluid as fluid
from autobalancer.catalog.product_tables import fluids as fluids
from autobalancer.catalog.product_tables import friction as friction
from autobalancer.catalog.product_tables import materials as materials
from autobalancer.catalog.product_tables import suitable_bearings as suitable_bearings
from autobalancer.files.examples import example_text as example_text
from autobalancer.files.examples import examples as examples
from autobalancer.files.examples import rig as rig
from autobalancer.files.examples import rig_text as rig_text
from autobalancer.files.examples import rigs as rigs
from autobalancer.files.samples import example_path as example_path
from autobalancer.files.samples import write_example as write_example

__all__ = [
    "bearing",
    "bearings",
    "blend",
    "example_path",
    "example_text",
    "examples",
    "fluid",
    "fluids",
    "friction",
    "materials",
    "rig",
    "rig_text",
    "rigs",
    "suitable_bearings",
    "write_example",
]
