"""Rubber whose stiffness falls with the amplitude (Payne effect): an elastic, a viscous, a relaxing and a sliding part."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Duration, Length, Quantity, SpringRate

DamperRate = Annotated[float, Quantity("N*s/m", non_negative=True)]
Lengths = Annotated[tuple[Length, ...], Field(min_length=1), Listed]
SpringRates = Annotated[tuple[SpringRate, ...], Field(min_length=1), Listed]
Durations = Annotated[tuple[Duration, ...], Field(min_length=1), Listed]

RATIO = 1.1  # of two frequencies of the table that stands for Maxwell elements
REACH = 1e-2, 1e5  # and from where to where it goes, times the relaxation time
FASTEST = 1e9  # rad/s, its last frequency


class RubberFriction(Part):
    """Springs that slide: several side by side make rubber softer, the farther it moves.

    Each carries a force f that follows the deflection z with its ``stiffness`` k and grows no further than
    F = k times its ``breakaway_amplitude``. In the plane z and f are vectors. ``elastoplastic`` means f' = k (z' - f <f z'>/F²),
    where <x> is x above zero and zero below; ``endochronic`` means f' = k (z' - f \\|z'\\|/F), which slides a little always.
    """

    law: Literal["elastoplastic", "endochronic"] = key("how an element begins to slide", "elastoplastic")
    breakaway_amplitude: Lengths = key("of each element: deflection at which it slides; must increase", symbol="a_c")
    stiffness: SpringRates = key("of each element while it sticks; as many as amplitudes", symbol="k")

    @model_validator(mode="after")
    def _chain(self) -> RubberFriction:
        _as_many(len(self.stiffness), len(self.breakaway_amplitude), "amplitudes")
        _rising("breakaway_amplitude", self.breakaway_amplitude)
        return self


class RubberRelaxation(Part):
    """Maxwell elements, each a spring in series with a damper: they stiffen rubber at high frequency."""

    relaxation_time: Durations = key("of each element: damper over spring; must increase", symbol=r"\tau")
    stiffness: SpringRates = key("of the spring of each element; as many as relaxation times", symbol="k")

    @model_validator(mode="after")
    def _chain(self) -> RubberRelaxation:
        _as_many(len(self.stiffness), len(self.relaxation_time), "relaxation times")
        _rising("relaxation_time", self.relaxation_time)
        return self


class Rubber(Part):
    """Rubber that softens with the amplitude, in place of a spring and a damper.

    ``stiffness`` and ``damping`` are those of large motions, when all ``friction`` elements slide. In small motions all of
    them stick and add their stiffness. ``maxwell`` elements add some that depends on the frequency. All directions are alike.
    A run integrates every element; theories of small motions take the stiffness of small motions, and say so.
    """

    stiffness: SpringRate = key("of large motions, when all friction elements slide", symbol=r"k_\infty")
    damping: DamperRate = key("viscous, beside the loss by friction", 0.0, symbol="c")
    friction: RubberFriction | None = key("elements that slide one after the other as the amplitude grows", None)
    maxwell: RubberRelaxation | None = key("elements that relax", None)

    @model_validator(mode="after")
    def _more_than_a_spring(self) -> Rubber:
        if self.friction is None and self.maxwell is None:
            raise ValueError(
                "friction: missing; give it or 'maxwell', or a plain stiffness and damping in place of rubber"
            )
        return self

    @property
    def initial_stiffness(self) -> float:
        """Of small, slow motions, N/m: all friction elements stick, all Maxwell elements have relaxed."""
        return float(self.stiffness) + sum(self.friction.stiffness if self.friction else ())

    @property
    def largest_amplitude(self) -> float:
        """The greatest breakaway amplitude, m, beyond which the loss force no longer grows; 0 without friction elements."""
        return float(self.friction.breakaway_amplitude[-1]) if self.friction else 0.0

    def small_motions(self, frequency: float) -> tuple[float, float]:
        """Stiffness (N/m) and damping (N s/m) in small motions at an angular frequency, rad/s."""
        stiffness, damping = self.initial_stiffness, float(self.damping)
        if self.maxwell is not None:
            for k, tau in zip(self.maxwell.stiffness, self.maxwell.relaxation_time, strict=True):
                share = 1.0 / (1.0 + (frequency * tau) ** 2)
                stiffness, damping = stiffness + k * (1.0 - share), damping + k * tau * share
        return stiffness, damping

    def frequencies(self) -> tuple[float, ...]:
        """Angular frequencies between which :meth:`small_motions` is linear within a hundredth; empty if it is constant."""
        found: set[float] = set()
        for tau in self.maxwell.relaxation_time if self.maxwell else ():
            one = REACH[0] / tau
            while one < REACH[1] / tau:
                found.add(one)
                one *= RATIO
        return (0.0, *sorted(one for one in found if one < FASTEST), FASTEST) if found else ()


def small_free_motions(rubber: Rubber, mass: float) -> tuple[float, float]:
    """Stiffness (N/m) and damping (N s/m) of small motions of a mass (kg) on rubber, at the frequency that belongs to them."""
    stiffness, before = rubber.initial_stiffness, 0.0
    while stiffness > before * (1.0 + 1e-13):  # stiffens with the frequency, so this rises to the lowest one
        before, stiffness = stiffness, rubber.small_motions((stiffness / mass) ** 0.5)[0]
    return rubber.small_motions((stiffness / mass) ** 0.5)


def _as_many(given: int, wanted: int, of: str) -> None:
    if given != wanted:
        raise ValueError(f"stiffness: given {given} values for {wanted} {of}; give one for each")


def _rising(name: str, values: tuple[float, ...]) -> None:
    wrong = next((i for i, (one, other) in enumerate(pairwise(values), 2) if other <= one), None)
    if wrong is not None:
        raise ValueError(
            f"{name}: entry {wrong} is {values[wrong - 1]:.6g} after {values[wrong - 2]:.6g}; the values must increase"
        )
