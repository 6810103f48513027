"""Names, units and meanings of all numbers of a chamber. Axes: x along the rotor, y, z across it; in space if not said else.

Whole numbers that count, choose or name something have no unit.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import types

from autobalancer.kernels.fields import Field, Record, Row, Rows

BLOCK = 32  # contacts that are evaluated at once
WALLS = 4  # of a chamber: race, the flat ones at +x and at -x, the inner one
WHOLE = np.int64

# coordinates: displacement of the rotor's middle, small rotations of the body about x, y, z, angle of the rotor
X, Y, Z, TURN_X, TURN_Y, TURN_Z, THETA = range(7)
COORDINATES = 7
RIGHT = 7  # column of the right-hand side in the equations of the body

RUN = Record(
    Field("step", "s", "time from one evaluation to the next"),
    Field("margin", "m", "how far beyond contact pairs are listed"),
)

CONTACT = Record(
    Field("has_memory", "", "1: Hertz, damping and a tangential spring; 0: the law of restitution", (), WHOLE),
    Field("friction", "1", "force of friction over the normal force, of a ball on a wall"),
    Field("ball_friction", "1", "the same of a ball on a ball"),
    Field("restitution_squared", "1", "part of the elastic force that is left in separation"),
    Field("rolling_arm", "m", "rolling moment over the normal force"),
    Field("slow", "m/s", "below this velocity friction and rolling resistance are in proportion to it"),
    Field("damping_ratio", "1", "damping over sqrt(mass stiffness) d^(1/4)"),
    Field("shear_ratio", "1", "tangential over normal stiffness"),
    Field("varies", "", "1: restitution depends on the speed of an impact, by tables; 0: it is constant", (), WHOLE),
    Field("cylinders", "", "1: all balls are cylinders, which stay parallel to the rotor; 0: none is", (), WHOLE),
)

MACHINE = Record(
    Field("gravity", "m/s^2", "along x, y, z", (3,)),
    Field("inertia", "kg, kg m^2", "of body and rotor, for displacement and rotation of the rotor's middle", (6, 6)),
    Field("stiffness", "N/m, N m/rad", "of the supports, likewise", (6, 6)),
    Field("damping", "N s/m, N m s/rad", "of the supports, likewise", (6, 6)),
    Field("free", "", "coordinates 0 to 5 that can move, then -1", (7,), WHOLE),
    Field("rotor_mass", "kg", "of the rotor"),
    Field("polar_inertia", "kg m^2", "of the rotor about its axis"),
    Field("transverse_inertia", "kg m^2", "of the rotor across its axis"),
    Field("bearings", "m", "places of both bearings along x, from the rotor's middle", (2,)),
    Field("neck", "m", "friction torque of the bearings over the sum of their forces"),
    Field("rotor_damping", "N m s/rad", "torque between rotor and body over their relative speed"),
    Field("unbalance", "kg m", "along y and z at rotor angle 0", (2,)),
    Field("couple", "kg m^2", "moment of the unbalance along x, along y and z at rotor angle 0", (2,)),
    Field("driven", "", "1: by a motor; 0: the speed is prescribed", (), WHOLE),
    Field("rated_torque", "N m", "of the motor"),
    Field("overload", "1", "breakdown torque over rated torque"),
    Field("synchronous_speed", "rad/s", "of the motor"),
    Field("breakdown_speed", "rad/s", "where the motor has its greatest torque"),
)

ROOM = Record(
    Field("center", "m", "place of the chamber's middle along the rotor"),
    Field("wall_radius", "m", "of the race"),
    Field("half_depth", "m", "half the distance of its flat walls"),
    Field("drag", "N s/m", "force on a ball over its velocity relative to the chamber"),
    Field("square_drag", "N s^2/m^2", "force over the square of this velocity"),
    Field("inner_radius", "m", "of the inner wall, minus infinity without one"),
)

PROFILE = Record(
    Field("time", "s", "of a corner of the prescribed speed"),
    Field("speed", "rad/s", "there"),
)

BALL = Record(  # what the search for contacts reads comes first; the walls of a cylinder have a stiffness in N/m
    Field("radius", "m", "of the ball"),
    Field("position", "m", "of its middle", (3,)),
    Field("velocity", "m/s", "of its middle", (3,)),
    Field("spin", "rad/s", "rate of rotation", (3,)),
    Field("mass", "kg", "of the ball"),
    Field("inertia", "kg m^2", "about its middle"),
    Field("kind", "", "row and column of its group in the table of pair stiffness", (), WHOLE),
    Field("chamber", "", "number of its chamber", (), WHOLE),
    Field("inverse_mass", "1/kg", "one over the mass"),
    Field("inverse_inertia", "1/(kg m^2)", "one over the inertia"),
    Field("force", "N", "of the last evaluation", (3,)),
    Field("moment", "N m", "of the last evaluation, about the middle", (3,)),
    Field("acceleration", "m/s^2", "of the last step", (3,)),
    Field("spin_rate", "rad/s^2", "of the last step", (3,)),
    Field("race_stiffness", "N/m^1.5", "k of k d^1.5 at the race"),
    Field("flat_stiffness", "N/m^1.5", "at a flat wall"),
    Field("touches", "", "sum of 1 at the race, 2 at the wall at +x, 4 at that at -x, 8 at the inner wall", (), WHOLE),
    Field("inner_stiffness", "N/m^1.5", "at the inner wall"),
    Field("half_length", "m", "half the length of a cylinder; 0 of a ball"),
    Field("tilting", "N m", "moment about y and z that would tilt a cylinder, sum since the last sample", (2,)),
    Field("holding", "N m", "moment that its contacts could bear, sum since the last sample"),
)

BODY = Record(
    Field("place", "m, rad", "displacement of the rotor's middle, rotation of the body, angle of the rotor", (7,)),
    Field("rate", "m/s, rad/s", "rate of the place", (7,)),
    Field("acceleration", "m/s^2, rad/s^2", "second rate of the place in the last step", (7,)),
    Field("new_acceleration", "m/s^2, rad/s^2", "second rate of the last evaluation", (7,)),
    Field("bearing_1", "N", "force of the first bearing on the rotor", (3,)),
    Field("bearing_2", "N", "force of the second bearing, which also guides along x", (3,)),
    Field("constraint", "N, N m", "force and moment about the rotor's middle that hold locked coordinates", (6,)),
    Field("torque", "N m", "of the drive on the rotor"),
    Field("bearing_torque", "N m", "of the rotor against the bearings"),
    Field("contact_force", "N", "of all balls", (3,)),
    Field("contact_moment", "N m", "of all balls about the axis of the rotor, about y, about z", (3,)),
)

POWER = Record(
    Field("motor", "W", "work of the drive"),
    Field("contact", "W", "lost in impacts"),
    Field("friction", "W", "lost by friction"),
    Field("rolling", "W", "lost by rolling resistance"),
    Field("supports", "W", "lost in the supports"),
    Field("bearings", "W", "lost in the bearings"),
    Field("drag", "W", "lost in the fluid"),
    Field("stored", "J", "energy in the contacts now"),
)

ACCOUNT = Record(
    Field("work_motor", "J", "of the drive since time 0"),
    Field("loss_contact", "J", "in impacts since time 0"),
    Field("loss_friction", "J", "by friction"),
    Field("loss_rolling", "J", "by rolling resistance"),
    Field("loss_supports", "J", "in the supports"),
    Field("loss_bearings", "J", "in the bearings"),
    Field("loss_drag", "J", "in the fluid"),
)

SINCE = Record(  # the last sample
    Field("bearing_1", "N", "sum over the steps of the force of the first bearing", (3,)),
    Field("bearing_2", "N", "the same of the second bearing", (3,)),
    Field("constraint", "N, N m", "the same of the constraint", (6,)),
    Field("greatest_force", "N", "greatest normal force of a contact"),
    Field("contacts_ball", "", "contacts between balls that began", (), WHOLE),
    Field("contacts_wall", "", "contacts with walls that began", (), WHOLE),
    Field("impact_speeds", "m/s", "sum of the speeds at which all of them began"),
    Field("impact_energies", "J", "sum of the energies of approach with which all of them began"),
)

TOO_DENSE, LOST_BALLS = 1, 2
PROGRESS = Record(
    Field("steps", "", "done since time 0", (), WHOLE),
    Field("pairs", "", "near pairs that are listed", (), WHOLE),
    Field("piece", "", "of the profile that is passed now", (), WHOLE),
    Field("rebuilds", "", "how often the pairs were listed", (), WHOLE),
    Field("trouble", "", "1: more pairs than there is room for, 2: balls far outside", (), WHOLE),
    Field("way", "m", "of the fastest ball since the pairs were listed"),
)

MOTION = Record(
    Field("position", "m", "of a ball; in a sample from the middle of its chamber, in the axes of the body", (3,)),
    Field("velocity", "m/s", "of its middle", (3,)),
    Field("spin", "rad/s", "rate of rotation", (3,)),
)

BODY_MOTION = Record(
    Field("place", "m, rad", "as that of the body", (7,)),
    Field("rate", "m/s, rad/s", "as that of the body", (7,)),
)

SAMPLE = Record(  # where a run has a variable of this name, it is this number
    Field("rotor_angle", "rad", "of the rotor in space"),
    Field("speed", "rad/s", "of the rotor"),
    Field("body_position", "m", "displacement of the rotor's middle", (3,)),
    Field("body_rotation", "rad", "of the body about x, y, z", (3,)),
    Field("body_rate", "m/s, rad/s", "rates of position and rotation", (6,)),
    Field("bearing_force", "N", "of both bearings on the rotor, mean since the sample before", (2, 3)),
    Field("constraint_force", "N", "what holds locked coordinates, mean since the sample before", (3,)),
    Field("constraint_moment", "N m", "the same about the rotor's middle", (3,)),
    Field("motor_torque", "N m", "of the drive on the rotor"),
    Field("energy_contact", "J", "in the contacts"),
    *ACCOUNT.fields,
    Field("contacts_ball", "", "contacts between balls that began since the sample before", (), WHOLE),
    Field("contacts_wall", "", "contacts with walls that began since then", (), WHOLE),
    Field("greatest_contact_force", "N", "greatest normal force since then"),
    Field("impact_speeds", "m/s", "sum of the speeds at which these contacts began"),
    Field("impact_energies", "J", "sum of the energies of approach with which they began"),
    Field("tilting", "1", "greatest moment that would tilt a cylinder over what its contacts could bear, since then"),
)

# contacts side by side, so that vector registers take several of them
CONTACTS = Record(
    Field("line", "m", "from the ball to its partner, of any length", (3, BLOCK)),
    Field("offset", "m", "overlap is offset + taken times the length of the line", (BLOCK,)),
    Field("taken", "1", "see offset", (BLOCK,)),
    Field("stiffness", "N/m^1.5", "of the contact", (BLOCK,)),
    Field("lightness", "1/kg", "sum of the inverse masses", (BLOCK,)),
    Field("roll_radius", "m", "of the smaller ball", (BLOCK,)),
    Field("shrink", "1/m", "by this times the overlap the arms are shorter than the radii", (BLOCK,)),
    Field("rate", "m/s", "velocity of the ball less that of its partner", (3, BLOCK)),
    Field("turn", "m/s", "sum of radius times spin", (3, BLOCK)),
    Field("roll", "rad/s", "spin of the ball less that of its partner", (3, BLOCK)),
    Field("stretch", "m", "of the tangential spring", (3, BLOCK)),
    Field("push", "N", "force on the ball", (3, BLOCK)),
    Field("twist", "N", "normal times friction: moment over the arm", (3, BLOCK)),
    Field("resist", "N m", "rolling moment on the ball", (3, BLOCK)),
    Field("arm", "1", "over the radius", (BLOCK,)),
    Field("lost", "W", "in the impact", (BLOCK,)),
    Field("slid", "W", "by friction", (BLOCK,)),
    Field("rolled", "W", "by rolling resistance", (BLOCK,)),
    Field("held", "J", "energy in the contact", (BLOCK,)),
    Field("normal", "N", "normal force", (BLOCK,)),
    Field("one", "", "number of the ball", (BLOCK,), WHOLE),
    Field("two", "", "of its partner, -1 for a wall", (BLOCK,), WHOLE),
    Field("place", "", "number of the pair or wall", (BLOCK,), WHOLE),
    Field("rebound", "", "where the table of the contact begins", (BLOCK,), WHOLE),
    Field("found", "1", "what the table says: restitution squared or damping ratio", (BLOCK,)),
)


# What a step takes: a chamber with its machine, and room for samples.


Array = Any


class Pairs(NamedTuple):
    """Balls that may touch; as many rows as there is room for pairs, of which the first ``progress.pairs`` count."""

    first: Array  # number of the ball with the lower number
    second: Array
    touching: Array  # 1 while they touch
    stretch: Array  # (., 3) of the tangential spring, m
    listed: Array  # (n, 3) where the balls were when the pairs were listed, from the middle of the rotor, m


class Search(NamedTuple):
    """Scratch of the search for pairs."""

    old_row: Array  # (n + 1,) where the partners of each ball begin in the next two
    old_second: Array
    old_stretch: Array
    cells: Array  # starts of the cells
    order: Array  # (n,) balls, cell by cell
    places: Array  # (n,) cell of each ball


class Scratch(NamedTuple):
    """What is written before it is read in every step."""

    search: Search
    contacts: Row  # CONTACTS
    equations: Array  # (7, 8) of the body: mass matrix, and the right-hand side in the last column
    reduced: Array  # (7, 8) those of its free coordinates
    begun: Rows  # (n,) MOTION of the balls at the start of a step
    gone: Rows  # (n,) sum of their slopes
    body_begun: Row  # BODY_MOTION likewise
    body_gone: Row


class Chamber(NamedTuple):
    """A machine with chambers: what describes it, what a run changes, and scratch."""

    run: Row  # RUN
    contact: Row  # CONTACT
    machine: Row  # MACHINE
    rooms: Rows  # ROOM of each chamber
    pair_stiffness: Array  # (kinds, kinds) N/m^1.5; of cylinders the reduced modulus, Pa
    rebounds: Array  # tables of restitution squared or damping ratio; may be empty
    pair_rebounds: Array  # (kinds, kinds + 1) where the table of a pair begins, in the last column that of the walls
    profile: Rows  # PROFILE
    balls: Rows  # BALL
    wall_stretch: Array  # (n, WALLS, 3) of the tangential springs at the walls, m
    pairs: Pairs
    body: Row  # BODY
    power: Row  # POWER of the last evaluation
    before: Row  # POWER of the last step
    account: Row  # ACCOUNT
    since: Row  # SINCE the last sample
    progress: Row  # PROGRESS
    scratch: Scratch


class Samples(NamedTuple):
    """Room for samples, each after ``every`` steps."""

    every: int
    rows: Rows  # (k,) SAMPLE
    balls: Rows  # (k, n) MOTION


DESCRIBED = Chamber._fields[:8]
CHANGED = Chamber._fields[8:17]

_matrix = types.float64[:, ::1]
_short = types.int32[::1]
_search = types.NamedTuple([_short, _short, _matrix, types.int64[::1], _short, _short], Search)
_scratch = types.NamedTuple(
    [
        _search, CONTACTS.row_type, _matrix, _matrix, MOTION.rows_type(), MOTION.rows_type(),
        BODY_MOTION.row_type, BODY_MOTION.row_type,
    ],
    Scratch,
)  # fmt: skip
CHAMBER = types.NamedTuple(
    [
        RUN.row_type, CONTACT.row_type, MACHINE.row_type, ROOM.rows_type(), _matrix,
        types.float64[::1], types.int64[:, ::1], PROFILE.rows_type(),
        BALL.rows_type(), types.float64[:, :, ::1],
        types.NamedTuple([_short, _short, types.int8[::1], _matrix, _matrix], Pairs),
        BODY.row_type, POWER.row_type, POWER.row_type, ACCOUNT.row_type, SINCE.row_type,
        PROGRESS.row_type, _scratch,
    ],
    Chamber,
)  # fmt: skip
SAMPLES = types.NamedTuple([types.int64, SAMPLE.rows_type(), MOTION.rows_type(2)], Samples)
