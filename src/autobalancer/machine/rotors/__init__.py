"""Rotor models: what carries the balancers; a subclass of :class:`RotorModel` in a file of this folder is one."""

from __future__ import annotations

from functools import reduce
from importlib import import_module
from operator import or_
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field

from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.modal import MatricesRotor, ModalRotor
from autobalancer.machine.rotors.multibody import MultibodyRotor
from autobalancer.machine.rotors.planar import PlanarRotor
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.machine.rotors.shaft import ShaftRotor

for _file in iter_modules(__path__):
    import_module(f"{__name__}.{_file.name}")
_FIRST: tuple[type[RotorModel], ...] = (PlanarRotor, RigidRotor, ShaftRotor, MultibodyRotor, ModalRotor, MatricesRotor)
MODELS = tuple(dict.fromkeys([*_FIRST, *RotorModel.__subclasses__()]))


def _planar_by_default(value: Any) -> Any:
    return {"kind": "planar", **value} if isinstance(value, dict) else value


if TYPE_CHECKING:
    Rotor = PlanarRotor | RigidRotor | ShaftRotor | MultibodyRotor | ModalRotor | MatricesRotor
else:
    Rotor = Annotated[Annotated[reduce(or_, MODELS), Field(discriminator="kind")], BeforeValidator(_planar_by_default)]
