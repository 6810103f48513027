"""Rings partly filled with liquid on a rotor: steady response and small motions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.catalog.resolve import planar_rotor, rings_of
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import balls_in_races, machine_text
from autobalancer.laws.ring_of_liquid import Ring, growth_rate
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.answers.answer import Answer, Form, Shown, provenance
from autobalancer.results.labels import labeled
from autobalancer.roots import root
from autobalancer.tables import rpm_and_si
from autobalancer.units import list_argument

# The steady response of a rotor whose balancers are rings partly filled with liquid.


LOOKS = 401  # deflections at which the balance of forces is looked at
FARTHEST = 2.0  # greatest deflection that is looked at, over the radius of the smallest ring
EXACT = 1e-10  # of the ends of its band, relative
BANDS = 401  # speeds from 0.3 to 4 times the dry critical speed, at which self-excitation is looked for
LEAVES_OUT = (
    "steady whirl, in which the liquid is at rest in the rotor: how long it takes to settle, and the damping by its viscosity, "
    "are left out; growth is that of small motions without any damping"
)
WALLS = ("covered", "partly dry", "inner wall wet", "liquid falls")


def liquid_response(machine: Machine | str | Path, speeds: Sequence[float | str] | Floats | str) -> LiquidResponse:
    """Steady deflection of a planar rotor with rings partly filled with liquid, and without the liquid.

    Parameters
    ----------
    machine
        A machine or the path of a machine file, with ``liquid_rings`` and a planar rotor alike along x and y.
    speeds
        Rotor speeds above zero, rad/s.

    Returns
    -------
    xarray.Dataset
        Over ``speed``: ``deflection`` of the rotor (m; where several are steady, the least) and its ``phase`` against the
        unbalance (rad), ``greatest_deflection`` (m; of several steady ones), ``without_liquid`` and ``frozen`` (m; the rotor
        without the liquid, and with the liquid as a solid ring), ``share`` of the deflection without liquid that remains,
        ``liquid_moment`` (kg m; first moment of the liquid about the rotor's center, which counts as a balancing mass),
        ``growth_rate`` (1/s; of small motions without any damping, zero if none grows) and ``wall``: ``covered``, ``partly dry``,
        ``inner wall wet`` (not computed) or ``liquid falls`` (not computed: too slow to hold it against gravity).

    Raises
    ------
    QuestionError
        If a speed is not above zero, or the machine has no rings.
    MachineError
        If the rotor is not planar, differs along x and y, has rubber or hardening, or no unbalance.
    """
    omega = np.atleast_1d(np.asarray(list_argument("speeds", speeds, "rad/s"), np.float64))
    if omega.ndim != 1 or omega.size == 0 or not np.all(np.isfinite(omega) & (omega > 0.0)):
        raise QuestionError("liquid_response: speeds: give at least one; all must be finite and greater than zero")
    machine = balls_in_races(machine, rings=True)
    rings = rings_of(machine)
    if not rings:
        raise QuestionError("liquid_response: the machine has no 'liquid_rings'; a sample with one is liquid_ring")
    rotor = _rotor(machine)
    unbalance = sum(unbalance_factor(part, np.inf) * part.vector for part in machine.unbalances)
    if not unbalance:
        raise MachineError("liquid_response: unbalances: there is none, and without one nothing deflects the rotor")
    # speed below which gravity takes the liquid off the wall: on a vertical axis the surface is a paraboloid, which leaves the
    # top of the wall dry below w^2 = g L / (R^2 - b^2); on a horizontal one the liquid falls from the top at about w^2 b = g
    g, upright = float(machine.gravity), machine.axis == "vertical"
    heads = [ring.height / (ring.radius**2 - ring.surface**2) if upright else 1.0 / ring.surface for ring in rings]
    slowest = math.sqrt(g * max(heads))
    balance = _Balance(
        rings,
        float(rotor.mass),
        rotor.stiffness_xy[0],
        rotor.damping_xy[0],
        complex(unbalance),
        slowest,
    )
    moments = np.array([balance.moment(r) for r in balance.looked])
    rows: list[tuple[float, float, float, float, str]] = []  # least and greatest deflection, phase, moment, wall
    for w in omega.tolist():
        states = balance.steady(w, moments) if w >= balance.slowest else []
        if not states:
            rows.append((math.nan, math.nan, math.nan, math.nan, WALLS[2 if w >= balance.slowest else 3]))
            continue
        own = balance.moment(states[0]) - balance.liquid * states[0]  # about the rotor's center
        rows.append((states[0], states[-1], balance.phase(states[0], w), own, balance.wall(states[0])))
    least, greatest, phase, moment = (np.array([row[i] for row in rows]) for i in range(4))
    alone, frozen = (_linear(balance, omega, mass) for mass in (balance.mass, balance.mass + balance.liquid))
    growth = growth_rate(balance.rings, balance.mass, balance.stiffness, omega)
    walls = np.array([row[4] for row in rows], dtype=object)
    result = labeled(
        {
            "deflection": ("speed", least, "steady deflection with the liquid", "m"),
            "greatest_deflection": ("speed", greatest, "greatest steady deflection with the liquid", "m"),
            "phase": ("speed", phase, "phase of the deflection against the unbalance", "rad"),
            "without_liquid": ("speed", alone, "deflection without the liquid", "m"),
            "frozen": ("speed", frozen, "deflection with frozen liquid", "m"),
            "share": ("speed", least / alone, "share of the deflection without liquid that remains", "1"),
            "liquid_moment": ("speed", moment, "first moment of the liquid about the center of the rotor", "kg m"),
            "growth_rate": ("speed", growth, "growth rate of small motions without damping", "1/s"),
            "wall": ("speed", walls, "what the outer wall of the rings is like"),
        },
        {"speed": ("speed", omega, "rotor speed", "rad/s")},
        _attributes(machine, balance),
    )
    return LiquidResponse.of(result)


def _rotor(machine: Machine) -> PlanarRotor:
    rotor = machine.rotor
    if not isinstance(rotor, PlanarRotor):
        raise MachineError(f"rotor: of kind {rotor.kind!r}; rings of liquid are known on a planar rotor only")
    for name in ("rubber", "hardening"):
        if getattr(rotor, name) is not None:
            raise MachineError(f"rotor.{name}: rings of liquid are known on linear springs only; leave it out")
    if not rotor.isotropic:
        raise MachineError(
            "rotor: its supports differ along x and y, so the liquid never comes to rest in the rotor; make them alike"
        )
    return planar_rotor(machine)


class _Balance:
    """The balance of forces (k - M w^2 + i b w) z - w^2 S(|z|) z/|z| = U w^2 at many speeds."""

    def __init__(
        self, rings: tuple[Ring, ...], mass: float, stiffness: float, damping: float, unbalance: complex, slowest: float
    ) -> None:
        self.rings, self.mass, self.stiffness, self.damping = rings, mass, stiffness, damping
        self.unbalance, self.slowest = unbalance, slowest
        self.liquid, self.full = sum(ring.mass for ring in rings), sum(ring.full_mass for ring in rings)  # kg
        thin, far = min(ring.layer for ring in rings), FARTHEST * min(ring.radius for ring in rings)
        self.looked = np.concatenate([[0.0], np.geomspace(1e-3 * thin, far, LOOKS)])

    def moment(self, deflection: float) -> float:
        """S of all rings, kg m."""
        return sum(ring.moment(deflection) for ring in self.rings)

    def dynamic(self, speed: float) -> complex:
        """k - M w^2 + i b w."""
        return complex(self.stiffness - self.mass * speed**2, self.damping * speed)

    def excess(self, deflection: float, speed: float, moment: float | None = None) -> float:
        """Force that this deflection needs less that of the unbalance, N."""
        held = self.moment(deflection) if moment is None else moment
        return abs(self.dynamic(speed) * deflection - speed**2 * held) - speed**2 * abs(self.unbalance)

    def steady(self, speed: float, moments: Floats) -> list[float]:
        """All steady deflections, ascending, m; ``moments`` are those at the deflections that are looked at."""
        at = [self.excess(r, speed, s) for r, s in zip(self.looked, moments, strict=True)]
        state = []
        for i in np.flatnonzero(np.sign(at[1:]) * np.sign(at[:-1]) < 0.0):
            state.append(root(lambda r: self.excess(r, speed), self.looked[i], self.looked[i + 1], xtol=1e-15))
        return state

    def phase(self, deflection: float, speed: float) -> float:
        """Of the deflection against the unbalance, rad."""
        force = self.dynamic(speed) * deflection - speed**2 * self.moment(deflection)
        return float(-np.angle(force))

    def wall(self, deflection: float) -> str:
        """What the wall is like at a deflection."""
        if any(math.isnan(ring.moment(deflection)) for ring in self.rings):
            return WALLS[2]
        return WALLS[any(deflection > ring.layer for ring in self.rings)]


def _linear(balance: _Balance, omega: Floats, mass: float) -> Floats:
    dynamic = balance.stiffness - mass * omega**2 + 1j * balance.damping * omega
    with np.errstate(divide="ignore"):
        return np.asarray(omega**2 * abs(balance.unbalance) / np.abs(dynamic))


def _self_excited(balance: _Balance, speeds: Floats) -> tuple[float, float]:
    """The first and the last speed of those searched at which small motions grow, refined by bisection; nan if none does."""
    grows = growth_rate(balance.rings, balance.mass, balance.stiffness, speeds) > 0.0
    if not grows.any():
        return math.nan, math.nan
    ends = []
    for place, step in ((int(np.argmax(grows)), -1), (int(grows.size - 1 - np.argmax(grows[::-1])), 1)):
        inside, outside = float(speeds[place]), float(speeds[min(max(place + step, 0), speeds.size - 1)])
        while abs(outside - inside) > EXACT * inside:
            middle = 0.5 * (inside + outside)
            growing = growth_rate(balance.rings, balance.mass, balance.stiffness, middle) > 0.0
            inside, outside = (middle, outside) if growing else (inside, middle)
        ends.append(inside)
    return ends[0], ends[1]


def _attributes(machine: Machine, balance: _Balance) -> dict[str, Any]:
    dry = math.sqrt(balance.stiffness / balance.mass)
    band = _self_excited(balance, np.linspace(0.3, 4.0, BANDS) * dry)
    return {
        "title": f"Steady response of {machine.name}",
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "rotor_mass": balance.mass,
        "liquid_mass": balance.liquid,
        "full_mass": balance.full,
        "critical_speed": math.sqrt(balance.stiffness / (balance.mass + balance.full)),
        "dry_critical_speed": dry,
        "slowest": balance.slowest,
        "unstable_from": band[0],
        "unstable_to": band[1],
        "layers": [ring.layer for ring in balance.rings],
        "leaves_out": LEAVES_OUT,
        "ignores": ", ".join(unknown(machine, Theory.LIQUID)),
    }


# How the response of a rotor with rings of liquid shows itself.


ROWS = 12


class LiquidResponse(Answer):
    """Deflection over the speed with the liquid and without."""

    __slots__ = ()
    shown_as = Form(
        lambda it, unit: it.some().shown(
            unit,
            Shown("speed"),
            Shown("without_liquid", unit="mm", form=".4g"),
            Shown("deflection", "liquid", "mm", ".4g"),
            Shown("share", unit="%", form=".3g"),
            Shown("growth_rate", "growth", "1/s", ".3g"),
            Shown("wall"),
        ),
        "speed",
        ("deflection", "without_liquid", "share"),
        remarks=lambda it: [str(it.attrs["leaves_out"])],
    )

    def facts(self, said: Callable[[float], str] = rpm_and_si) -> list[tuple[str, str]]:
        """Masses, critical speeds, and where small motions grow; speeds as ``said`` writes them."""
        a = self.attrs
        share = 100.0 * a["rotor_mass"] / (a["rotor_mass"] + a["full_mass"])
        rows = [
            ("liquid", f"{a['liquid_mass']:.4g} kg; it moves with the rotor like {a['full_mass']:.4g} kg"),
            (
                "critical speed",
                f"{said(a['critical_speed'])}; without liquid {said(a['dry_critical_speed'])}",
            ),
            ("far above it", f"leaves {share:.3g} % of the deflection without liquid"),
        ]
        if np.isfinite(a["unstable_from"]):
            band = f"{said(a['unstable_from'])} to {said(a['unstable_to'])}"
            rows.append(("self-excited", f"{band}: waves of the liquid and the rotor, without any damping"))
        return rows

    def some(self) -> LiquidResponse:
        """Speeds for a table."""
        count = self.sizes["speed"]
        return self.isel(speed=np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int)))
