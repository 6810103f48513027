"""Rotor models: what carries the balancers."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from autobalancer.machine.rotors.modal import ModalRotor
from autobalancer.machine.rotors.multibody import MultibodyRotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.rotors.shaft import ShaftRotor


def _planar_by_default(value: Any) -> Any:
    return {"kind": "planar", **value} if isinstance(value, dict) else value


Rotor = Annotated[
    Annotated[PlanarRotor | RigidRotor | ShaftRotor | MultibodyRotor | ModalRotor, Field(discriminator="kind")],
    BeforeValidator(_planar_by_default),
]
