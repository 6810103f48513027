"""The planar rotor: a mass that moves in its plane on springs and dampers (Spannan 2021, section 4.1)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import model_validator

from autobalancer.errors import MachineError, Problem, UnitError
from autobalancer.machine.part import Damping, Inertia, Mass, Quantity, Stiffness, key
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.support import Hardening, Rubber
from autobalancer.units import WrittenFloat, to_si

SPRINGS = ("stiffness", "critical_speed")
DAMPERS = ("damping", "damping_ratio", "half_power_bandwidth")


class BandwidthQuantity(Quantity):
    """A bandwidth over the critical speed, or as a speed."""

    def one(self, value: Any) -> Any:
        """The ratio, or the speed in rad/s."""
        text = value.text if isinstance(value, WrittenFloat) else value
        width = to_si(value, "rad/s" if isinstance(text, str) and _is_speed(text) else "")
        if not width >= 0.0:
            raise ValueError(f"given {value!r}; must not be negative")
        return width

    @property
    def words(self) -> str:
        """What may be given."""
        return "number or rad/s, ≥ 0"


def _is_speed(text: str) -> bool:
    try:
        to_si(text, "rad/s")
    except UnitError:
        return False
    return True


CriticalSpeed = Annotated[float | tuple[float, float], Quantity("rad/s", positive=True, shape="one or a pair")]
DampingRatio = Annotated[float | tuple[float, float], Quantity("", non_negative=True, shape="one or a pair")]
Bandwidth = Annotated[float, BandwidthQuantity("", non_negative=True)]


class PlanarRotor(RotorModel):
    """A rotor with two lateral degrees of freedom, isotropic or orthotropic.

    ``mass`` is without balls but with everything that is screwed to the rotor. A pair of values is along x and y.
    ``inertia`` (about the shaft, without balls) is needed only where a torque drives.

    In place of ``stiffness`` there may be the ``critical_speed``, undamped and with the balls on the rotor, and in place of
    ``damping`` the ``damping_ratio`` or the ``half_power_bandwidth`` of the resonance, relative or as a speed. The springs that
    follow stay when something else of the machine is changed. ``rubber`` that softens with the amplitude stands in place of all
    of these.
    """

    kind: Literal["planar"] = "planar"
    mass: Mass = key("without balls, with all attached parts, and races full of fluid", symbol="M")
    stiffness: Stiffness | None = key("of all supports together; this or `critical_speed`", None, symbol="k")
    critical_speed: CriticalSpeed | None = key(
        r"$w_c = \sqrt{k/M}$ without damping, with the balls on the rotor", None, symbol="w_c"
    )
    damping: Damping | None = key(
        "of all supports together; this, `damping_ratio` or `half_power_bandwidth`", None, symbol="b"
    )
    damping_ratio: DampingRatio | None = key(r"$D = b / (2 \sqrt{k M})$, such as `2 %`", None, symbol="D")
    half_power_bandwidth: Bandwidth | None = key(
        r"width of the resonance at $1/\sqrt{2}$ of its height, over the critical speed (`4 %`) or as a speed (`24 "
        r"rpm`): $2 D$ for light damping",
        None,
    )
    rubber: Rubber | None = key("that softens with the amplitude, in place of springs and dampers", None)
    hardening: Hardening | None = key("a force beside the springs that grows faster than the deflection", None)
    inertia: Inertia | None = key(
        "polar, about the shaft, without balls; required where a torque drives", None, symbol="J_p"
    )

    @model_validator(mode="after")
    def _one_way(self) -> PlanarRotor:
        problems: list[Problem] = []
        if self.rubber is not None:
            beside = [name for name in (*SPRINGS, *DAMPERS) if getattr(self, name) is not None]
            if beside:
                text = "given beside 'rubber', which contains it; give one or the other"
                raise MachineError.of("PlanarRotor", [((name,), text) for name in beside])
            return self
        for keys in (SPRINGS, DAMPERS):
            given = [key for key in keys if getattr(self, key) is not None]
            if not given:
                others = " or ".join(repr(key) for key in keys[1:])
                problems.append(((keys[0],), f"missing; it has no default, give it or {others}, or 'rubber'"))
            problems += [((key,), f"given beside {given[0]!r}; give one of them") for key in given[1:]]
        if problems:
            raise MachineError.of("PlanarRotor", problems)
        return self

    @property
    def one_plane(self) -> bool:
        """All of it is in one plane."""
        return True

    @property
    def settled(self) -> bool:
        """Whether stiffness and damping are given themselves."""
        return self.stiffness is not None and self.damping is not None

    @property
    def stiffness_xy(self) -> tuple[float, float]:
        """Stiffness along x and y, N/m, where it is given."""
        return _pair(self._given("stiffness"))

    @property
    def damping_xy(self) -> tuple[float, float]:
        """Damping along x and y, N s/m, where it is given."""
        return _pair(self._given("damping"))

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        pairs = [_pair(value) for key in (*SPRINGS, *DAMPERS) if (value := getattr(self, key)) is not None]
        return all(x == y for x, y in pairs)

    def springs(self, total_mass: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """Stiffness (N/m) and damping (N s/m) along x and y, with the mass in motion, kg.

        Those of rubber are those of small motions at their natural frequency.
        """
        if self.rubber is not None:
            values = _small_free_motions(self.rubber, total_mass)
            return (values[0], values[0]), (values[1], values[1])
        if self.critical_speed is None:
            k = self.stiffness_xy
        else:
            wx, wy = _pair(self.critical_speed)
            k = (total_mass * wx**2, total_mass * wy**2)
        if self.damping is not None:
            return k, self.damping_xy
        ratios = self._ratios((k[0] / total_mass) ** 0.5, (k[1] / total_mass) ** 0.5)
        bx, by = (2.0 * ratio * (one * total_mass) ** 0.5 for ratio, one in zip(ratios, k, strict=True))
        return k, (bx, by)

    def _ratios(self, wx: float, wy: float) -> tuple[float, float]:
        if self.damping_ratio is not None:
            return _pair(self.damping_ratio)
        width = self.half_power_bandwidth
        assert width is not None
        if isinstance(width, WrittenFloat) and _is_speed(width.text):
            return 0.5 * width / wx, 0.5 * width / wy
        return 0.5 * width, 0.5 * width

    def _given(self, key: str) -> float | tuple[float, float]:
        value: float | tuple[float, float] | None = getattr(self, key)
        if value is None:
            raise MachineError(f"rotor.{key}: follows from the mass in motion; ask planar_rotor(machine) for it")
        return value


def _small_free_motions(rubber: Rubber, mass: float) -> tuple[float, float]:
    """Stiffness (N/m) and damping (N s/m) of small motions of a mass (kg) on rubber, at the frequency that belongs to them."""
    stiffness, before = rubber.initial_stiffness, 0.0
    while stiffness > before * (1.0 + 1e-13):  # stiffens with the frequency, so this rises to the lowest one
        before, stiffness = stiffness, rubber.small_motions((stiffness / mass) ** 0.5)[0]
    return rubber.small_motions((stiffness / mass) ** 0.5)


def _pair(value: float | tuple[float, float]) -> tuple[float, float]:
    return (float(value[0]), float(value[1])) if isinstance(value, tuple) else (float(value), float(value))
