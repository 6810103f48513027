"""What carries a rotor: springs and dampers between it and the ground, constant or tabled over the speed."""

from __future__ import annotations

from bisect import bisect_right
from typing import Annotated

from pydantic import model_validator

from autobalancer.machine.part import Listed, Part, key
from autobalancer.machine.quantity import Damping, Position, Quantity, Speed, Stiffness
from autobalancer.machine.rotors.hardening import Hardening
from autobalancer.machine.rotors.rubber import Rubber

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
