"""The nouns: frozen, validated descriptions in SI, and no algorithms.

Leaves, such as drag laws, have a file each outside of this package; their classes are found here, and so are rotor models.
"""

from typing import TYPE_CHECKING

from autobalancer.errors import MachineError
from autobalancer.machine.balancer.fluid import BallInRace as BallInRace
from autobalancer.machine.balancer.fluid import Drag as Drag
from autobalancer.machine.balancer.fluid import Fluid as Fluid
from autobalancer.machine.balancer.fluid import ShearLaw as ShearLaw
from autobalancer.machine.balancer.force import Force as Force
from autobalancer.machine.balancer.force import PairForce as PairForce
from autobalancer.machine.balancer.race import Balancer as Balancer
from autobalancer.machine.balancer.race import Balls as Balls
from autobalancer.machine.balancer.race import Race as Race
from autobalancer.machine.balancer.resolved import Contact as Contact
from autobalancer.machine.balancer.resolved import Friction as Friction
from autobalancer.machine.balancer.resolved import FrictionLaw as FrictionLaw
from autobalancer.machine.balancer.resolved import Harmonic as Harmonic
from autobalancer.machine.balancer.resolved import Partitions as Partitions
from autobalancer.machine.balancer.resolved import ResolvedContact as ResolvedContact
from autobalancer.machine.balancer.resolved import Roundness as Roundness
from autobalancer.machine.chamber import Chamber as Chamber
from autobalancer.machine.chamber import ChamberBody as ChamberBody
from autobalancer.machine.chamber import ChamberMachine as ChamberMachine
from autobalancer.machine.chamber import ChamberRotor as ChamberRotor
from autobalancer.machine.chamber import ChamberSupport as ChamberSupport
from autobalancer.machine.chamber import ChamberUnbalance as ChamberUnbalance
from autobalancer.machine.chamber import FreeBalls as FreeBalls
from autobalancer.machine.chamber import HistoryContact as HistoryContact
from autobalancer.machine.chamber import RestitutionContact as RestitutionContact
from autobalancer.machine.drive import AsynchronousDrive as AsynchronousDrive
from autobalancer.machine.drive import AsynchronousMotor as AsynchronousMotor
from autobalancer.machine.drive import Constant as Constant
from autobalancer.machine.drive import ConstantTorque as ConstantTorque
from autobalancer.machine.drive import Coupling as Coupling
from autobalancer.machine.drive import Dwell as Dwell
from autobalancer.machine.drive import Hill as Hill
from autobalancer.machine.drive import MotorMount as MotorMount
from autobalancer.machine.drive import PrescribedSpeed as PrescribedSpeed
from autobalancer.machine.drive import Ramp as Ramp
from autobalancer.machine.drive import Reduction as Reduction
from autobalancer.machine.drive import Table as Table
from autobalancer.machine.drive import TargetTorque as TargetTorque
from autobalancer.machine.drive import TorqueRipple as TorqueRipple
from autobalancer.machine.drive import TorqueTable as TorqueTable
from autobalancer.machine.keys import document
from autobalancer.machine.machine import BaseMotion as BaseMotion
from autobalancer.machine.machine import Excitation as Excitation
from autobalancer.machine.machine import HarmonicForce as HarmonicForce
from autobalancer.machine.machine import LiquidRing as LiquidRing
from autobalancer.machine.machine import Machine as Machine
from autobalancer.machine.machine import RecordedBaseMotion as RecordedBaseMotion
from autobalancer.machine.machine import RecordedForce as RecordedForce
from autobalancer.machine.machine import RunPlan as RunPlan
from autobalancer.machine.machine import Schedule as Schedule
from autobalancer.machine.machine import Start as Start
from autobalancer.machine.machine import Unbalance as Unbalance
from autobalancer.machine.part import Quantity as Quantity
from autobalancer.machine.part import key as key
from autobalancer.machine.plugins import Leaf, leaves_of
from autobalancer.machine.rotors import MODELS
from autobalancer.machine.rotors import Rotor as Rotor
from autobalancer.machine.rotors.body import Body as Body
from autobalancer.machine.rotors.body import Station as Station
from autobalancer.machine.rotors.joint import Joint as Joint
from autobalancer.machine.rotors.joint import PointJoint as PointJoint
from autobalancer.machine.rotors.joint import Spot as Spot
from autobalancer.machine.rotors.modal import Coordinate as Coordinate
from autobalancer.machine.rotors.modal import MatricesRotor as MatricesRotor
from autobalancer.machine.rotors.modal import MatrixFiles as MatrixFiles
from autobalancer.machine.rotors.modal import ModalRotor as ModalRotor
from autobalancer.machine.rotors.modal import ModeFiles as ModeFiles
from autobalancer.machine.rotors.modal import Resonance as Resonance
from autobalancer.machine.rotors.multibody import MultibodyRotor as MultibodyRotor
from autobalancer.machine.rotors.planar import PlanarRotor as PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor as RigidRotor
from autobalancer.machine.rotors.shaft import Disk as Disk
from autobalancer.machine.rotors.shaft import ShaftMaterial as ShaftMaterial
from autobalancer.machine.rotors.shaft import ShaftRotor as ShaftRotor
from autobalancer.machine.rotors.shaft import ShaftSegment as ShaftSegment
from autobalancer.machine.rotors.support import Hardening as Hardening
from autobalancer.machine.rotors.support import Rubber as Rubber
from autobalancer.machine.rotors.support import RubberFriction as RubberFriction
from autobalancer.machine.rotors.support import RubberRelaxation as RubberRelaxation
from autobalancer.machine.rotors.support import SpeedTable as SpeedTable
from autobalancer.machine.rotors.support import Support as Support

if TYPE_CHECKING:
    from autobalancer.drag.cd_times_re import CoefficientDrag as CoefficientDrag
    from autobalancer.drag.discoidal import DiscoidalDrag as DiscoidalDrag
    from autobalancer.drag.free_sphere import FreeSphereDrag as FreeSphereDrag
    from autobalancer.drag.race_geometry import AnnulusDrag as AnnulusDrag
    from autobalancer.drag.sphere_on_plane import PlaneDrag as PlaneDrag
    from autobalancer.drag.table import TableDrag as TableDrag
    from autobalancer.drag.viscous import ViscousDrag as ViscousDrag
    from autobalancer.joints.bearing import BallBearing as BallBearing
    from autobalancer.joints.bushing import Bushing as Bushing
    from autobalancer.joints.dashpot import Dashpot as Dashpot
    from autobalancer.joints.lock import Lock as Lock
    from autobalancer.joints.spring import Spring as Spring

FAMILIES: tuple[type[Leaf], ...] = (Drag, Force, FrictionLaw, Joint, ShearLaw)

for _leaf in (*MODELS, *(leaf for family in FAMILIES for leaf in leaves_of(family))):
    if globals().setdefault(_leaf.__name__, _leaf) is not _leaf:
        raise MachineError(
            f"{_leaf.__module__}: autobalancer.machine has another {_leaf.__name__}; give the class a new name"
        )
document(Machine)
