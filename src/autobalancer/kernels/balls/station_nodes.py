"""The equations of :mod:`autobalancer.kernels.balls.on_stations` at all nodes of a long step, for balls that touch nothing."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.contact_nodes import (
    LENGTH,
    NORMAL,
    OWN,
    WEIGHT,
    add,
    bind_at_nodes,
    contacts_until,
    keep,
    kept_at,
    push_left,
    rate_of_rows,
    rest_at_nodes,
    station_places,
)
from autobalancer.kernels.balls.guided import (
    Normal,
    Path,
    Row,
    Share,
    Slope,
    circle,
    known_acceleration,
    normal,
    on_circle,
    row,
    rubbed,
    rubbing_arm,
    share,
    solved,
    steady_inertia,
    tilting_row,
    tilting_share,
    wavy,
)
from autobalancer.kernels.balls.planar_nodes import set_rate_of_rotor
from autobalancer.kernels.compiler.flags import ADDRESSED, EQUATIONS, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import NODES, all_lanes, lane, load, store
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.linear_nodes import (
    ROOM,
    Q,
    V,
    external_forces_at_nodes,
    solve_coupled_at_nodes,
    solve_free_at_nodes,
    times,
    write_forces,
)
from autobalancer.kernels.integrators.collocation import amplitudes_at, set_rate
from autobalancer.kernels.laws.curves import drag_force, table_value
from autobalancer.kernels.records import NONE, PRESCRIBED
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes


@njit(**EQUATIONS)
def station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """Balls that feel the deflection of their station."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    motion, torque, inertia = begin(time, step, False, p, a)
    for b in range(a.balls):
        path, its, part = _flat(b, motion, p, a)
        found = solved(its, freedom(b, p), motion.acceleration)
        load_station(b, motion, path, its, part, found, p, a)
        keep(found, 0, 2, b, p, a)
        keep_bound(its, 2, b, p, a)
        torque += part.torque - its.spin * found.push
        inertia += part.inertia + steady_inertia(p.balls[b]) - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**EQUATIONS)
def tilting_station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """The same where balls feel the tilt of their race too."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
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
        inertia += part.inertia + steady_inertia(ball) - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**MERGED)
def begin(time: float, step: float, tilting: bool, p: Any, a: Any) -> tuple[Motion, Any, Any]:
    """The rotor without its balls, the torque on it and its inertia."""
    motion = solve_free_at_nodes(time, step, tilting, p, a)
    if p.shakes.shape[0] + p.bearings.springs.shape[0] > 0:
        motion = external_forces_at_nodes(time, step, motion, p, a)
    return motion, motion.torque, all_lanes(p.polar_inertia)


@njit(**MERGED)
def finish(motion: Motion, torque: Any, inertia: Any, p: Any, a: Any) -> None:
    """All accelerations, once the balls gave their stations what they give."""
    if p.rigid.bound[0] > 0:
        its_torque, its_inertia = bind_at_nodes(motion, p, a)
        torque += its_torque
        inertia += its_inertia
    set_rate_of_rotor(motion.speed, p, a)
    acceleration = solve_coupled_at_nodes(motion.acceleration, torque, inertia, p, a)
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
    set_rate(1 + b, ball.drag / ball.inertia, a)
    its, part = on_circle(ball, ex, ey, nx, ny, motion, rate, 0.0, True)
    return path, its, part


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


# The equations of :mod:`autobalancer.kernels.balls.on_stations` at all nodes of a long step, for balls that touch
# nothing.
#
# Every ball rolls the way it rolled at the begin, or rests; :func:`open_and_rolling` says how far this holds.


@njit(**EQUATIONS)
def rough_station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """Balls that feel the deflection of their station, with friction, any drag and any path."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    motion, torque, inertia = begin(time, step, False, p, a)
    for b in range(a.balls):
        # the path at the nodes, with its waves
        ball, moving, rate = p.balls[b], p.guided[b], rate_at_nodes(b, a)
        s, c = sine_cosine_of_lanes(load(data(a.values), (2 * a.modes + 2 + b) * NODES))
        radius, first, second = _orbit(p.waves, ball, c, s)
        nx, ny = motion.cosine * c - motion.sine * s, motion.sine * c + motion.cosine * s
        ex = motion.cosine * ball.center_x - motion.sine * ball.center_y
        ey = motion.sine * ball.center_x + motion.cosine * ball.center_y
        path = wavy(radius, first, second, ex, ey, nx, ny)
        # row, share and normal force; friction with the sign of the known part of the force
        known = known_acceleration(path, motion.speed, rate)
        drag = _drag(time, step, path.length, rate, b, p, a)
        its = row(ball, path, motion, rate, drag, 0.0)
        part = share(ball, path, motion, known, rate)
        force = normal(ball.mass, path, motion, known, 0.0)
        felt = rubbed(its, force, rubbing_arm(ball, path, moving.mode, force.push))
        # a ball at rest, or one in a cluster, has no phi'' of its own
        inverse = 1.0 / (path.length * path.length * ball.stretch)
        if moving.mode == 0.0 or moving.bound != 0:
            inverse = all_lanes(0.0)
        found = solved(felt, inverse, motion.acceleration)
        load_station(b, motion, path, its, part, found, p, a)
        keep(found, 0, 2, b, p, a)
        _keep(b, path.length, its, force, p, a)
        # how fast drag lets a difference of speed die out, at the end of the step, for the iteration
        slope = lane(drag, NODES - 1) / (lane(path.length, NODES - 1) * lane(rate, NODES - 1) * ball.stretch)
        set_rate(1 + b, slope if moving.mode != 0.0 else 0.0, a)
        torque += part.torque - its.spin * found.push
        inertia += part.inertia - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**MERGED)
def _orbit(waves: Any, ball: Any, c: Any, s: Any) -> tuple[Any, Any, Any]:
    """Radius and its first two derivatives, as in balls/guided.py."""
    radius, first, second = all_lanes(ball.orbit), all_lanes(0.0), all_lanes(0.0)
    cosine, sine = c, s
    for h in range(1, ball.waves + 1):
        wave = waves[ball.first_wave + h - 1]
        along, across = cosine * wave.cosine + sine * wave.sine, cosine * wave.sine - sine * wave.cosine
        radius += along
        first += across * h
        second -= along * (h * h)
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    return radius, first, second


@njit(**MERGED)
def _drag(time: float, step: float, length: Any, rate: Any, b: int, p: Any, a: Any) -> Any:
    """Drag force on a ball, N."""
    ball, work, nodes = p.balls[b], data(a.work), data(a.radau.nodes)
    lag = all_lanes(0.0)
    if ball.lag_table != NONE:
        for i in range(NODES):
            work[i] = table_value(p.fluid, ball.lag_table, time + nodes[i] * step)
        lag = load(work, 0)
    through = length * (rate + lag)
    if ball.drag_curve == NONE:
        return through * ball.viscous
    store(through, work, 0)
    for i in range(NODES):
        work[NODES + i] = drag_force(p.fluid, ball.drag_curve, ball.viscous, work[i])
    return load(work, NODES)


@njit(**MERGED)
def _keep(b: int, length: Any, its: Row, force: Normal, p: Any, a: Any) -> None:
    kept, place = data(a.numbers), kept_at(b, p)
    keep(its, OWN, 2, b, p, a)
    store(length * length * p.balls[b].stretch, kept, place + WEIGHT * NODES)
    store(length, kept, place + LENGTH * NODES)
    store(force.push, kept, place + NORMAL * NODES)
    store(force.twist, kept, place + (NORMAL + 1) * NODES)
    store(force.x, kept, place + (NORMAL + 2) * NODES)
    store(force.y, kept, place + (NORMAL + 3) * NODES)


@njit(**ADDRESSED)
def open_and_rolling(step: float, system: Any, amplitudes: Any) -> float:
    """As of other balls, and the fraction up to which no ball stops, turns round or breaks loose."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    until = contacts_until(rest_at_nodes, step, p, a)
    values, work, nodes, kept = data(a.values), data(a.work), data(a.radau.nodes), data(a.numbers)
    for b in range(a.balls):
        ball, mode, start = p.balls[b], p.guided[b].mode, a.origin[BALLS + a.balls + b]
        if ball.rolling > 0.0 or ball.adherence > 0.0:
            # normal force and what must hold the ball, from its rows and the accelerations at the nodes
            place = kept_at(b, p)
            store(push_left(NORMAL, 2, b, p, a), work, 0)
            store(push_left(OWN, 2, b, p, a), work, NODES)
            if mode * start < 0.0 or (mode == 0.0 and start != 0.0):
                until = 0.0
            # up to the first node where it neither rests nor rolls as it was taken to
            for i in range(NODES):
                force, known = work[i], kept[place + NORMAL * NODES + i]
                pressed = max(force, -ball.pulls * force)
                rests = (
                    mode == 0.0 and abs(work[NODES + i]) <= ball.adherence * kept[place + LENGTH * NODES + i] * pressed
                )
                rate = values[(2 * a.modes + 2 + a.balls + b) * NODES + i]
                rolls = mode * rate > 0.0 and (force > 0.0) == (known > 0.0) and (force > 0.0) == (work[0] > 0.0)
                if not (rests or rolls):
                    until = min(until, nodes[i - 1] if i > 0 else 0.0)
                    break
    return until
