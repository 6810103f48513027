"""The nouns: frozen, validated descriptions in SI, and no algorithms.

Leaves, such as drag laws, have a file each outside of this package; their classes are found here, and so are rotor models.
"""

from typing import TYPE_CHECKING

from autobalancer.errors import MachineError
from autobalancer.machine.balancer.fluid import BallInRace, Drag, Fluid, ShearLaw
from autobalancer.machine.balancer.force import Force, PairForce
from autobalancer.machine.balancer.race import Balancer, Balls, Race
from autobalancer.machine.balancer.resolved import (
    Contact,
    Friction,
    FrictionLaw,
    Harmonic,
    Partitions,
    ResolvedContact,
    Roundness,
)
from autobalancer.machine.chamber import (
    Chamber,
    ChamberBody,
    ChamberMachine,
    ChamberRotor,
    ChamberSupport,
    ChamberUnbalance,
    FreeBalls,
    HistoryContact,
    RestitutionContact,
)
from autobalancer.machine.drive import (
    AsynchronousDrive,
    AsynchronousMotor,
    Constant,
    ConstantTorque,
    Coupling,
    Dwell,
    Hill,
    MotorMount,
    PrescribedSpeed,
    Ramp,
    Reduction,
    Table,
    TargetTorque,
    TorqueRipple,
    TorqueTable,
)
from autobalancer.machine.keys import document
from autobalancer.machine.machine import (
    BaseMotion,
    Excitation,
    HarmonicForce,
    LiquidRing,
    Machine,
    RecordedBaseMotion,
    RecordedForce,
    RunPlan,
    Schedule,
    Start,
    Unbalance,
)
from autobalancer.machine.part import Quantity, key
from autobalancer.machine.plugins import Leaf, leaves_of
from autobalancer.machine.rotors import MODELS, Rotor
from autobalancer.machine.rotors.body import Body, Station
from autobalancer.machine.rotors.joint import Joint, PointJoint, Spot
from autobalancer.machine.rotors.modal import Coordinate, MatricesRotor, MatrixFiles, ModalRotor, ModeFiles, Resonance
from autobalancer.machine.rotors.multibody import MultibodyRotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.rotors.shaft import Disk, ShaftMaterial, ShaftRotor, ShaftSegment
from autobalancer.machine.rotors.support import Hardening, Rubber, RubberFriction, RubberRelaxation, SpeedTable, Support

if TYPE_CHECKING:
    from autobalancer.drag.cd_times_re import CoefficientDrag
    from autobalancer.drag.discoidal import DiscoidalDrag
    from autobalancer.drag.free_sphere import FreeSphereDrag
    from autobalancer.drag.race_geometry import AnnulusDrag
    from autobalancer.drag.sphere_on_plane import PlaneDrag
    from autobalancer.drag.table import TableDrag
    from autobalancer.drag.viscous import ViscousDrag
    from autobalancer.joints.bearing import BallBearing
    from autobalancer.joints.bushing import Bushing
    from autobalancer.joints.dashpot import Dashpot
    from autobalancer.joints.lock import Lock
    from autobalancer.joints.spring import Spring

__all__ = [
    "AnnulusDrag",
    "AsynchronousDrive",
    "AsynchronousMotor",
    "Balancer",
    "BallBearing",
    "BallInRace",
    "Balls",
    "BaseMotion",
    "Body",
    "Bushing",
    "Chamber",
    "ChamberBody",
    "ChamberMachine",
    "ChamberRotor",
    "ChamberSupport",
    "ChamberUnbalance",
    "CoefficientDrag",
    "Constant",
    "ConstantTorque",
    "Contact",
    "Coordinate",
    "Coupling",
    "Dashpot",
    "DiscoidalDrag",
    "Disk",
    "Drag",
    "Dwell",
    "Excitation",
    "Fluid",
    "Force",
    "FreeBalls",
    "FreeSphereDrag",
    "Friction",
    "FrictionLaw",
    "Hardening",
    "Harmonic",
    "HarmonicForce",
    "Hill",
    "HistoryContact",
    "Joint",
    "LiquidRing",
    "Lock",
    "Machine",
    "MatricesRotor",
    "MatrixFiles",
    "ModalRotor",
    "ModeFiles",
    "MotorMount",
    "MultibodyRotor",
    "PairForce",
    "Partitions",
    "PlanarRotor",
    "PlaneDrag",
    "PointJoint",
    "PrescribedSpeed",
    "Quantity",
    "Race",
    "Ramp",
    "RecordedBaseMotion",
    "RecordedForce",
    "Reduction",
    "ResolvedContact",
    "Resonance",
    "RestitutionContact",
    "RigidRotor",
    "Rotor",
    "Roundness",
    "Rubber",
    "RubberFriction",
    "RubberRelaxation",
    "RunPlan",
    "Schedule",
    "ShaftMaterial",
    "ShaftRotor",
    "ShaftSegment",
    "ShearLaw",
    "SpeedTable",
    "Spot",
    "Spring",
    "Start",
    "Station",
    "Support",
    "Table",
    "TableDrag",
    "TargetTorque",
    "TorqueRipple",
    "TorqueTable",
    "Unbalance",
    "ViscousDrag",
    "key",
]

FAMILIES: tuple[type[Leaf], ...] = (Drag, Force, FrictionLaw, Joint, ShearLaw)

for _leaf in (*MODELS, *(leaf for family in FAMILIES for leaf in leaves_of(family))):
    if globals().setdefault(_leaf.__name__, _leaf) is not _leaf:
        raise MachineError(
            f"{_leaf.__module__}: autobalancer.machine has another {_leaf.__name__}; give the class a new name"
        )
document(Machine)
