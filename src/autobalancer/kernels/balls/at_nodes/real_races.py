"""The equations of :mod:`autobalancer.kernels.balls.rough_races` at all nodes of a long step, for balls that touch nothing.

Every ball rolls the way it rolled at the begin, or rests; :func:`open_and_rolling` says how far this holds.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.at_nodes.clusters import rest_at_nodes
from autobalancer.kernels.balls.at_nodes.contacts import contacts_until
from autobalancer.kernels.balls.at_nodes.rows import LENGTH, NORMAL, OWN, WEIGHT, keep, kept_at, left
from autobalancer.kernels.balls.at_nodes.stations import begin, finish, load_station, rate_at_nodes
from autobalancer.kernels.balls.guided import (
    Normal,
    Row,
    known_acceleration,
    normal,
    row,
    rubbed,
    rubbing_arm,
    share,
    solved,
    wavy,
)
from autobalancer.kernels.flags import ADDRESSED, EQUATIONS, MERGED, njit
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes_at
from autobalancer.kernels.integrators.collocation.rates import set_rate
from autobalancer.kernels.laws.curves import drag_force, table_value
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.system import BALLS, system_at
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes
from autobalancer.kernels.wide import NODES, all_lanes, lane, load, store


@njit(**EQUATIONS)
def rough_station_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """Balls that feel the deflection of their station, with friction, any drag and any path."""
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    motion, torque, inertia = begin(time, step, False, p, a)
    for b in range(a.balls):
        ball, moving, rate = p.balls[b], p.guided[b], rate_at_nodes(b, a)
        s, c = sine_cosine_of_lanes(load(data(a.values), (2 * a.modes + 2 + b) * NODES))
        radius, first, second = _orbit(p.waves, ball, c, s)
        nx, ny = motion.cosine * c - motion.sine * s, motion.sine * c + motion.cosine * s
        ex = motion.cosine * ball.center_x - motion.sine * ball.center_y
        ey = motion.sine * ball.center_x + motion.cosine * ball.center_y
        path = wavy(radius, first, second, ex, ey, nx, ny)
        known = known_acceleration(path, motion.speed, rate)
        drag = _drag(time, step, path.length, rate, b, p, a)
        its = row(ball, path, motion, rate, drag, 0.0)
        part = share(ball, path, motion, known, rate)
        force = normal(ball.mass, path, motion, known, 0.0)
        felt = rubbed(its, force, rubbing_arm(ball, path, moving.mode, force.push))
        inverse = 1.0 / (path.length * path.length * ball.stretch)
        if moving.mode == 0.0 or moving.bound != 0:
            inverse = all_lanes(0.0)
        found = solved(felt, inverse, motion.acceleration)
        load_station(b, motion, path, its, part, found, p, a)
        keep(found, 0, 2, b, p, a)
        _keep(b, path.length, its, force, p, a)
        slope = lane(drag, NODES - 1) / (lane(path.length, NODES - 1) * lane(rate, NODES - 1) * ball.stretch)
        set_rate(1 + b, slope if moving.mode != 0.0 else 0.0, a)
        torque += part.torque - its.spin * found.push
        inertia += part.inertia - its.spin * found.spin
    finish(motion, torque, inertia, p, a)


@njit(**MERGED)
def _orbit(waves: Any, ball: Any, c: Any, s: Any) -> tuple[Any, Any, Any]:
    """Radius and its first two derivatives, as in balls/path.py."""
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
    p, a = behind(system_at(system)), behind(amplitudes_at(amplitudes))
    until = contacts_until(rest_at_nodes, step, p, a)
    values, work, nodes, kept = data(a.values), data(a.work), data(a.radau.nodes), data(a.numbers)
    for b in range(a.balls):
        ball, mode, start = p.balls[b], p.guided[b].mode, a.origin[BALLS + a.balls + b]
        if ball.rolling > 0.0 or ball.adherence > 0.0:
            place = kept_at(b, p)
            store(left(NORMAL, 2, b, p, a), work, 0)
            store(left(OWN, 2, b, p, a), work, NODES)
            if mode * start < 0.0 or (mode == 0.0 and start != 0.0):
                until = 0.0
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
