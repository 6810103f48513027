# written by tools/write_stubs.py from public_names.py

from autobalancer.stability.averaged import explicit_averaged_border as explicit_averaged_border
from autobalancer.stability.averaged import speed_windows as speed_windows
from autobalancer.stability.branch_diagrams import bifurcation_curves as bifurcation_curves
from autobalancer.stability.branch_diagrams import branches as branches
from autobalancer.stability.friction import held_by_friction as held_by_friction
from autobalancer.stability.maps.curve import border_curve as border_curve
from autobalancer.stability.maps.curve import minimum_drag as minimum_drag
from autobalancer.stability.maps.curve import minimum_viscosity as minimum_viscosity
from autobalancer.stability.maps.exact import averaged_border as averaged_border
from autobalancer.stability.maps.exact import borders as borders
from autobalancer.stability.maps.exact import stable_windows as stable_windows
from autobalancer.stability.maps.stability_map import map as map
from autobalancer.stability.states.questions import eigenvalues as eigenvalues
from autobalancer.stability.states.questions import equilibria as equilibria
from autobalancer.stability.states.questions import ranges as ranges

__all__ = [
    "averaged_border",
    "bifurcation_curves",
    "border_curve",
    "borders",
    "branches",
    "eigenvalues",
    "equilibria",
    "explicit_averaged_border",
    "held_by_friction",
    "map",
    "minimum_drag",
    "minimum_viscosity",
    "ranges",
    "speed_windows",
    "stable_windows",
]
