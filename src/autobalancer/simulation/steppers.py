"""How a run is integrated: by an explicit pair, or by long steps with the pair beside them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, get_args

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.system import Assembly, Model
from autobalancer.cache import remembered
from autobalancer.errors import QuestionError, one_of
from autobalancer.kernels.balls.contact_nodes import contacts_in_steps
from autobalancer.kernels.balls.planar import planar
from autobalancer.kernels.balls.planar_nodes import planar_nodes
from autobalancer.kernels.compiler.cache import Work, compile_in_parallel
from autobalancer.kernels.compiler.callbacks import callback
from autobalancer.kernels.compiler.simd import NODES
from autobalancer.kernels.host.linear_nodes import room
from autobalancer.kernels.integrators import tableau
from autobalancer.kernels.integrators.collocation import Amplitudes, amplitudes, room_of_change
from autobalancer.kernels.integrators.collocation_sweep import by_powers
from autobalancer.kernels.integrators.integrator_state import (
    ACCEPTED,
    EVALUATIONS,
    REJECTED,
    Memory,
    memory,
    no_switch,
    switch_type,
)
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.integrators.runge_kutta import advance
from autobalancer.kernels.records import HILL, PRESCRIBED, RECORDED
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, Drive, System, X, Y, rhs_type
from autobalancer.simulation import Method

# Which compiled equations of motion belong to an assembled machine.


class Equations(NamedTuple):
    """The first two arguments of :func:`autobalancer.kernels.integrators.runge_kutta.advance`."""

    rates: Any  # the right-hand side
    switch: Any = no_switch

    def ready(self) -> tuple[Any, Any]:
        """The same, where they are called often."""
        return callback(self.rates, rhs_type), callback(self.switch, switch_type)


PLANAR = Equations(planar)


def equations(assembly: Assembly) -> Equations:
    """The equations of a machine; only those that it needs are loaded. Impacts are noted where there is room for them."""
    chosen = _equations(assembly)
    if assembly.system.ties.size:
        from autobalancer.kernels.balls.race_events import rigid_contact

        return chosen._replace(switch=rigid_contact)
    if not assembly.system.touches.size:
        return chosen
    from autobalancer.kernels.balls import race_events

    if assembly.model is Model.RESOLVED:
        return chosen._replace(switch=race_events.impacts_of_resolved)
    noting = race_events.impacts_of_guided if chosen.switch is no_switch else race_events.impacts_and_adherence
    return chosen._replace(switch=noting)


def _equations(assembly: Assembly) -> Equations:
    if assembly.model is Model.PLANAR:
        return PLANAR
    if assembly.model is Model.RESOLVED:
        from autobalancer.kernels.balls.resolved_balls import resolved

        return Equations(resolved)
    if assembly.rough:
        from autobalancer.kernels.balls.on_stations import guided_rough, guided_rough_tilting

        chosen = guided_rough_tilting if assembly.model is Model.ROUGH_TILTING else guided_rough
    else:
        from autobalancer.kernels.balls.on_stations import guided, guided_tilting

        chosen = guided_tilting if assembly.model is Model.TILTING else guided
    balls = assembly.system.balls
    if not (balls.rolling.any() or balls.adherence.any()):
        return Equations(chosen)
    from autobalancer.kernels.balls.race_events import adherence

    return Equations(chosen, adherence)


class LongSteps(NamedTuple):
    """What long steps need beside the pair."""

    nodes: Any  # forces at the nodes of a step
    watch: Any  # how far they hold
    powers: tableau.Tableau
    memory: Memory  # shares time, state and counts with that of the pair
    amplitudes: Any


class Stepper(NamedTuple):
    """One integration of an assembled machine; it can stop after any step and go on."""

    method: str
    moving: Equations
    pair: tableau.Tableau
    memory: Memory
    long: LongSteps | None = None

    def make_ready(self) -> None:
        """Load or compile the kernels of a run, those of its result too."""
        from autobalancer.kernels.measures.observables import observe, observe_locked_balls

        rates, switch = self.moving
        works: list[Work] = [(switch, switch_type.signature), (rates, rhs_type.signature)]
        if self.long is None:
            works += [(observe_locked_balls, None), (observe, None), (advance, None)]
        else:
            from autobalancer.kernels.integrators.collocation import nodes_type, watch_type
            from autobalancer.kernels.integrators.collocation_stepper import integrate

            works += [(self.long.nodes, nodes_type.signature), (self.long.watch, watch_type.signature)]
            works += [(observe_locked_balls, None), (observe, None), (integrate, None)]
        compile_in_parallel(works, then=OF_RESULTS)

    def advance(self, system: System, record: Record, budget: int) -> int:
        """Take up to ``budget`` accepted steps; returns how that ended, see kernels/integrators/runge_kutta.py."""
        moving = self.moving.ready()
        if self.long is None:
            return int(advance(*moving, system, self.pair, record, self.memory, budget))
        from autobalancer.kernels.integrators.collocation import nodes_type, watch_type
        from autobalancer.kernels.integrators.collocation_stepper import integrate

        nodes, watch, powers, memory, amplitudes = self.long
        ways = callback(nodes, nodes_type), callback(watch, watch_type)
        return int(
            integrate(*moving, *ways, system, self.pair, powers, record, self.memory, memory, amplitudes, budget)
        )

    def attributes(self) -> dict[str, str | int]:
        """For a result: the method and its work."""
        counts, work = self.memory.counts, {}
        if self.long is not None:
            from autobalancer.kernels.integrators.collocation import LONG_STEPS, SWEEPS

            tallies = self.long.amplitudes.tallies
            work = {"long_steps": int(tallies[LONG_STEPS]), "sweeps": int(tallies[SWEEPS]), "lanes": NODES}
        return {
            "method": self.method,
            "steps": int(counts[ACCEPTED]),
            "rejected_steps": int(counts[REJECTED]),
            "evaluations": int(counts[EVALUATIONS]),
            **work,
        }


OF_RESULTS = ("autobalancer.kernels.measures.record_series",)
FINEST = 1e-11  # tolerance below which "auto" takes the pair: long steps were compared with it down to 1e-9


def stepper_for(assembly: Assembly, end: float, tolerance: float, method: str = "auto") -> Stepper:
    """A fresh integration of a machine up to ``end``.

    Raises
    ------
    QuestionError
        If the method is unknown or this machine cannot be integrated with it.
    """
    one_of("method", method, *get_args(Method))
    pair = tableau.tsitouras() if method == "tsitouras" else tableau.dormand_prince_8()
    memory, moving = memory_for(assembly, end, tolerance, pair), equations(assembly)
    if method == "exponential_collocation" or (method == "auto" and tolerance >= FINEST):
        obstacle, long = why_no_long_steps(assembly), None
        if not obstacle and (long := long_steps(assembly, memory)) is None:
            obstacle = NEARLY_THE_SAME
        if obstacle and method != "auto":
            raise QuestionError(f"method: 'exponential_collocation' is not possible here: {obstacle}; take 'auto'")
        if long is not None:
            return Stepper("exponential_collocation", moving, pair, memory, long)
    return Stepper("dormand_prince_8" if method == "auto" else method, moving, pair, memory)


# A fresh integration.


def memory_for(assembly: Assembly, end: float, tolerance: float, pair: tableau.Tableau) -> Memory:
    """A fresh integration of an assembled machine up to ``end``."""
    return memory(
        assembly.state,
        end,
        tolerance * assembly.scale,
        tolerance * assembly.growing,
        total=pair.total,
        degree=pair.degree,
        longest=end,
    )


# Which machines can be integrated in long steps, and the modes of their rotors for it.


DAMPED = 0.9  # of the critical damping: beyond it both modes are nearly one, and amplitudes lose digits
NEARLY_THE_SAME = "two modes of its rotor are nearly equal, or one decays without vibrating"


def why_no_long_steps(assembly: Assembly) -> str:
    """What is in the way, as a sentence; empty if nothing is."""
    system = assembly.system
    if system.forces.shape[0] > 0:
        return "it does not take forces on the balls"
    if assembly.model is not Model.PLANAR:
        return _why_no_modes(assembly)
    if not system.rotating:
        return "of planar rotors it takes those with equal springs along x and y without gravity in the plane only"
    rotor = system.planar
    if rotor.damping_x > 2.0 * DAMPED * math.sqrt(rotor.stiffness_x * rotor.mass):
        return f"the rotor is damped by more than {DAMPED:.0%} of its critical damping"
    return ""


def _why_no_modes(assembly: Assembly) -> str:
    """The same of a rotor that tilts or bends, or has real races."""
    system = assembly.system
    obstacles = {
        "balls that are resolved in contact": assembly.model is Model.RESOLVED,
        "laws of rolling resistance": bool(system.balls.friction.any()),
        "real races that tilt": assembly.model is Model.ROUGH_TILTING,
        "recorded excitations": bool((system.shakes.kind == RECORDED).any()),
        "a stop of a bearing": bool((system.bearings.springs.contact > 0.0).any()),
        "rubber that softens": system.rubber.mounts.shape[0] > 0,
        "couplings, a mount of the motor or ripples of its torque": system.drive.linked == 1,
        "tables over the speed": len(system.host.speeds) > 1,
        "a fluid that lags by itself": system.fluid.modes.shape[0] > 0,
        "slipstream": system.fluid.lines.shape[0] > 0,
    }
    return next((f"it does not take {what}" for what, there in obstacles.items() if there), "")


def long_steps(assembly: Assembly, memory: Memory, near: float | None = None) -> LongSteps | None:
    """Long steps of a machine, beside a pair with this memory; None if its modes carry no motion.

    Of a rotor that stays ``near`` a speed, the modes there are enough.
    """
    if assembly.model is Model.PLANAR:
        nodes, watch, unknowns = planar_nodes, contacts_in_steps, planar_amplitudes(assembly)
    else:
        modes = rotor_modes(assembly.system, assembly.state, assembly.critical_speeds, near)
        if modes is None:
            return None
        (nodes, watch), unknowns = _node_equations(assembly), modes
    width = memory.trial.size
    own = memory._replace(stages=np.zeros((NODES, width)), dense=np.zeros((NODES, width)), shares=np.zeros(NODES))
    return LongSteps(nodes, watch, by_powers(), own, unknowns)


def _node_equations(assembly: Assembly) -> tuple[Any, Any]:
    """The forces at the nodes of a rotor with stations, and how far they hold."""
    if assembly.model is Model.ROUGH:
        from autobalancer.kernels.balls.station_nodes import open_and_rolling, rough_station_nodes

        return rough_station_nodes, open_and_rolling
    from autobalancer.kernels.balls.contact_nodes import contacts_at_nodes
    from autobalancer.kernels.balls.station_nodes import station_nodes, tilting_station_nodes

    return (tilting_station_nodes if assembly.model is Model.TILTING else station_nodes), contacts_at_nodes


def planar_amplitudes(assembly: Assembly) -> Amplitudes:
    """The modes of a planar rotor."""
    rotor = assembly.system.planar
    stiffness, damping = rotor.stiffness_x / rotor.mass, rotor.damping_x / rotor.mass
    decay = 0.5 * damping
    turn = math.sqrt(stiffness - decay * decay)
    # zeta = p+ + p-, nu = mu+ p+ + mu- p-, real and imaginary parts apart
    shapes = np.array(
        [[1, 0, 1, 0], [0, 1, 0, 1], [-decay, -turn, -decay, turn], [turn, -decay, -turn, -decay]], np.float64
    )
    return amplitudes(
        np.array([complex(-decay, turn), complex(-decay, -turn)]),
        shapes,
        np.array([X, Y, VX, VY]),
        assembly.system.ball_count,
        np.array([stiffness, damping, decay, turn]),
        assembly.state.size,
        turning=True,
    )


# The modes of a linear rotor with stations, as the numbers of its long steps.


BASES = 32  # speeds at which the modes of a rotor with gyroscopic forces are worked out
SMALL_ROTOR = 12  # coordinates; a larger rotor has fewer bases
FEW_BASES = 12
ILL = 1e6  # condition of the shapes beyond which modes are no coordinates: two of them are nearly the same
FURTHER = (
    3.0  # times the highest critical speed, up to which bases reach where the drive does not say how fast it turns
)


def rotor_modes(
    system: System,
    state: Floats,
    critical_speeds: tuple[float, ...],
    near: float | None = None,
    like: Amplitudes | None = None,
) -> Amplitudes | None:
    """The modes of a rotor; None if they cannot carry its motion. They are those ``near`` a speed, or all that a drive asks for.

    In the order and with the phases of those of a rotor that they are ``like``.

    On axes that turn with the rotor a mode is a whirl, forward or backward, and may decay as fast as it will. In axes at rest it
    is a vibration; there a rotor that creeps back without vibrating has too few of them.
    """
    h, n = system.host, system.ball_count
    stiffness, damping = (one[0, : h.size, : h.size].T for one in (h.stiffness, h.damping))
    gyroscopic = h.gyroscopic[: h.size, : h.size].T
    speeds = np.zeros(1)
    if gyroscopic.any() and near is not None:
        speeds = np.array([near])
    elif gyroscopic.any():
        low, high = _reach(system.drive, state[SPEED], critical_speeds)
        speeds = np.linspace(low, high, BASES if h.size <= SMALL_ROTOR else FEW_BASES)
    known = None if like is None else like.bases[: -room_of_change(h.size)].reshape(speeds.size, -1)
    bases = _bases(stiffness, damping, gyroscopic, speeds, bool(system.rotating), known)
    if bases is None:
        return None
    rest = BALLS + 2 * n
    rows, each = system.work.inert.shape
    numbers = np.zeros(room(h.size, rows, each, n))
    numbers[0] = float(gyroscopic.any())
    exponents, shapes = bases[0, 1 : 1 + 2 * h.size], bases[0, 1 + 4 * h.size :][: 4 * h.size**2]
    return amplitudes(
        exponents[0::2] + 1j * exponents[1::2],
        shapes.reshape(2 * h.size, 2 * h.size),
        np.array([X, Y, *range(rest, rest + h.size - 2), VX, VY, *range(rest + h.size - 2, rest + 2 * h.size - 4)]),
        n,
        numbers,
        state.size,
        turning=bool(system.rotating),
        bases=np.concatenate([bases.ravel(), np.zeros(room_of_change(h.size))]),
    )


def _reach(drive: Drive, start: float, critical_speeds: tuple[float, ...]) -> tuple[float, float]:
    """The least and the greatest speed of the bases."""
    speeds = [0.0, float(start)]
    if drive.kind == PRESCRIBED:
        ends = np.append(drive.segments.start[1:], drive.segments.start[-1:])
        for segment, end in zip(drive.segments, ends, strict=True):
            its = segment.end if segment.kind == HILL else segment.value + (end - segment.start) * segment.rate
            speeds += [float(segment.value), float(segment.begin), float(its)]
    else:
        speeds += [FURTHER * max(critical_speeds, default=100.0), drive.synchronous_speed, *drive.table[:, 0].tolist()]
    return min(speeds), max(*speeds, min(speeds) + 1.0)


@remembered(8, by=lambda *given: tuple(one.tobytes() if isinstance(one, np.ndarray) else one for one in given))
def _bases(
    stiffness: Matrix, damping: Matrix, gyroscopic: Matrix, speeds: Floats, turning: bool, like: Matrix | None = None
) -> Matrix | None:
    """For each speed the exponents, what they gain per speed, shapes and their inverse, of M^-1 K, M^-1 C and M^-1 G."""
    size = stiffness.shape[0]
    parts = [_complex(one) if turning else one for one in (stiffness, damping, gyroscopic)]
    order, count = parts[0].shape[0], speeds.size
    whole = np.zeros((count, 2 * order, 2 * order), parts[0].dtype)
    whole[:, :order, order:] = np.eye(order)
    whole[:, order:, :order] = -parts[0]
    whole[:, order:, order:] = -parts[1] - speeds[:, None, None] * parts[2]
    exponents, shapes = np.linalg.eig(whole)
    if like is not None:
        order_of, scale = _matched(like[:, -4 * size**2 :].reshape(count, 2 * size, 2 * size), shapes, turning)
        exponents = np.take_along_axis(exponents, order_of, axis=1)
        shapes = np.take_along_axis(shapes, order_of[:, None], axis=2) / scale[:, None]
    kept = np.ones(exponents.shape, np.bool_) if turning else exponents.imag > 0.0
    if (kept.sum(axis=1) != size).any() or not _apart(shapes, exponents):
        return None
    inverse = np.linalg.inv(shapes)
    drifts = -np.einsum("tkj,jl,tlk->tk", inverse[:, :, order:], parts[2], shapes[:, order:])
    one: Complexes = shapes.swapaxes(1, 2)[kept].reshape(count, size, 2 * order).swapaxes(1, 2)
    other: Complexes = inverse[kept].reshape(count, size, 2 * order)
    if turning:
        matrices = _turning(one), _turning(other)
    else:
        matrices = _resting(np.asarray(2.0 * one)), _resting(other.conj().swapaxes(1, 2)).swapaxes(1, 2)
    chosen = (np.ascontiguousarray(numbers[kept].reshape(count, size)) for numbers in (exponents, drifts))
    drawn = (*(one.view(np.float64) for one in chosen), *(matrix.reshape(count, -1) for matrix in matrices))
    return np.hstack([speeds[:, None], *drawn])


def _matched(inverse: Matrix, shapes: Complexes, turning: bool) -> tuple[Any, Complexes]:
    """Which mode is most like each of those with this ``inverse``, and its part in that one, (k, modes).

    Divided by it, shapes are smooth functions of what a rotor is made of.
    """
    from scipy.optimize import linear_sum_assignment

    if turning:
        rows = inverse[:, 0::2, 0::2] + 1j * inverse[:, 1::2, 0::2]
    else:
        half = inverse[:, 0::2] + 1j * inverse[:, 1::2]
        rows = np.concatenate([half, half.conj()], axis=1)
    parts = rows @ shapes
    orders = np.array([linear_sum_assignment(-np.abs(part))[1] for part in parts])
    return orders, np.take_along_axis(parts, orders[:, :, None], axis=2)[:, :, 0]


def _apart(shapes: Complexes, exponents: Complexes) -> bool:
    """Whether modes differ enough to be coordinates; velocities count in the fastest mode's amplitude."""
    order = shapes.shape[1] // 2
    scaled = shapes.copy()
    scaled[:, order:] /= np.abs(exponents).max() + 1e-300
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    return bool(np.isfinite(scaled).all() and (np.linalg.cond(scaled) < ILL).all())


def _complex(matrix: Matrix) -> Complexes:
    """A matrix of an isotropic rotor over x + i y."""
    return np.asarray(matrix[0::2, 0::2] + 1j * matrix[1::2, 0::2], np.complex128)


def _turning(matrices: Complexes) -> Matrix:
    """Complex matrices over real and imaginary parts, alternating."""
    count, rows, columns = matrices.shape
    result = np.zeros((count, 2 * rows, 2 * columns))
    result[:, 0::2, 0::2] = result[:, 1::2, 1::2] = matrices.real
    result[:, 0::2, 1::2], result[:, 1::2, 0::2] = -matrices.imag, matrices.imag
    return result


def _resting(matrices: Complexes) -> Matrix:
    """The real part of complex matrices times amplitudes, over their real and imaginary parts, alternating."""
    count, rows, columns = matrices.shape
    result = np.zeros((count, rows, 2 * columns))
    result[:, :, 0::2], result[:, :, 1::2] = matrices.real, -matrices.imag
    return result
