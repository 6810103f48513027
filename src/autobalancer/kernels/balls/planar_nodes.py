"""The equations of :mod:`autobalancer.kernels.balls.planar` at all nodes of a long step at once, as forces on the rotor's modes.

For an isotropic planar rotor in axes that turn with it. With zeta = x + i y and nu = x' + i y' in space, the modes of the
bare rotor are p+ and p-, zeta = p+ + p-, with the exponents mu = -delta +- i w_d. A is the acceleration of the race center
from the same elimination of the balls as there, F = A + k/M zeta + b/M nu all that is not the bare rotor, and

    p+-' = (mu+- - i w0) p+- + N+-,    N+- = -i (w - w0) p+- +- F/(2 i w_d)

where w0 is the frozen speed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from autobalancer.kernels.balls.guided import Row, left_over, on_circle, scaled
from autobalancer.kernels.balls.planar import Rows, accelerations, eliminated, with_ball
from autobalancer.kernels.balls.rigid_torques import leads
from autobalancer.kernels.compiler.flags import EQUATIONS, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import NODES, all_lanes, lane, load, store
from autobalancer.kernels.host.linear import Motion
from autobalancer.kernels.host.shaft_train import drive_value, table_torque
from autobalancer.kernels.integrators.collocation import FROZEN, amplitudes_at, follow, set_rate
from autobalancer.kernels.records import HILL, PRESCRIBED
from autobalancer.kernels.system import system_at
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes

STIFFNESS, DAMPING, DECAY, FREQUENCY = range(4)  # places in Amplitudes.numbers: k/M, b/M, delta, w_d
# a ball keeps two rows of four numbers in its work space: its own one, and from SOLVED on that solved for phi''
SOLVED, EACH = 4 * NODES, 8 * NODES


@njit(**MERGED)
def drive_at_nodes(time: float, step: float, p: Any, a: Any) -> tuple[Any, Any]:
    """The drive's profile and its rate of change at the nodes."""
    nodes, work = data(a.radau.nodes), data(a.work)
    segment = p.drive.segments[p.drive.now[0]]
    if segment.kind == HILL:
        for i in range(NODES):
            work[i], work[NODES + i] = drive_value(time + nodes[i] * step, p.drive)
    else:
        value = segment.value + (time - segment.start) * segment.rate
        store(load(nodes, 0) * (step * segment.rate) + value, work, 0)
        store(all_lanes(segment.rate), work, NODES)
    return load(work, 0), load(work, NODES)


@njit(**MERGED)
def torque_at_nodes(profile: Any, speed: Any, p: Any, a: Any) -> Any:
    """Torque of the motor at the nodes, as kernels/host/shaft_train.py has it."""
    drive, work = p.drive, data(a.work)
    torque = profile - speed * drive.damping
    if drive.table.shape[0] > 0:
        store(speed, work, 0)
        for i in range(NODES):
            work[NODES + i] = table_torque(work[i], drive)
        torque += load(work, NODES)
    if drive.breakdown_torque != 0.0:
        slip, width = drive.synchronous_speed - speed, drive.breakdown_slip
        torque += slip * (2.0 * drive.breakdown_torque * width) / (slip * slip + width * width)
    return torque


@njit(**MERGED)
def set_rate_of_rotor(speed: Any, p: Any, a: Any) -> None:
    """How fast the motor lets a difference of speed die out, but for a table."""
    drive, slope = p.drive, 0.0
    if drive.kind != PRESCRIBED:
        slope = drive.damping
        if drive.breakdown_torque != 0.0:
            slip, width = drive.synchronous_speed - lane(speed, NODES - 1), drive.breakdown_slip
            square, wide = slip * slip, width * width
            slope += 2.0 * drive.breakdown_torque * width * (wide - square) / ((wide + square) * (wide + square))
    set_rate(0, slope / p.polar_inertia, a)


@njit(**MERGED)
def unbalance_at_nodes(time: float, step: float, p: Any, a: Any) -> tuple[Any, Any]:
    """The resultant unbalance in the rotor at the nodes, kg m."""
    segment = p.drive.segments[p.drive.now[0]]
    since = load(data(a.radau.nodes), 0) * step + (time - segment.start)
    ux = since * segment.unbalance_rate_x + segment.unbalance_x
    return ux, since * segment.unbalance_rate_y + segment.unbalance_y


@njit(**MERGED)
def motion_at_nodes(time: float, step: float, p: Any, a: Any) -> Motion:
    """The motion of the rotor at the nodes, as :func:`autobalancer.kernels.host.linear.motion_of` has it at an instant."""
    values, rank = data(a.values), 2 * a.modes
    profile, profile_rate = drive_at_nodes(time, step, p, a)
    speed, acceleration = load(values, rank * NODES), all_lanes(0.0)
    free = p.drive.kind != PRESCRIBED
    if not free:
        speed, acceleration = profile, profile_rate
    # gravity turns in the axes of the rotor
    gx, gy = all_lanes(p.gravity_x), all_lanes(p.gravity_y)
    turn_sin, turn_cos = all_lanes(0.0), all_lanes(1.0)
    if p.rotating != 1:
        turn_sin, turn_cos = sine_cosine_of_lanes(load(values, (rank + 1) * NODES))
    elif p.gravity_x != 0.0 or p.gravity_y != 0.0:
        s, c = sine_cosine_of_lanes(load(values, (rank + 1) * NODES))
        gx, gy = c * p.gravity_x + s * p.gravity_y, c * p.gravity_y - s * p.gravity_x
    torque = all_lanes(0.0)
    if free:
        ux, uy = unbalance_at_nodes(time, step, p, a)
        torque = (turn_cos * ux - turn_sin * uy) * gy - (turn_sin * ux + turn_cos * uy) * gx
        torque += torque_at_nodes(profile, speed, p, a)
    return Motion(speed, acceleration, turn_sin, turn_cos, gx, gy, torque)


class Host(NamedTuple):
    """The race center at the nodes, from both modes."""

    forward_x: Any  # m, mode that turns with the rotor
    forward_y: Any
    backward_x: Any
    backward_y: Any
    bare_x: Any  # m/s^2, acceleration by spring and damper, which is among the modes already
    bare_y: Any


@njit(**MERGED)
def _host(a: Any) -> Host:
    values, numbers = data(a.values), data(a.numbers)
    forward_x, forward_y = load(values, 0), load(values, NODES)
    backward_x, backward_y = load(values, 2 * NODES), load(values, 3 * NODES)
    # deflection zeta and velocity nu of the race center
    zeta_x, zeta_y = forward_x + backward_x, forward_y + backward_y
    delta, frequency = numbers[DECAY], numbers[FREQUENCY]
    nu_x = (backward_y - forward_y) * frequency - zeta_x * delta
    nu_y = (forward_x - backward_x) * frequency - zeta_y * delta
    bare_x = zeta_x * numbers[STIFFNESS] + nu_x * numbers[DAMPING]
    bare_y = zeta_y * numbers[STIFFNESS] + nu_y * numbers[DAMPING]
    return Host(forward_x, forward_y, backward_x, backward_y, bare_x, bare_y)


@njit(**MERGED)
def load_row(work: Any, place: int) -> Row:
    """A row of a ball that was kept."""
    push, spin = load(work, place), load(work, place + NODES)
    return Row(push, spin, load(work, place + 2 * NODES), load(work, place + 3 * NODES), 0.0, 0.0)


@njit(**MERGED)
def _keep_row(its: Row, work: Any, place: int) -> None:
    store(its.push, work, place)
    store(its.spin, work, place + NODES)
    store(its.x, work, place + 2 * NODES)
    store(its.y, work, place + 3 * NODES)


@njit(**MERGED)
def _row_of_cluster(head: int, p: Any, a: Any) -> tuple[Row, float, float, int]:
    """Row of the balls that touch, as of one ball; one over their inertia, how fast they relax (1/s), the last of them."""
    work, whole, drag, last = data(a.balls_work), p.balls[head].inertia, p.balls[head].drag, head
    its = load_row(work, EACH * head)
    if p.guided[head].bound == 0:
        return its, 1.0 / whole, drag / whole, last
    held = p.ties[head].low != 0
    while p.ties[last].joined == 1:
        held, last = held or p.ties[last].high != 0, p.contacts[last].next
        more = load_row(work, EACH * last)
        its = Row(its.push + more.push, its.spin + more.spin, its.x + more.x, its.y + more.y, its.u, its.v)
        whole += p.balls[last].inertia
        drag += p.balls[last].drag
    # nothing moves what touches a partition
    inverse = 0.0 if held or p.ties[last].high != 0 else 1.0 / whole
    return its, inverse, drag * inverse, last


@njit(**EQUATIONS)
def planar_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """``forces`` from ``values`` of :mod:`autobalancer.kernels.integrators.collocation`."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    values, work, count, mass = data(a.values), data(a.balls_work), a.balls, p.planar.mass
    # the rotor by itself, in axes that turn with it
    motion, host = motion_at_nodes(time, step, p, a), _host(a)
    ux, uy = unbalance_at_nodes(time, step, p, a)
    square, zero = motion.speed * motion.speed, all_lanes(0.0)
    rows = Rows(
        all_lanes(mass), zero, all_lanes(mass), ux * square - host.bare_x * mass, uy * square - host.bare_y * mass,
        -uy, ux, all_lanes(p.polar_inertia), motion.torque,
    )  # fmt: skip
    # each ball: its row, and its share
    for i in range(count):
        ball, rate = p.balls[i], load(values, (6 + count + i) * NODES)
        s, c = sine_cosine_of_lanes(load(values, (6 + i) * NODES))
        its, part = on_circle(ball, ball.center_x, ball.center_y, c, s, motion, rate, 0.0, False)
        rows = with_ball(rows, part)
        _keep_row(its, work, EACH * i)
    # the row of each ball is put into those of race center and rotor; balls that touch are one ball with the sum of their rows
    for head in range(count):
        if p.guided[head].bound != 0 and not leads(p, head):
            continue
        its, inverse, decay, last = _row_of_cluster(head, p, a)
        found = scaled(its, inverse)
        rows = eliminated(rows, its, found)
        k, more = head, True
        while more:
            more = k != last
            _keep_row(found, work, EACH * k + SOLVED)
            set_rate(1 + k, decay, a)
            follow(1 + k, 1 + head, a)
            k = p.contacts[k].next
    # accelerations, and from them the forces on the modes and the balls
    set_rate_of_rotor(motion.speed, p, a)
    solution = accelerations(rows, motion.acceleration, p.drive.kind != PRESCRIBED)
    ax, ay = solution.ax - solution.bx * solution.rotor, solution.ay - solution.by * solution.rotor
    store(ax, work, EACH * count)
    store(ay, work, EACH * count + NODES)
    _write_forces(host, motion.speed, ax, ay, solution.rotor, a)


@njit(**MERGED)
def _write_forces(host: Host, speed: Any, ax: Any, ay: Any, acceleration: Any, a: Any) -> None:
    """Forces on the modes, without what the modes do by themselves; then the accelerations of rotor and balls."""
    forces, work = data(a.forces), data(a.balls_work)
    half, ahead = 0.5 / data(a.numbers)[FREQUENCY], speed - a.held[FROZEN]
    drawn_x, drawn_y = (ax + host.bare_x) * half, (ay + host.bare_y) * half
    store(ahead * host.forward_y + drawn_y, forces, 0)
    store(-(ahead * host.forward_x + drawn_x), forces, NODES)
    store(ahead * host.backward_y - drawn_y, forces, 2 * NODES)
    store(drawn_x - ahead * host.backward_x, forces, 3 * NODES)
    store(acceleration, forces, 4 * NODES)
    for i in range(a.balls):
        store(left_over(load_row(work, EACH * i + SOLVED), ax, ay, acceleration), forces, (5 + i) * NODES)
