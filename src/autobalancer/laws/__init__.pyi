# written by tools/write_stubs.py from public_names.py

from autobalancer.drag import drag_laws as drag_laws
from autobalancer.drag.discoidal import discoidal as discoidal
from autobalancer.drag.free_sphere import free_sphere as free_sphere
from autobalancer.drag.race_geometry import race_geometry as race_geometry
from autobalancer.drag.sphere_on_plane import sphere_on_plane as sphere_on_plane
from autobalancer.laws.capabilities import balance_grade as balance_grade
from autobalancer.laws.capabilities import capability as capability
from autobalancer.laws.capabilities import largest_count as largest_count
from autobalancer.laws.capabilities import largest_useful_count as largest_useful_count
from autobalancer.laws.capabilities import permissible_unbalance as permissible_unbalance
from autobalancer.laws.drag_coefficient import DragCurve as DragCurve
from autobalancer.laws.drag_coefficient import linear_drag_law as linear_drag_law
from autobalancer.laws.drag_coefficient import sampled_drag_law as sampled_drag_law
from autobalancer.laws.drag_coefficient import slipstream_factor as slipstream_factor
from autobalancer.laws.drag_coefficient import slipstream_factors as slipstream_factors
from autobalancer.laws.impacts import first_yield as first_yield
from autobalancer.laws.impacts import stokes_number as stokes_number
from autobalancer.laws.impacts import wet_factor as wet_factor
from autobalancer.laws.impacts import yielding_factor as yielding_factor
from autobalancer.laws.rubber import RubberLaw as RubberLaw
from autobalancer.laws.stall import StalledBall as StalledBall
from autobalancer.laws.stall import planar_receptance as planar_receptance
from autobalancer.laws.stall import rest_interval as rest_interval
from autobalancer.laws.stall import stall_balance as stall_balance
from autobalancer.laws.stall import stall_ranges as stall_ranges
from autobalancer.machine.plugins import load as load
from autobalancer.machine.plugins import register as register

__all__ = [
    "DragCurve",
    "RubberLaw",
    "StalledBall",
    "balance_grade",
    "capability",
    "discoidal",
    "drag_laws",
    "first_yield",
    "free_sphere",
    "largest_count",
    "largest_useful_count",
    "linear_drag_law",
    "load",
    "permissible_unbalance",
    "planar_receptance",
    "race_geometry",
    "register",
    "rest_interval",
    "sampled_drag_law",
    "slipstream_factor",
    "slipstream_factors",
    "sphere_on_plane",
    "stall_balance",
    "stall_ranges",
    "stokes_number",
    "wet_factor",
    "yielding_factor",
]
