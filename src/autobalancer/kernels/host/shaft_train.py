"""Speed, torque and unbalance at an instant, from the segment in force."""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.compiler.flags import EQUATIONS_PART, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import deref
from autobalancer.kernels.records import HILL, MOUNT, PRESCRIBED
from autobalancer.kernels.system import SPEED, THETA, Drive, system_at
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def drive_value(time: float, drive: Drive) -> tuple[float, float]:
    """The drive's profile (speed or torque) and its rate of change."""
    segment = drive.segments[drive.now[0]]
    if segment.kind == HILL:
        begin, exponent = segment.begin, segment.exponent
        if time <= 0.0:
            return begin, 0.0
        ratio = (time / segment.half_time) ** exponent
        rise = ratio / (1.0 + ratio)
        return begin + (segment.end - begin) * rise, (segment.end - begin) * rise * exponent / (time * (1.0 + ratio))
    return segment.value + (time - segment.start) * segment.rate, segment.rate


@njit(**INLINE)
def unbalance_value(time: float, drive: Drive) -> tuple[float, float]:
    """The resultant unbalance (Ux, Uy) in the rotor, kg m."""
    segment = drive.segments[drive.now[0]]
    s = time - segment.start
    return segment.unbalance_x + s * segment.unbalance_rate_x, segment.unbalance_y + s * segment.unbalance_rate_y


@njit(**INLINE)
def table_torque(speed: float, drive: Drive) -> float:
    """Torque from the table over speed, held constant outside it; 0 without a table."""
    table = drive.table
    count = table.shape[0]
    if count == 0:
        return 0.0
    if speed <= table[0, 0]:
        return table[0, 1]
    for i in range(1, count):
        if speed <= table[i, 0]:
            part = (speed - table[i - 1, 0]) / (table[i, 0] - table[i - 1, 0])
            return table[i - 1, 1] + part * (table[i, 1] - table[i - 1, 1])
    return table[count - 1, 1]


@njit(**INLINE)
def motor_torque(drive_value: float, speed: float, drive: Drive) -> float:
    """Torque of the motor at a speed against its stator: profile, table, formula of Kloss, less what brakes it."""
    torque = drive_value + table_torque(speed, drive) - drive.damping * speed
    if drive.breakdown_torque != 0.0:
        slip, width = drive.synchronous_speed - speed, drive.breakdown_slip
        torque += 2.0 * drive.breakdown_torque * slip * width / (width * width + slip * slip)
    return torque


@njit(**INLINE)
def enter_segment(time: float, drive: Drive) -> bool:
    """Go on to the segment of this time, if that is a later one; returns whether it is."""
    later = False
    while drive.now[0] + 1 < drive.segments.shape[0] and drive.segments[drive.now[0] + 1].start <= time:
        drive.now[0] += 1
        later = True
    return later


@njit(**INLINE)
def next_corner(end: float, drive: Drive) -> float:
    """When the segment in force ends, or ``end`` if that is earlier: forces have a jump or a kink there."""
    following = drive.now[0] + 1
    if following < drive.segments.shape[0]:
        return min(end, drive.segments[following].start)
    return end


# Elastic links between rotor and motor: couplings, and the mount of the motor's stator.
#
# From the rotor (theta_0, w_0) to the motor (theta_n, w_n), with the twist d_i = theta_i - theta_(i-1) as coordinate,
#
#     M_i = k_i (d_i - e_i) + c_i (d_i - e_i)',    e_i = a_i cos(n_i theta_(i-1) + p_i),
#     J_i w_i' = - M_i + (1 + e_(i+1)') M_(i+1),   and the rotor feels (1 + e_1') M_1,
#
# with e' = de/dtheta: what follows from the energies with an error e of the twist. The motor adds its torque at the
# end, which depends on its speed against the stator, and the stator bears it: J w' = - T - k a - c w.


@njit(**EQUATIONS_PART)
def turn_links(time: float, y: Any, dy: Any, system: Any) -> float:
    """Write the rates of all links; returns the torque on the rotor, N m."""
    drive = deref(system_at(system)).drive
    count = drive.links.shape[0]
    mounted = count > 0 and drive.links[count - 1].kind == MOUNT
    couplings = count - 1 if mounted else count
    value, rate = drive_value(time, drive)
    angle, speed = y[THETA], y[SPEED]
    # from the rotor to the motor: each link twists by the difference of its ends
    on_rotor, before = 0.0, -1  # the state of the part before, whose acceleration is not complete yet
    for i in range(couplings):
        link = drive.links[i]
        at = link.state
        next_speed = y[at + 1]
        free, slope = y[at], 0.0
        if link.error != 0.0:
            s, c = sine_cosine(link.order * angle + link.phase)
            free -= link.error * c
            slope = -link.error * link.order * s
        torque = link.stiffness * free + link.damping * (next_speed - (1.0 + slope) * speed)
        if before < 0:
            on_rotor = (1.0 + slope) * torque
        else:
            dy[before + 1] += (1.0 + slope) * torque / drive.links[i - 1].inertia
        dy[at] = next_speed - speed
        if link.inertia > 0.0:
            dy[at + 1] = -torque / link.inertia
        else:
            dy[at + 1] = rate
        angle, speed, before = angle + y[at], next_speed, at
    # the motor turns against its stator, which may be mounted softly
    if drive.motor == PRESCRIBED:
        return on_rotor
    if mounted:
        at = drive.links[couplings].state
        angle -= y[at]
        speed -= y[at + 1]
    torque = motor_torque(value, speed, drive)
    for i in range(drive.ripples.shape[0]):
        ripple = drive.ripples[i]
        torque += ripple.torque * sine_cosine(ripple.order * angle + ripple.phase)[1]
    if before < 0:
        on_rotor = torque
    else:
        dy[before + 1] += torque / drive.links[couplings - 1].inertia
    if mounted:
        stator = drive.links[couplings]
        at = stator.state
        dy[at] = y[at + 1]
        dy[at + 1] = -(torque + stator.stiffness * y[at] + stator.damping * y[at + 1]) / stator.inertia
    return on_rotor
