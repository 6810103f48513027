"""The nouns: frozen, validated descriptions in SI, and no algorithms."""

from autobalancer.machine.balancer import (
    AnnulusDrag,
    Balancer,
    Balls,
    CoefficientDrag,
    Contact,
    DiscoidalDrag,
    DragTorque,
    Fluid,
    Force,
    FreeSphereDrag,
    Friction,
    Harmonic,
    PairForce,
    Partitions,
    PlaneDrag,
    Race,
    ResolvedContact,
    Roundness,
    TableDrag,
)
from autobalancer.machine.chamber import (
    AsynchronousMotor,
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
from autobalancer.machine.drive import ConstantTorque, PrescribedSpeed, TargetTorque, TorqueTable
from autobalancer.machine.excitation import BaseMotion, Excitation, HarmonicForce, RecordedBaseMotion, RecordedForce
from autobalancer.machine.keys import document
from autobalancer.machine.machine import Machine, RunPlan, Start
from autobalancer.machine.profile import Constant, Dwell, Hill, Ramp, Reduction, Table
from autobalancer.machine.rotors import Rotor
from autobalancer.machine.rotors.body import Body
from autobalancer.machine.rotors.disk import Disk
from autobalancer.machine.rotors.joints import BallBearing, Bushing, Dashpot, Lock, Spring
from autobalancer.machine.rotors.multibody import MultibodyRotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.rotors.segment import ShaftMaterial, ShaftSegment
from autobalancer.machine.rotors.shaft import ShaftRotor
from autobalancer.machine.rotors.support import SpeedTable, Support
from autobalancer.machine.station import Station
from autobalancer.machine.unbalance import Schedule, Unbalance

__all__ = [
    "AnnulusDrag",
    "AsynchronousMotor",
    "Balancer",
    "BallBearing",
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
    "Dashpot",
    "DiscoidalDrag",
    "Disk",
    "DragTorque",
    "Dwell",
    "Excitation",
    "Fluid",
    "Force",
    "FreeBalls",
    "FreeSphereDrag",
    "Friction",
    "Harmonic",
    "HarmonicForce",
    "Hill",
    "HistoryContact",
    "Lock",
    "Machine",
    "MultibodyRotor",
    "PairForce",
    "Partitions",
    "PlanarRotor",
    "PlaneDrag",
    "PrescribedSpeed",
    "Race",
    "Ramp",
    "RecordedBaseMotion",
    "RecordedForce",
    "Reduction",
    "ResolvedContact",
    "RestitutionContact",
    "RigidRotor",
    "Rotor",
    "Roundness",
    "RunPlan",
    "Schedule",
    "ShaftMaterial",
    "ShaftRotor",
    "ShaftSegment",
    "SpeedTable",
    "Spring",
    "Start",
    "Station",
    "Support",
    "Table",
    "TableDrag",
    "TargetTorque",
    "TorqueTable",
    "Unbalance",
]

document(Machine)
