"""What friction holds, and where balls with friction stop."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.assembly.drive_train import greatest_rise, highest_prescribed
from autobalancer.assembly.terms import Theory, ignores, weightless
from autobalancer.catalog.product_tables import NONE_GIVEN
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.errors import ENSEMBLE, QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.laws.stall import held_whirl, largest_held_residual, rest_ends
from autobalancer.machine import Machine, Unbalance
from autobalancer.progress import check_deadline
from autobalancer.random_numbers import generator
from autobalancer.results.display_units import length_text, moment_text
from autobalancer.stability.host.stations import Stations, is_planar, stations, without_forces
from autobalancer.stability.states.rest_states import described, required, service_speed, yields
from autobalancer.tables import facts_text, rpm_and_si
from autobalancer.units import to_si, unbalance_argument

# What friction holds: the whirl below which balls at rest do not move, and the residual unbalance they leave.


STARTS = 400
PART_GIVEN = "some races have no friction: their balls are ideal"


def held_by_friction(
    machine: Machine | str | Path,
    speed: float | str | None = None,
    *,
    unbalance: complex | float | str | None = None,
    starts: int = STARTS,
    seed: int = 0,
) -> HeldByFriction:
    """The whirl below which friction holds balls at rest, and the residual unbalance that it leaves, at constant speed.

    A ball rests while the force along its race is below adherence times the wall force, so that no ball moves while its race
    runs less than ``mu eps / sqrt(1 + mu^2)`` beside the axis of rotation (Spannan 2021, section 4.2.3, in words). Where balls
    stop is found for random starts at rest in the rotor, which follows its balls without delay.

    Parameters
    ----------
    machine
        A machine or the path of a machine file; any rotor.
    speed
        rad/s or a string with a unit; by default the highest that the drive prescribes, else three times the lowest critical
        speed.
    unbalance
        As in :func:`autobalancer.stability.borders`.
    starts, seed
        Number of random starts of the distribution, and their seed.

    Raises
    ------
    QuestionError
        If the machine has no balls, or the speed is not above zero.
    """
    unbalance = unbalance_argument(unbalance)
    machine = balls_in_races(machine)
    balls = resolve(machine)
    if not balls:
        raise QuestionError("held by friction: the machine has no balls")
    st = _stations(machine, unbalance)
    prescribed, chosen = highest_prescribed(machine), ""
    at = service_speed(st, prescribed) if speed is None else float(to_si(speed, "rad/s"))
    if speed is None and not prescribed and st.critical_speeds:
        chosen = f"{at / min(st.critical_speeds):.3g} times the lowest critical speed, as no speed is prescribed"
    if not (math.isfinite(at) and at > 0.0):
        raise QuestionError(f"speed: given {speed!r}; must be greater than zero")
    holding, rolling = _coefficients(balls)
    left_out = ignores(machine, Theory.HELD)
    if not holding.any():
        return HeldByFriction(at, 0, (), "; ".join(filter(None, (NONE_GIVEN, left_out))), chosen)
    compliance = st.rows @ st.compliance(at) * at**2
    races = Races(
        whirl=compliance @ st.fixed_load,
        host=np.asarray(compliance @ st.rows.T, np.complex128),
        place=st.station,
        offset=st.offset,
        moment=st.moment,
        orbit=np.array([ball.orbit_radius for ball in balls]),
        adherence=holding,
        rolling=rolling,
        push=st.moment * at**2 / st.inertia,
        decay=st.drag / st.inertia,
    )
    angles = generator(seed).uniform(-math.pi, math.pi, (starts, len(balls)))
    result = _planes(st, at, races, stopped(_shaken(races, _weight(machine, at)), angles)[0], _weight(machine, at))
    rise = greatest_rise(machine, at)
    planes = tuple(replace(plane, drive_acceleration=rise) for plane in result)
    note = "; ".join(filter(None, ("" if holding.all() else PART_GIVEN, left_out)))
    return HeldByFriction(at, starts, planes, note, chosen)


def held_share(machine: Machine, speeds: Floats) -> Floats:
    """The whirl that friction holds over that of the unbalance alone, at each speed; the greatest of all planes.

    Above one balls at rest do not move there; zero without friction.
    """
    st, balls = _stations(machine, None), resolve(machine)
    holding, _ = _coefficients(balls)
    orbits = np.array([ball.orbit_radius for ball in balls])
    shares = []
    for speed in speeds.tolist():
        weight = _weight(machine, speed)
        pairs = zip(orbits.tolist(), holding.tolist(), strict=True)
        held = np.array([max(held_whirl(orbit, mu, weight=weight), 0.0) for orbit, mu in pairs])
        try:
            alone = unbalance_whirl(st, speed)[st.station]
        except QuestionError:  # a critical speed of an undamped rotor
            alone = np.full(held.size, np.inf)
        shares.append(float(np.max(held / np.maximum(alone, 1e-300))))
    return np.array(shares)


def _coefficients(balls: tuple[Ball, ...]) -> tuple[Floats, Floats]:
    """Adherence and rolling resistance of each ball."""
    return np.array([ball.adherence for ball in balls]), np.array([ball.rolling_resistance for ball in balls])


def _weight(machine: Machine, speed: float) -> float:
    return machine.gravity / speed**2 if machine.axis == "horizontal" else 0.0


def _stations(machine: Machine, unbalance: complex | float | None) -> Stations:
    guided = weightless(without_forces(machine)).model_copy(update={"tilting_races": "deflection"})
    if unbalance is not None and is_planar(machine):
        vector = described(guided, unbalance).unbalance
        one = Unbalance(moment=abs(vector), angle=cmath.phase(vector))
        return stations(guided.model_copy(update={"unbalances": (one,) if vector else ()}))
    return stations(guided, unbalance, largest=unbalance is None)


def unbalance_whirl(st: Stations, speed: float) -> Floats:
    """How far the races of each station run beside the axis of rotation under all that does not move, (P,) m; at most."""
    load, center = st.fixed_load * speed**2, race_centers(st)
    if st.isotropic:
        return np.abs(st.rows @ st.compliance(speed) @ load + center)
    pairs = st.model.pairs
    both = st.whole_compliance(speed)[:, : 2 * pairs] @ np.concatenate([load, -1j * load])
    x, y = st.rows @ both[:pairs], st.rows @ both[pairs : 2 * pairs]
    return np.asarray(np.abs(0.5 * (x + 1j * y) + center) + 0.5 * np.abs(x.conj() + 1j * y.conj()))


def race_centers(st: Stations) -> Complexes:
    """Mean center of the races of each station in the rotor, (P,) m."""
    return np.array([st.offset[st.station == place].mean() for place in range(len(st.names))], np.complex128)


def _shaken(races: Races, weight: float) -> Races:
    """Races whose balls the weight pulls to and fro once a turn: it takes from what friction holds, on either side."""
    taken = weight / races.orbit
    return races._replace(
        adherence=np.maximum(races.adherence - taken, 0.0), rolling=np.maximum(races.rolling - taken, 0.0)
    )


def _planes(st: Stations, speed: float, races: Races, whirl: Complexes, weight: float) -> tuple[HeldPlane, ...]:
    count = range(len(st.names))
    # what whirl each plane bears before its balls move
    balls = zip(races.place.tolist(), races.orbit.tolist(), races.adherence.tolist(), strict=True)
    kinds = [(place, held_whirl(orbit, mu, weight=weight)) for place, orbit, mu in dict.fromkeys(balls)]
    held = np.array([max(whirl for own, whirl in kinds if own == place) for place in count])
    center = race_centers(st)
    # unbalance over whirl: the inverse of how the planes move by unbalance
    stiff = np.asarray(np.linalg.pinv(races.host, rcond=1e-11), np.complex128)  # moment per whirl, kg
    needed = np.abs(required(st, speed))
    centered = np.abs(required(st, speed, center))  # so that the races run true, with the axis beside them
    eccentric = np.abs(stiff @ center)
    # the whirl without balancing, now and at every critical speed on the way
    alone = unbalance_whirl(st, speed)
    damped = bool(np.any(st.model.damping != 0.0))
    passed = [critical for critical in st.critical_speeds if critical <= speed]
    below = [unbalance_whirl(st, critical) if damped else np.full(alone.size, math.inf) for critical in passed]
    greatest = np.max([alone, *below], axis=0)
    # residuals of all starts that were tried, about the axis and about the race centers
    residual, held_back = np.abs(whirl @ stiff.T), np.abs((whirl + center) @ stiff.T)
    total = needed + np.bincount(races.place, races.moment, needed.size)
    # the greatest residual at which all balls can still stick
    most = (
        total if yields(st, speed) else _sticking(races, stiff, centered, held)
    )  # else balls gather on the heavy side
    sticking = np.minimum(most + eccentric, total)
    # how far beside its balanced place a ball may stay
    shaken = _shaken(races, weight)

    def widest(here: NDArray[np.bool_], gain: complex) -> float:
        kinds = np.unique(np.column_stack([shaken.moment, shaken.orbit, shaken.adherence])[here], axis=0).tolist()
        every = [rest_ends(gain, moment, moment, orbit, mu) for moment, orbit, mu in kinds if mu > 0.0]
        return max((abs(end) for ends in every if ends for end in ends), default=0.0)

    # plane by plane, as numbers that say themselves
    planes = []
    for place, name in enumerate(st.names):
        here = races.place == place
        loads = float(np.abs(stiff[place]) @ np.maximum(held, 0.0))
        whole = centered[place] + races.moment[here].sum()
        deflection = np.abs(whirl[:, place])
        planes.append(
            HeldPlane(
                name=name,
                adherence=float(races.adherence[here].max()),
                rolling_resistance=float(races.rolling[here].max()),
                held_whirl=float(held[place]),
                unbalance_whirl=float(alone[place]),
                largest_whirl=float(greatest[place]),
                required=float(needed[place]),
                capability=float(st.capability[place]),
                held_residual=min(loads, float(total[place])),
                sticking_residual=float(sticking[place]),
                eccentric_residual=float(eccentric[place]),
                greatest_residual=float(residual[:, place].max()),
                median_residual=float(np.median(residual[:, place])),
                residual_95=float(np.quantile(residual[:, place], 0.95)),
                trapped_share=float((held_back[:, place] > most[place] * (1.0 + 1e-9)).mean()),
                median_whirl=float(np.median(deflection)),
                whirl_95=float(np.quantile(deflection, 0.95)),
                rest_interval=widest(here, complex(races.host[place, place])),
                greatest_acceleration=max(float(held[place]), 0.0) * speed**2 / float(races.orbit[here].max()),
                heavy_interval=math.asin(min(loads / whole, 1.0)) if loads < whole else math.pi,
            )
        )
    return tuple(planes)


def _sticking(races: Races, stiff: Complexes, needed: Floats, held: Floats) -> Floats:
    """Largest residuals at which balls stop; whirls of other planes change what a plane needs, so that all are found together."""
    count = needed.size
    whirl = np.maximum(held, 0.0)
    size = np.abs(stiff)
    own = np.diag(size)
    for _ in range(6):
        before = whirl.copy()
        for place in range(count):
            others = float(size[place] @ before - own[place] * before[place])
            span = (max(needed[place] - others, 0.0), needed[place] + others)
            phase = -float(np.angle(stiff[place, place]))
            most = largest_held_residual(
                span, races.moment[races.place == place].tolist(), own[place] * max(held[place], 0.0), phase=phase
            )
            whirl[place] = max(most / own[place], before[place]) if own[place] > 0.0 else before[place]
        if np.allclose(whirl, before, rtol=1e-3):
            break
    total = needed + np.bincount(races.place, races.moment, count)
    return np.asarray(np.minimum(size @ whirl, total), np.float64)


# Where balls with friction stop, from many starts at rest in the rotor at constant speed.
#
# The rotor follows its balls without delay: Z = W^2 (H_u U + H s) at each instant. Each ball moves with its inertia,
# linear drag and rolling resistance along its race, and stays where its speed reaches zero and adherence can hold it.


STEPS = 6000
STEP = 0.15  # of the shortest period of a ball over 2 pi
QUIET = 1e-6  # speed of a ball that creeps to its place, over the same frequency: it has arrived
SLOWEST = 0.02  # least decay rate over that frequency: thinner fluids only take longer


class Races(NamedTuple):
    """Balls in their races at one speed: n balls at P stations."""

    whirl: Complexes  # (P,) of the stations under all that does not move, m
    host: Complexes  # (P, P) whirl per moment, 1/kg
    place: NDArray[np.int64]  # (n,)
    offset: Complexes  # (n,) race centers, m
    moment: Floats  # (n,) kg m
    orbit: Floats  # (n,) m
    adherence: Floats  # (n,)
    rolling: Floats  # (n,)
    push: Floats  # (n,) angular acceleration per distance of the race from the axis, m eps W^2 / I
    decay: Floats  # (n,) drag over inertia, 1/s


def stopped(races: Races, starts: Floats) -> tuple[Complexes, NDArray[np.bool_]]:
    """Whirl of the stations where all balls have stopped, (runs, P) m, and which runs came to rest."""
    angle = np.array(starts, np.float64)
    speed = np.zeros_like(angle)
    moving = np.zeros(angle.shape, np.bool_)
    belongs = np.zeros((races.place.size, races.whirl.size))
    # to which station each ball belongs
    belongs[np.arange(races.place.size), races.place] = 1.0
    # steps are short against the fastest motion of balls in the greatest whirl there can be
    farthest = np.abs(races.whirl) + np.abs(races.host) @ (belongs.T @ races.moment)
    frequency = math.sqrt(float((races.push * (farthest[races.place] + np.abs(races.offset))).max()) or 1.0)
    step = STEP / frequency
    decay = 1.0 + step * np.maximum(races.decay, SLOWEST * frequency)
    whirl = np.zeros((angle.shape[0], races.whirl.size), np.complex128)
    for _ in range(STEPS):
        check_deadline()
        # the rotor follows at once: its whirl from where all balls are now
        along = np.exp(1j * angle)
        whirl = races.whirl + (races.moment * along) @ belongs @ races.host.T
        seen = (whirl[:, races.place] + races.offset) * along.conj()
        # force along the race and on its wall; adherence holds a ball up to its share of the latter
        push = races.push * seen.imag
        wall = races.push * np.maximum(races.orbit + seen.real, 0.0)
        loose = np.abs(push) > races.adherence * wall
        free = moving | loose
        # implicit in the decay, so that drag of any size is stable; a ball that turns round stops first
        way = np.where(moving, np.sign(speed), np.sign(push))
        after = (speed + step * (push - races.rolling * wall * way)) / decay
        moving = free & (after * way > 0.0)
        speed = np.where(moving, after, 0.0)
        if not (loose | (np.abs(speed) > QUIET * frequency)).any():
            break
        angle += step * speed
    return whirl, ~(loose | (np.abs(speed) > QUIET * frequency)).any(axis=1)


# What friction holds in a plane, as values that say themselves in words.


RELEASED = "released at rest at this speed at random places (not a run-up)"
OF_RELEASED = f"in 95 % of the starts of balls released at rest in the rotor at that speed, not of run-ups ({ENSEMBLE})"


@dataclass(frozen=True)
class HeldPlane:
    """What friction does to the balls of one plane at one speed; SI.

    ``held_whirl``: distance of the race from the axis of rotation below which no ball at rest moves, at any angle.
    ``unbalance_whirl``: what the unbalance, and the eccentricity of the race, make there while the balls are spread evenly,
    and ``largest_whirl`` the greatest at a critical speed on the way up. ``held_residual``: residual unbalance that makes the
    held whirl; the balls may rest at any smaller one. ``sticking_residual``: the largest at which they can stop on their way to
    balance, with ``eccentric_residual``, which a race off the axis leaves without friction, too. ``median_residual`` and
    ``residual_95``: half, and 95 %, of the balls released at rest at this constant speed at random places end below,
    ``greatest_residual`` all of them; ``trapped_share`` of them are held farther from balance than balls stick on their way,
    with balls in line that balance next to nothing.
    ``rest_interval``: to each side of its balanced place a ball stays within it while the others stand right.
    ``heavy_interval``: balls that stand within it about the heavy place all stay there, and add to the unbalance. Angles in rad.
    ``greatest_acceleration``: of the rotor, rad/s^2, up to which adherence alone takes a ball along that rests.
    ``drive_acceleration``: the greatest that the drive prescribes above this speed, rad/s^2, reduced by the square of the
    speed where it is higher, because friction holds more there; None if the speed follows from a torque.
    """

    name: str
    adherence: float
    rolling_resistance: float
    held_whirl: float
    unbalance_whirl: float
    largest_whirl: float
    required: float
    capability: float
    held_residual: float
    sticking_residual: float
    median_residual: float
    residual_95: float
    eccentric_residual: float
    greatest_residual: float
    trapped_share: float
    median_whirl: float
    whirl_95: float
    rest_interval: float
    heavy_interval: float
    greatest_acceleration: float
    drive_acceleration: float | None = None

    @property
    def holds(self) -> bool:
        """Whether evenly spread balls at rest do not move under the unbalance."""
        return self.unbalance_whirl <= self.held_whirl

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """All that in words: labels, the first of them empty, and texts."""
        if self.held_whirl <= 0.0:
            return (("", "the weight of the balls moves them in each turn; friction does not hold them at rest"),)
        off = self.eccentric_residual > 0.0
        first = (
            f"balls at rest do not move unless the race whirls by more than {length_text(self.held_whirl)}; "
            f"the unbalance of {moment_text(self.required)} {'and the eccentricity' if off else 'alone'} "
            f"{'make' if off else 'makes'} {length_text(self.unbalance_whirl)}"
        )
        result = [("", first), ("sticking", self._sticking), *self._of_starts]
        if not self.holds:
            near = f"each ball rests within {_deg(self.rest_interval)} of its balanced place"
            return *result, (
                "places",
                f"{near}, and balls within {_deg(self.heavy_interval)} of the heavy place stay there",
            )
        before = (
            f"on the way up the whirl of {length_text(self.largest_whirl)} at a critical speed may have moved them"
            if self.largest_whirl > self.held_whirl
            else "nor does any whirl on the way up"
        )
        return result[0], ("moving", f"THE BALLS WILL NOT MOVE at this speed; {before}"), *result[1:]

    @property
    def settled_rows(self) -> tuple[tuple[str, str], ...]:
        """What is left if the balls settle at this speed, and the speed then rises without moving them."""
        rise = f"they keep these places only if the speed rises slower than {self.greatest_acceleration:.2g} rad/s^2{self._drive}"
        return ("", f"balls that settle there: {self._sticking}"), *self._of_starts, ("rise", rise)

    @property
    def sentence(self) -> str:
        """The rows as one text."""
        return "; ".join(text for _, text in self.rows)

    @property
    def _sticking(self) -> str:
        most = moment_text(self.sticking_residual)
        if self.holds:
            return f"residual at most {most}, unbalance and balls together"
        where = f"residual at most {most} where balls stick on their way to balance"
        if self.trapped_share > 0.0:
            where += ", more where they are trapped"
        if self.eccentric_residual > 0.0:
            where += f"; {moment_text(self.eccentric_residual)} of it is left by the eccentric race, and friction holds the rest"
        return where

    @property
    def _of_starts(self) -> tuple[tuple[str, str], ...]:
        left = f"median {moment_text(self.median_residual)}, 95 % below {moment_text(self.residual_95)}"
        starts = ("starts", f"{RELEASED}: {left}")
        if not self.trapped_share > 0.0:
            return (starts,)
        ended = "trapped in line" if self.trapped_share < 0.5 else "without any balance"
        share, most = f"{100.0 * self.trapped_share:.2g} % of them end {ended}", moment_text(self.greatest_residual)
        return starts, ("trapped", f"{share}, the greatest residual of all starts: {most}")

    @property
    def carried_on(self) -> bool | None:
        """Whether the drive rises too fast for resting balls to stay; None where it does not prescribe the speed."""
        return None if self.drive_acceleration is None else self.drive_acceleration >= self.greatest_acceleration

    @property
    def _drive(self) -> str:
        if not self.drive_acceleration:  # a torque, or no rise at all
            return ""
        if self.carried_on:
            return f"; this drive ({self.drive_acceleration:.3g} rad/s^2) moves them again"
        return "; this drive rises more slowly"


@dataclass(frozen=True)
class HeldByFriction:
    """What friction holds in each plane with balls at a speed (rad/s), with ``starts`` random starts; and a note.

    Without friction ``planes`` is empty and the note says so. ``chosen`` says why this speed where neither drive nor user do.
    """

    speed: float
    starts: int
    planes: tuple[HeldPlane, ...]
    note: str
    chosen: str = ""

    def at(self, said: Callable[[float], str]) -> str:
        """The speed as ``said`` writes it, and why this one."""
        return said(self.speed) + (f" ({self.chosen})" if self.chosen else "")

    def __repr__(self) -> str:
        rows = [
            (plane.name if not k else label, text)
            for plane in self.planes
            for k, (label, text) in enumerate(plane.rows)
        ]
        told = [facts_text(rows)] if rows else []
        return "\n".join((f"friction at {self.at(rpm_and_si)}", *told, *([self.note] if self.note else [])))

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        planes = [
            {**asdict(plane), "holds": plane.holds, "carried_on": plane.carried_on, "sentence": plane.sentence}
            for plane in self.planes
        ]
        return {**asdict(self), "planes": planes}


def _deg(angle: float) -> str:
    return f"{math.degrees(angle):.2g} deg"
