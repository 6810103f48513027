"""The equations of :mod:`autobalancer.kernels.balls.smooth_races` at all nodes of a long step, for balls that touch nothing."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.at_nodes.clusters import bind_at_nodes
from autobalancer.kernels.balls.at_nodes.rows import OWN, WEIGHT, add, keep, kept_at, rate_of_rows, station_places
from autobalancer.kernels.balls.guided import (
    Path,
    Row,
    Share,
    Slope,
    circle,
    known_acceleration,
    row,
    share,
    solved,
    tilting_row,
    tilting_share,
)
from autobalancer.kernels.balls.planar_nodes import set_rate_of_rotor
from autobalancer.kernels.flags import EQUATIONS, MERGED, njit
from autobalancer.kernels.host.acted_nodes import acted_at_nodes
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.linear_nodes import (
    ROOM,
    Q,
    V,
    alone_at_nodes,
    times,
    together_at_nodes,
    write_forces,
)
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_at
from autobalancer.kernels.integrators.collocation.rates import set_rate
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.drive import PRESCRIBED
from autobalancer.kernels.system import system_at
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes
from autobalancer.kernels.wide import NODES, all_lanes, load, store


@njit(**EQUATIONS)
def station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """Balls that feel the deflection of their station."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    motion, torque, inertia = begin(time, step, False, p, a)
    for b in range(a.balls):
        path, its, part = _flat(b, motion, p, a)
        found = solved(its, freedom(b, p), motion.acceleration)
        load_station(b, motion, path, its, part, found, p, a)
        keep(found, 0, 2, b, p, a)
        keep_bound(its, 2, b, p, a)
        torque += part.torque - its.spin * found.push
        inertia += part.inertia - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**EQUATIONS)
def tilting_station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    motion, torque, inertia = begin(time, step, True, p, a)
    for b in range(a.balls):
        ball, slope = p.balls[b], _slope(p.balls[b].station, p, a)
        path, flat, level = _flat(b, motion, p, a)
        its = tilting_row(flat, ball.mass, path, motion, slope)
        part = tilting_share(level, ball.mass, path, motion, slope, rate_at_nodes(b, a))
        found = solved(its, freedom(b, p), motion.acceleration)
        load_station(b, motion, path, its, part, found, p, a)
        _load_tilt(b, motion, path, its, part, found, p, a)
        keep(found, 0, 4, b, p, a)
        keep_bound(its, 4, b, p, a)
        torque += part.torque - its.spin * found.push
        inertia += part.inertia - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**MERGED)
def begin(time: float, step: float, tilting: bool, p: Any, a: Any) -> tuple[Motion, Any, Any]:
    """The rotor without its balls, the torque on it and its inertia."""
    motion = alone_at_nodes(time, step, tilting, p, a)
    if p.shakes.shape[0] + p.bearings.springs.shape[0] > 0:
        motion = acted_at_nodes(time, step, motion, p, a)
    return motion, motion.torque, all_lanes(p.polar_inertia)


@njit(**MERGED)
def finish(motion: Motion, torque: Any, inertia: Any, p: Any, a: Any) -> None:
    """All accelerations, once the balls gave their stations what they give."""
    if p.rigid.bound[0] > 0:
        its_torque, its_inertia = bind_at_nodes(motion, p, a)
        torque += its_torque
        inertia += its_inertia
    set_rate_of_rotor(motion.speed, p, a)
    acceleration = together_at_nodes(motion.acceleration, torque, inertia, p, a)
    write_forces(motion.speed, acceleration, p, a)
    recover_at_nodes(acceleration, p, a)


@njit(**MERGED)
def freedom(b: int, p: Any) -> float:
    """One over the inertia of a ball; 0 where rigid contacts hold it."""
    return 0.0 if p.guided[b].bound != 0 else 1.0 / p.balls[b].inertia


@njit(**MERGED)
def keep_bound(its: Row, each: int, b: int, p: Any, a: Any) -> None:
    """Keep the row of a ball whose row belongs to a cluster."""
    if p.guided[b].bound != 0:
        keep(its, OWN, each, b, p, a)
        store(all_lanes(p.balls[b].inertia), data(a.numbers), kept_at(b, p) + WEIGHT * NODES)


@njit(**MERGED)
def rate_at_nodes(b: int, a: Any) -> Any:
    """The speed of a ball in the rotor."""
    return load(data(a.values), (2 * a.modes + 2 + a.balls + b) * NODES)


@njit(**MERGED)
def _flat(b: int, motion: Motion, p: Any, a: Any) -> tuple[Path, Row, Share]:
    """Path, row and share of a ball on a race that does not tilt."""
    ball, rate = p.balls[b], rate_at_nodes(b, a)
    s, c = sine_cosine_of_lanes(load(data(a.values), (2 * a.modes + 2 + b) * NODES))
    nx, ny = motion.cosine * c - motion.sine * s, motion.sine * c + motion.cosine * s
    ex = motion.cosine * ball.center_x - motion.sine * ball.center_y
    ey = motion.sine * ball.center_x + motion.cosine * ball.center_y
    path = circle(ball.orbit, ex, ey, nx, ny)
    known = known_acceleration(path, motion.speed, rate)
    set_rate(1 + b, ball.viscous * path.length * path.length / ball.inertia, a)
    its = row(ball, path, motion, rate, rate * (ball.viscous * path.length), 0.0)
    return path, its, share(ball, path, motion, known, rate)


@njit(**MERGED)
def _slope(station: int, p: Any, a: Any) -> Slope:
    size, at, rows, numbers = p.host.size, (4 * station + 2) * p.host.width, data(p.host.rows), data(a.numbers)
    q, v = ROOM + Q * NODES * size, ROOM + V * NODES * size
    return Slope(
        times(rows, at, numbers, q, size), times(rows, at + p.host.width, numbers, q, size),
        times(rows, at, numbers, v, size), times(rows, at + p.host.width, numbers, v, size), p.host.axial_gravity,
    )  # fmt: skip


@njit(**MERGED)
def load_station(b: int, motion: Motion, path: Path, its: Row, part: Share, found: Row, p: Any, a: Any) -> None:
    """Force on the station, what w' adds to it and to the torque, the inertia that the station feels."""
    numbers, each, mass = data(a.numbers), p.work.inert.shape[1], p.balls[b].mass
    push, arm, turn, inert = station_places(p)
    at = p.balls[b].station * each * NODES
    add(part.x - motion.acceleration * part.arm_x - its.x * found.push, numbers, push + at)
    add(part.y - motion.acceleration * part.arm_y - its.y * found.push, numbers, push + at + NODES)
    if p.drive.kind != PRESCRIBED:
        add(part.arm_x - its.x * found.spin, numbers, arm + at)
        add(part.arm_y - its.y * found.spin, numbers, arm + at + NODES)
        add(part.arm_x - its.spin * found.x, numbers, turn + at)
        add(part.arm_y - its.spin * found.y, numbers, turn + at + NODES)
    inert += at * each
    line = each * NODES
    add(mass - its.x * found.x, numbers, inert)
    add(-its.x * found.y, numbers, inert + NODES)
    add(-its.y * found.x, numbers, inert + line)
    add(mass - its.y * found.y, numbers, inert + line + NODES)


@njit(**MERGED)
def _load_tilt(b: int, motion: Motion, path: Path, its: Row, part: Share, found: Row, p: Any, a: Any) -> None:
    """What the slope of the station adds."""
    numbers, mass = data(a.numbers), p.balls[b].mass
    push, arm, turn, inert = station_places(p)
    at = (4 * p.balls[b].station + 2) * NODES
    add(part.u - motion.acceleration * part.arm_u - its.u * found.push, numbers, push + at)
    add(part.v - motion.acceleration * part.arm_v - its.v * found.push, numbers, push + at + NODES)
    if p.drive.kind != PRESCRIBED:
        add(part.arm_u - its.u * found.spin, numbers, arm + at)
        add(part.arm_v - its.v * found.spin, numbers, arm + at + NODES)
        add(part.arm_u - its.spin * found.u, numbers, turn + at)
        add(part.arm_v - its.spin * found.v, numbers, turn + at + NODES)
    i = inert + 16 * p.balls[b].station * NODES
    add(-its.x * found.u, numbers, i + 2 * NODES)
    add(-its.x * found.v, numbers, i + 3 * NODES)
    add(-its.y * found.u, numbers, i + 6 * NODES)
    add(-its.y * found.v, numbers, i + 7 * NODES)
    add(-its.u * found.x, numbers, i + 8 * NODES)
    add(-its.u * found.y, numbers, i + 9 * NODES)
    add(path.x * path.x * mass - its.u * found.u, numbers, i + 10 * NODES)
    add(path.x * path.y * mass - its.u * found.v, numbers, i + 11 * NODES)
    add(-its.v * found.x, numbers, i + 12 * NODES)
    add(-its.v * found.y, numbers, i + 13 * NODES)
    add(path.x * path.y * mass - its.v * found.u, numbers, i + 14 * NODES)
    add(path.y * path.y * mass - its.v * found.v, numbers, i + 15 * NODES)


@njit(**MERGED)
def recover_at_nodes(acceleration: Any, p: Any, a: Any) -> None:
    """Accelerations of the balls from those of their stations."""
    for b in range(a.balls):
        store(rate_of_rows(b, acceleration, p, a), data(a.forces), (2 * a.modes + 1 + b) * NODES)
