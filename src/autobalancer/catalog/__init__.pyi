# written by tools/write_stubs.py from public_names.py

from autobalancer.catalog.product_tables import bearing as bearing
from autobalancer.catalog.product_tables import bearings as bearings
from autobalancer.catalog.product_tables import blend as blend
from autobalancer.catalog.product_tables import fluid as fluid
from autobalancer.catalog.product_tables import fluids as fluids
from autobalancer.catalog.product_tables import friction as friction
from autobalancer.catalog.product_tables import materials as materials
from autobalancer.catalog.product_tables import suitable_bearings as suitable_bearings
from autobalancer.files.examples import examples as examples
from autobalancer.files.samples import example_path as example_path

__all__ = [
    "bearing",
    "bearings",
    "blend",
    "example_path",
    "examples",
    "fluid",
    "fluids",
    "friction",
    "materials",
    "suitable_bearings",
]
