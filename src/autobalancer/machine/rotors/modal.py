"""A rotor of which only the modes at the plane of its races are known, as a hammer test gives them."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from autobalancer.machine.part import Inertia, Listed, Mass, Part, Quantity, key
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.support import Support


class Resonance(Part):
    """One mode: it moves the plane as a mass on a spring and a damper would on which the same force acts."""

    mass: Mass = key("modal mass at the plane, without balls: the mode has deflection one there", symbol="m_k")
    frequency: Annotated[float, Quantity("rad/s", positive=True)] = key("undamped natural frequency", symbol="w_k")
    damping_ratio: Annotated[float, Quantity("", non_negative=True)] = key(
        "over critical damping, such as `2 %`", symbol="D_k"
    )


class ModalRotor(RotorModel):
    r"""Modes at the one plane in which unbalance and balls are, alike in all directions.

    The receptance there is $\sum_k 1 / (m_k (\sigma^2 + 2 D_k w_k \sigma + w_k^2))$: each mode is damped by itself, and
    gyroscopic moments do not change them. ``inertia`` (about the shaft, without balls) is needed only where a torque drives.
    """

    kind: Literal["modal"] = "modal"
    one_plane: ClassVar[bool] = True
    resonances: Annotated[tuple[Resonance, ...], Field(min_length=1), Listed] = key("of the rotor on its supports")
    inertia: Inertia | None = key(
        "polar, about the shaft, without balls; required where a torque drives", None, symbol="J_p"
    )

    @property
    def mass(self) -> float:
        """What a fast force at the plane feels, kg."""
        return 1.0 / sum(1.0 / float(mode.mass) for mode in self.resonances)

    @property
    def supports(self) -> tuple[Support, ...]:
        """Not known one by one: they are in the modes."""
        return ()

    @property
    def stiffness_proportional_damping(self) -> float:
        """None beside that of the modes."""
        return 0.0
