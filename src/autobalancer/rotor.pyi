# written by tools/write_stubs.py from public_names.py

from autobalancer.assembly.rotors import lateral_model as lateral_model
from autobalancer.files.matrix_files import from_matrices as from_matrices
from autobalancer.measurement.run_up_fit import load_measurements as load_measurements
from autobalancer.rotordynamics.campbell import campbell as campbell
from autobalancer.rotordynamics.campbell import critical_speeds as critical_speeds
from autobalancer.rotordynamics.campbell import modes as modes
from autobalancer.rotordynamics.equivalent_planar import equivalent_planar as equivalent_planar
from autobalancer.rotordynamics.equivalent_planar import from_ross as from_ross
from autobalancer.rotordynamics.identify import identify as identify
from autobalancer.rotordynamics.liquid import liquid_response as liquid_response
from autobalancer.rotordynamics.parameter_fit import FreeParameter as FreeParameter
from autobalancer.rotordynamics.parameter_fit import KnownValue as KnownValue
from autobalancer.rotordynamics.parameter_fit import MeasuredCriticalSpeed as MeasuredCriticalSpeed
from autobalancer.rotordynamics.parameter_fit import MeasuredMode as MeasuredMode
from autobalancer.rotordynamics.parameter_fit import MeasuredResponse as MeasuredResponse
from autobalancer.rotordynamics.parameter_fit import MeasuredStiffness as MeasuredStiffness
from autobalancer.rotordynamics.response import response as response
from autobalancer.rotordynamics.response import response_peaks as response_peaks
from autobalancer.rotordynamics.response import whirl_orbits as whirl_orbits
from autobalancer.rotordynamics.torsion import torsional_critical_speeds as torsional_critical_speeds
from autobalancer.rotordynamics.torsion import torsional_modes as torsional_modes
from autobalancer.rotordynamics.torsion import torsional_response as torsional_response

__all__ = [
    "FreeParameter",
    "KnownValue",
    "MeasuredCriticalSpeed",
    "MeasuredMode",
    "MeasuredResponse",
    "MeasuredStiffness",
    "campbell",
    "critical_speeds",
    "equivalent_planar",
    "from_matrices",
    "from_ross",
    "identify",
    "lateral_model",
    "liquid_response",
    "load_measurements",
    "modes",
    "response",
    "response_peaks",
    "torsional_critical_speeds",
    "torsional_modes",
    "torsional_response",
    "whirl_orbits",
]
