"""The equations of :mod:`autobalancer.kernels.balls.planar` at all nodes of a long step at once, as forces on the rotor's modes.

For an isotropic planar rotor in axes that turn with it. With zeta = x + i y and nu = x' + i y' in space, the modes of the
bare rotor are p+ and p-, zeta = p+ + p-, with the exponents mu = -delta +- i w_d. A is the acceleration of the race center
from the same elimination of the balls as there, F = A + k/M zeta + b/M nu all that is not the bare rotor, and

    p+-' = (mu+- - i w0) p+- + N+-,    N+- = -i (w - w0) p+- +- F/(2 i w_d)

where w0 is the frozen speed.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.balls.rigid_torques import leads
from autobalancer.kernels.compiler.cache import njit
from autobalancer.kernels.compiler.flags import EQUATIONS, MERGED
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.compiler.simd import NODES, all_lanes, lane, load, store
from autobalancer.kernels.host.shaft_train import drive_value, table_torque
from autobalancer.kernels.integrators.collocation import FROZEN, amplitudes_at, follow, set_rate
from autobalancer.kernels.records import HILL, PRESCRIBED
from autobalancer.kernels.system import system_at
from autobalancer.kernels.trigonometry import sine_cosine_of_lanes

STIFFNESS, DAMPING, DECAY, FREQUENCY = range(4)  # places in Amplitudes.numbers: k/M, b/M, delta, w_d
# rows of a ball in its work space: its own row, and phi'' = push - twist w' - share.A
ROW, SPIN, LEAN_X, LEAN_Y, PUSH, TWIST, SHARE_X, SHARE_Y = (NODES * i for i in range(8))
EACH = 8 * NODES


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


@njit(**EQUATIONS)
def planar_nodes(time: float, step: float, system: Any, amplitudes: Any) -> None:
    """``forces`` from ``values`` of :mod:`autobalancer.kernels.integrators.collocation`."""
    p, a = deref(system_at(system)), deref(amplitudes_at(amplitudes))
    values, forces, work, numbers, count = data(a.values), data(a.forces), data(a.balls_work), data(a.numbers), a.balls
    mass = p.planar.mass
    # deflection and velocity from both modes, and the force of the bare rotor, which is among the modes already
    forward_x, forward_y = load(values, 0), load(values, NODES)
    backward_x, backward_y = load(values, 2 * NODES), load(values, 3 * NODES)
    zeta_x, zeta_y = forward_x + backward_x, forward_y + backward_y
    delta, frequency = numbers[DECAY], numbers[FREQUENCY]
    nu_x = (backward_y - forward_y) * frequency - zeta_x * delta
    nu_y = (forward_x - backward_x) * frequency - zeta_y * delta
    bare_x = zeta_x * numbers[STIFFNESS] + nu_x * numbers[DAMPING]
    bare_y = zeta_y * numbers[STIFFNESS] + nu_y * numbers[DAMPING]

    # drive and unbalance; in axes that turn with the rotor nothing else depends on time
    profile, profile_rate = drive_at_nodes(time, step, p, a)
    speed = load(values, 4 * NODES)
    if p.drive.kind == PRESCRIBED:
        speed = profile
    segment = p.drive.segments[p.drive.now[0]]
    since = load(data(a.radau.nodes), 0) * step + (time - segment.start)
    ux = since * segment.unbalance_rate_x + segment.unbalance_x
    uy = since * segment.unbalance_rate_y + segment.unbalance_y
    square = speed * speed
    force_x, force_y = ux * square - bare_x * mass, uy * square - bare_y * mass
    arm_x, arm_y = -uy, ux
    mass_xx, mass_xy, mass_yy = all_lanes(mass), all_lanes(0.0), all_lanes(mass)
    inertia, torque = all_lanes(p.polar_inertia), all_lanes(0.0)
    # each ball: its row, and what it adds to those of the rotor
    for i in range(count):
        ball, place = p.balls[i], EACH * i
        s, c = sine_cosine_of_lanes(load(values, (6 + i) * NODES))
        ball_speed = load(values, (6 + count + i) * NODES)
        in_space = speed + ball_speed
        moment = ball.moment
        lean_x, lean_y = s * -moment, c * moment
        row = ball_speed * -ball.drag
        pull = in_space * in_space * moment
        force_x += pull * c
        force_y += pull * s
        arm_x += lean_x
        arm_y += lean_y
        spin = all_lanes(ball.spin)
        ec, es = ball.center_x, ball.center_y
        if ec != 0.0 or es != 0.0:
            along, across = (c * ec + s * es) * moment, (c * es - s * ec) * moment
            ex, ey = ball.mass * ec, ball.mass * es
            force_x += square * ex
            force_y += square * ey
            arm_x -= ey
            arm_y += ex
            row += across * square
            spin += along
            inertia += along * 2.0
            torque -= across * ball_speed * (in_space + speed)
        store(row, work, place + ROW)
        store(spin, work, place + SPIN)
        store(lean_x, work, place + LEAN_X)
        store(lean_y, work, place + LEAN_Y)
    # the row of each ball is put into those of host and rotor; balls that touch are one ball with the sum of their rows
    for head in range(count):
        bound, place = p.guided[head].bound != 0, EACH * head
        whole, drag = p.balls[head].inertia, p.balls[head].drag
        if bound and not leads(p, head):
            continue
        row, spin = load(work, place + ROW), load(work, place + SPIN)
        lean_x, lean_y = load(work, place + LEAN_X), load(work, place + LEAN_Y)
        inverse, last = 1.0 / whole, head
        if bound:
            held = p.ties[head].low != 0
            while p.ties[last].joined == 1:
                held, last = held or p.ties[last].high != 0, p.contacts[last].next
                place = EACH * last
                row += load(work, place + ROW)
                spin += load(work, place + SPIN)
                lean_x += load(work, place + LEAN_X)
                lean_y += load(work, place + LEAN_Y)
                whole += p.balls[last].inertia
                drag += p.balls[last].drag
            inverse = 0.0 if held or p.ties[last].high != 0 else 1.0 / whole  # nothing moves what touches a partition
        push, twist = row * inverse, spin * inverse
        share_x, share_y = lean_x * inverse, lean_y * inverse
        mass_xx -= lean_x * share_x
        mass_xy -= lean_x * share_y
        mass_yy -= lean_y * share_y
        force_x -= lean_x * push
        force_y -= lean_y * push
        arm_x -= lean_x * twist
        arm_y -= lean_y * twist
        inertia -= spin * twist
        torque -= spin * push
        k, more = head, True
        while more:
            place, more = EACH * k, k != last
            store(push, work, place + PUSH)
            store(twist, work, place + TWIST)
            store(share_x, work, place + SHARE_X)
            store(share_y, work, place + SHARE_Y)
            set_rate(1 + k, drag * inverse, a)
            follow(1 + k, 1 + head, a)
            k = p.contacts[k].next
    # A = a - b w', as in planar.py
    set_rate_of_rotor(speed, p, a)
    determinant = mass_xx * mass_yy - mass_xy * mass_xy
    inverse = 1.0 / determinant
    wx, wy = mass_yy * arm_x - mass_xy * arm_y, mass_xx * arm_y - mass_xy * arm_x
    ax, ay = (mass_yy * force_x - mass_xy * force_y) * inverse, (mass_xx * force_y - mass_xy * force_x) * inverse
    acceleration = profile_rate
    if p.drive.kind != PRESCRIBED:
        torque += torque_at_nodes(profile, speed, p, a)
        needed = torque * determinant - wx * force_x - wy * force_y
        acceleration = needed / (inertia * determinant - wx * arm_x - wy * arm_y)
    turn = acceleration * inverse
    ax -= wx * turn
    ay -= wy * turn

    store(ax, work, EACH * count)
    store(ay, work, EACH * count + NODES)

    # forces on the modes, without what the modes do by themselves; then the balls
    half = 0.5 / frequency
    drawn_x, drawn_y = (ax + bare_x) * half, (ay + bare_y) * half
    ahead = speed - a.held[FROZEN]
    store(ahead * forward_y + drawn_y, forces, 0)
    store(-(ahead * forward_x + drawn_x), forces, NODES)
    store(ahead * backward_y - drawn_y, forces, 2 * NODES)
    store(drawn_x - ahead * backward_x, forces, 3 * NODES)
    store(acceleration, forces, 4 * NODES)
    for i in range(count):
        place = EACH * i
        push, twist = load(work, place + PUSH), load(work, place + TWIST)
        share_x, share_y = load(work, place + SHARE_X), load(work, place + SHARE_Y)
        store(push - twist * acceleration - share_x * ax - share_y * ay, forces, (5 + i) * NODES)
