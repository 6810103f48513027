"""Machines whose balls move freely in deep chambers."""

from autobalancer.machine.chamber.body import ChamberBody, ChamberRotor, ChamberSupport, ChamberUnbalance
from autobalancer.machine.chamber.chamber import Chamber, FreeBalls
from autobalancer.machine.chamber.contact import HistoryContact, RestitutionContact
from autobalancer.machine.chamber.machine import ChamberMachine
from autobalancer.machine.keys import document

__all__ = [
    "Chamber",
    "ChamberBody",
    "ChamberMachine",
    "ChamberRotor",
    "ChamberSupport",
    "ChamberUnbalance",
    "FreeBalls",
    "HistoryContact",
    "RestitutionContact",
]

document(ChamberMachine)
