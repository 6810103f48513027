"""What carries a rotor: springs and dampers between it and the ground, constant or tabled over the speed."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import (
    Damping,
    Duration,
    Length,
    Listed,
    Offset,
    Part,
    Position,
    Quantity,
    Speed,
    SpringRate,
    Stiffness,
    key,
)

# A bearing that becomes stiffer as it deflects: a cubic spring, a clearance with a stop behind it, or a law of your
# own.


CubicStiffness = Annotated[float, Quantity("N/m^3", non_negative=True)]
Offsets = Annotated[tuple[Offset, ...], Listed]
Forces = Annotated[tuple[Annotated[float, Quantity("N", non_negative=True)], ...], Listed]


class Hardening(Part):
    """A central force beside the linear spring of a bearing, for runs.

    At the distance r from the middle of the bearing ``cubic_stiffness`` pulls with k r³ towards it; a stop with
    ``contact_stiffness`` k does so with k (r - ``clearance``) where r exceeds the clearance. ``force`` over ``distance``
    is any other law, measured or computed; between its points it is a monotone cubic. It has no loss of its own.
    Theories of small motions take the stiffness that it has where the rotor rests, and say so.
    """

    cubic_stiffness: CubicStiffness = key("force over the third power of the distance", 0.0)
    clearance: Offset | None = key("free way in every direction, before the stop is reached", None)
    contact_stiffness: SpringRate | None = key("of the stop; needed with a `clearance`", None)
    distance: Offsets | None = key("from the middle, of a law of your own; must increase", None)
    force: Forces | None = key("towards the middle at each `distance`; must not fall", None)
    center: tuple[Position, Position] = key(
        "x and y of the middle of the bearing, from where the rotor rests", (0.0, 0.0)
    )

    @model_validator(mode="after")
    def _there(self) -> Hardening:
        if (self.clearance is None) != (self.contact_stiffness is None):
            lacking = "clearance" if self.clearance is None else "contact_stiffness"
            raise ValueError(f"{lacking}: missing; a stop needs 'clearance' and 'contact_stiffness'")
        if self.distance is None and self.force is None and self.clearance is None and self.cubic_stiffness == 0.0:
            others = "a 'clearance' with its 'contact_stiffness', or a 'force' over 'distance'"
            raise ValueError(f"cubic_stiffness: missing; give it, {others}")
        self._refuse_odd_table()
        return self

    def _refuse_odd_table(self) -> None:
        if (self.distance is None) != (self.force is None):
            lacking = "distance" if self.distance is None else "force"
            raise ValueError(f"{lacking}: missing; a law of your own needs 'distance' and 'force'")
        if self.distance is None or self.force is None:
            return
        if len(self.distance) != len(self.force):
            raise ValueError(
                f"force: given {len(self.force)} values for {len(self.distance)} distances; give one for each"
            )
        if len(self.force) < 2:
            raise ValueError("distance: give at least two; for one stiffness use that of the spring beside it")
        for name, values, equal in (("distance", self.distance, False), ("force", self.force, True)):
            for number, (one, other) in enumerate(pairwise(values), 2):
                if other < one or (other == one and not equal):
                    must = "must not fall" if equal else "must increase"
                    raise ValueError(f"{name}: entry {number} is {other:.6g} after {one:.6g}; the values {must}")
        if self.distance[0] == 0.0 and self.force[0] != 0.0:
            raise ValueError(f"force: given {self.force[0]:.6g} N at distance 0; it must be 0 there")


# Rubber whose stiffness falls with the amplitude (Payne effect): an elastic, a viscous, a relaxing and a sliding part.


DamperRate = Annotated[float, Quantity("N*s/m", non_negative=True)]
Lengths = Annotated[tuple[Length, ...], Field(min_length=1), Listed]
SpringRates = Annotated[tuple[SpringRate, ...], Field(min_length=1), Listed]
Durations = Annotated[tuple[Duration, ...], Field(min_length=1), Listed]

RATIO = 1.1  # of two frequencies of the table that stands for Maxwell elements
REACH = 1e-2, 1e5  # and from where to where it goes, times the relaxation time
FASTEST = 1e9  # rad/s, its last frequency


class RubberFriction(Part):
    """Springs that slide (Iwan 1966; Dahl 1968): several side by side make rubber softer, the farther it moves.

    Each carries a force f that follows the deflection z with its ``stiffness`` k and grows no further than
    F = k times its ``breakaway_amplitude``. In the plane z and f are vectors. ``elastoplastic`` means f' = k (z' - f <f z'>/F²),
    where <x> is x above zero and zero below; ``endochronic`` means f' = k (z' - f \\|z'\\|/F), which slides a little always.
    """

    law: Literal["elastoplastic", "endochronic"] = key("how an element begins to slide", "elastoplastic")
    breakaway_amplitude: Lengths = key("of each element: deflection at which it slides; must increase", symbol="a_c")
    stiffness: SpringRates = key("of each element while it sticks; as many as amplitudes", symbol="k")

    @model_validator(mode="after")
    def _chain(self) -> RubberFriction:
        _refuse_wrong_count(len(self.stiffness), len(self.breakaway_amplitude), "amplitudes")
        _rising("breakaway_amplitude", self.breakaway_amplitude)
        return self


class RubberRelaxation(Part):
    """Maxwell elements, each a spring in series with a damper: they stiffen rubber at high frequency."""

    relaxation_time: Durations = key("of each element: damper over spring; must increase", symbol=r"\tau")
    stiffness: SpringRates = key("of the spring of each element; as many as relaxation times", symbol="k")

    @model_validator(mode="after")
    def _chain(self) -> RubberRelaxation:
        _refuse_wrong_count(len(self.stiffness), len(self.relaxation_time), "relaxation times")
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
        frequencies: set[float] = set()
        for tau in self.maxwell.relaxation_time if self.maxwell else ():
            one = REACH[0] / tau
            while one < REACH[1] / tau:
                frequencies.add(one)
                one *= RATIO
        return (
            (0.0, *sorted(frequency for frequency in frequencies if frequency < FASTEST), FASTEST)
            if frequencies
            else ()
        )


def _refuse_wrong_count(argument: int, wanted: int, of: str) -> None:
    if argument != wanted:
        raise ValueError(f"stiffness: given {argument} values for {wanted} {of}; give one for each")


def _rising(name: str, values: tuple[float, ...]) -> None:
    wrong = next((i for i, (one, other) in enumerate(pairwise(values), 2) if other <= one), None)
    if wrong is not None:
        raise ValueError(
            f"{name}: entry {wrong} is {values[wrong - 1]:.6g} after {values[wrong - 2]:.6g}; the values must increase"
        )


SignedStiffness = Annotated[float, Quantity("N/m")]
TiltStiffness = Annotated[float, Quantity("N*m/rad", non_negative=True)]
TiltDamping = Annotated[float, Quantity("N*m*s/rad", non_negative=True)]


def along_x_and_y(value: float | tuple[float, float]) -> tuple[float, float]:
    """Both values, equal where one is given."""
    return (float(value[0]), float(value[1])) if isinstance(value, tuple) else (float(value), float(value))


class SpeedTable(Part):
    """Stiffness and damping over the frequency of the load, which is the speed of the rotor; linear in between.

    The table must cover the speeds at which it is used. An entry may be a pair along x and y.
    """

    speed: Annotated[tuple[Speed, ...], Listed] = key(
        "of the rotor, which is the frequency of its unbalance; must increase and cover all speeds that are used"
    )
    stiffness: Annotated[tuple[Stiffness, ...], Listed] = key("as many as speeds, linear in between")
    damping: Annotated[tuple[Damping, ...], Listed] = key("as many as speeds, linear in between")

    @model_validator(mode="after")
    def _consistent(self) -> SpeedTable:
        if len(self.speed) < 2:
            raise ValueError("speed: give at least two speeds; for one value use 'stiffness' and 'damping' directly")
        for name in ("stiffness", "damping"):
            if len(getattr(self, name)) != len(self.speed):
                raise ValueError(
                    f"{name}: given {len(getattr(self, name))} values for {len(self.speed)} speeds; give one for each"
                )
        if self.speed[0] < 0.0 or any(b <= a for a, b in zip(self.speed, self.speed[1:], strict=False)):
            raise ValueError("speed: must not be negative and must increase")
        return self

    def at(self, speed: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Stiffness and damping along x and y at a speed (rad/s); those of the ends beyond them."""
        i = min(max(bisect_right(self.speed, speed) - 1, 0), len(self.speed) - 2)
        share = min(max((speed - self.speed[i]) / (self.speed[i + 1] - self.speed[i]), 0.0), 1.0)
        return _between(self.stiffness[i : i + 2], share), _between(self.damping[i : i + 2], share)


def values_at(
    table: SpeedTable | None,
    stiffness: float | tuple[float, float] | None,
    damping: float | tuple[float, float],
    speed: float,
    rubber: Rubber | None = None,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Stiffness and damping along x and y at a speed, of a table, of rubber in small motions, or of the constants."""
    if rubber is not None:
        k, c = rubber.small_motions(speed)
        return (k, k), (c, c)
    if table is not None:
        return table.at(speed)
    return along_x_and_y(0.0 if stiffness is None else stiffness), along_x_and_y(damping)


def only_rubber(others: dict[str, object]) -> None:
    """Refuse what is given beside rubber, by name."""
    for name, value in others.items():
        if value:
            raise ValueError(f"{name}: given beside 'rubber', which contains it; give one or the other")


def _between(values: tuple[float | tuple[float, float], ...], share: float) -> tuple[float, float]:
    low, high = (along_x_and_y(value) for value in values)
    return low[0] + share * (high[0] - low[0]), low[1] + share * (high[1] - low[1])


class Support(Part):
    """A bearing or spring between the rotor at ``position`` and the ground.

    ``stiffness`` and ``damping`` across the axis, one value or a pair along x and y; or a ``table`` over the speed; or
    ``rubber`` that softens with the amplitude.
    ``cross_stiffness`` (k_xy, k_yx) is that of a fluid film; it may have any sign.
    """

    position: Position = key("along the axis, counted as for stations")
    stiffness: Stiffness | None = key(
        "across the axis; this, a `table` or `rubber`, or none of them for a pure damper", None, symbol="k"
    )
    damping: Damping = key("across the axis; not with a `table`, which contains it", 0.0, symbol="b")
    table: SpeedTable | None = key("stiffness and damping over the speed, in place of two constants", None)
    rubber: Rubber | None = key("that softens with the amplitude, in place of two constants", None)
    cross_stiffness: tuple[SignedStiffness, SignedStiffness] | None = key(
        "$k_{xy}$ and $k_{yx}$ of a fluid film, of any sign", None
    )
    hardening: Hardening | None = key("a force beside the spring that grows faster than the deflection", None)
    tilt_stiffness: TiltStiffness = key("against the slope of the axis", 0.0)
    tilt_damping: TiltDamping = key("against the rate of the slope", 0.0)

    @model_validator(mode="after")
    def _one_way(self) -> Support:
        if self.stiffness is not None and self.table is not None:
            raise ValueError("give either 'stiffness' (and 'damping') or a 'table' over the speed, not both")
        if self.rubber is not None:
            only_rubber({name: getattr(self, name) for name in ("stiffness", "damping", "table", "cross_stiffness")})
        if self.hardening is not None and not self.carries:
            raise ValueError("hardening: it stands beside a spring; give a 'stiffness', a 'table' or 'rubber' too")
        nothing = self.tilt_stiffness == 0.0 and self.tilt_damping == 0.0 and self.damping == 0.0
        if not self.carries and nothing:
            raise ValueError("stiffness: missing; give it, a 'table' or 'rubber', or make it a damper by 'damping'")
        if self.table is not None and self.damping != 0.0:
            raise ValueError("damping: the table contains it already; leave it out")
        return self

    @property
    def carries(self) -> bool:
        """Whether it has a spring across the axis."""
        return self.stiffness is not None or self.table is not None or self.rubber is not None

    def values(self, speed: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Stiffness and damping along x and y at a speed, rad/s; of rubber those of small motions."""
        return values_at(self.table, self.stiffness, self.damping, speed, self.rubber)

    def frequencies(self) -> tuple[float, ...]:
        """Between which its values are linear, rad/s; empty if they are constant."""
        if self.rubber is not None:
            return self.rubber.frequencies()
        return () if self.table is None else tuple(map(float, self.table.speed))
