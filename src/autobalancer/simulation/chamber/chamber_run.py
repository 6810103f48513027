"""Run a machine with deep chambers."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, TypedDict, Unpack

import numpy as np
import xarray as xr
from scipy.linalg import eigvalsh

from autobalancer.assembly.chamber_assembly import assemble_chamber, contact_time
from autobalancer.assembly.contact import restitution_at
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.chamber.chamber_records import (
    ACCOUNT,
    CHANGED,
    DESCRIBED,
    LOST_BALLS,
    MOTION,
    PROFILE,
    SAMPLE,
    THETA,
    TOO_DENSE,
    Chamber,
    Samples,
)
from autobalancer.kernels.fields import Rows
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import bare_numbers
from autobalancer.progress import interrupts_noted, raise_noted, shows_progress
from autobalancer.results.answers.answer import Form, provenance
from autobalancer.results.answers.run import Run
from autobalancer.results.labels import label
from autobalancer.results.verdict import Verdict
from autobalancer.simulation.chamber.bounds import chamber_critical_speeds, fill, highest_speed, linear_body
from autobalancer.simulation.chamber.chamber_verdict import chamber_verdict
from autobalancer.units import to_si

STEPS_IN_CONTACT = 25  # at least, of the default step in the shortest contact
LEAST_IN_CONTACT = 8  # of the longest step allowed
CHUNK = 250  # samples

Checkpoint = dict[str, Any]


class ChunkOptions(TypedDict, total=False):
    """How a long run is handed on in parts, and goes on.

    Parameters
    ----------
    resume
        A checkpoint that ``on_chunk`` received: the run continues from it, identical to the last bit. Seed and filling are
        ignored; step, sample and method must be those of that run.
    on_chunk
        Called after every ``chunk`` samples with the new part of the result, and the checkpoint at its end.
    keep
        Whether to return all samples. If false, memory use stays constant and the last part is returned.
    chunk
        Samples of a part.
    """

    resume: Checkpoint | None
    on_chunk: Callable[[xr.Dataset, Checkpoint], Any] | None
    keep: bool
    chunk: int


WHOLE: ChunkOptions = {"resume": None, "on_chunk": None, "keep": True, "chunk": CHUNK}
MOST = 100_000_000  # samples
FAST = 4.0  # m/s, of an impact at which restitution that depends on the speed decides about the step
LEAST_LEFT = 0.3  # restitution below which the step is not shortened further for it: little is left of the speed


@shows_progress
def simulate_chamber(
    machine: ChamberMachine,
    *,
    duration: float | str | None = None,
    step: float | str | None = None,
    sample: float | str = 1e-3,
    method: Literal["verlet", "runge_kutta"] = "verlet",
    seed: int = 0,
    settle: bool = True,
    hold_balls: bool = False,
    progress: Callable[[float, float], Any] | None = None,
    keep_on_interrupt: bool = False,
    **options: Unpack[ChunkOptions],
) -> xr.Dataset:
    """Run a machine whose balls move freely in its chambers.

    Parameters
    ----------
    machine
        The machine.
    duration
        s, or a text with a unit; by default ``run.duration`` of the machine. A resumed run continues up to this time.
    step
        Time step, s; by default 1/25 of the shortest contact at 4 m/s, less for a
        restitution below 0.5. It is shortened so that samples coincide with steps.
    sample
        Time between samples, s.
    method
        ``verlet``, or the fixed-step ``runge_kutta`` of fourth order of Pakuła (2021), appendix 1, for comparison.
    seed
        For the small disorder in the filling.
    settle
        Whether filled balls come to rest before the run.
    hold_balls
        Run the same machine without balancing: its balls are masses in the middles of their chambers, about whose rest position
        it moves. The result has no balls, and by default steps that suit the motions of the body.
    progress
        Called with time and duration, several times in a second; first with zero while the balls settle.
    keep_on_interrupt
        Whether Ctrl-C ends the run with what was computed; otherwise it is raised.
    **options
        How it is handed on and goes on, see :class:`ChunkOptions`.

    Returns
    -------
    xarray.Dataset
        Dimensions ``time``, ``ball``, ``axis`` (x along the rotor, y, z) and ``bearing``; see the page on the deep chamber.

    Raises
    ------
    QuestionError
        For a step too long for the contacts, a sample shorter than the step, or no duration.
    MachineError
        If the balls do not fit, or given ones overlap.
    """
    end = _duration(machine, duration)
    interval = float(to_si(sample, "s"))
    if not interval > 0.0:
        raise QuestionError(f"sample: given {interval:g} s; must be greater than zero")
    one_of("method", method, "verlet", "runge_kutta")
    if method == "runge_kutta" and machine.contact.law == "history":
        raise QuestionError("method: contacts with memory need 'verlet'")
    shortest = contact_time(machine)
    if step is None:
        h = _step_of_body(machine) if hold_balls else default_step(machine)
    else:
        h = _step(step, shortest)
    # whole steps between samples
    every = max(math.ceil(interval / h * (1.0 - 1e-9)), 1)
    h = interval / every
    attributes = {
        "step": h,
        "seed": seed,
        "method": method,
        "sample": interval,
        "contact_time": shortest,
        "critical_speeds": list(chamber_critical_speeds(machine)[0]),
        **({"remarks": list(odd)} if (odd := bare_numbers(machine)) else {}),
        **({"balls_held": 1} if hold_balls else {}),
    }
    samples = round(end / interval)
    if samples > MOST:
        raise QuestionError(
            f"sample: given {interval:g} s, which makes {samples:.3g} samples; at most {MOST:.3g} are possible"
        )

    def told(done: int) -> None:
        if progress is not None:
            progress(done * interval, end)

    chunks: dict[str, Any] = {**WHOLE, **options}
    if unknown := chunks.keys() - WHOLE.keys():
        raise TypeError(f"simulate_chamber() got an unexpected keyword argument {min(unknown)!r}")
    chunk, resume = chunks["chunk"], chunks["resume"]
    if resume is not None:
        march = restore(machine, h, every, resume)
    else:
        march = begin(machine, h, every, method, seed, settle, lambda: told(0), hold_balls=hold_balls)
    # pieces by number, of which each may be written away before the next one is made
    parts: list[xr.Dataset] = []
    waiting = [march.first()] if resume is None else []
    kept = march.samples
    name, text = "finished", f"reached {end:.6g} s"
    with interrupts_noted(keep=keep_on_interrupt):
        try:
            while march.samples < samples:
                part = march.take(min(chunk - march.samples % chunk, samples - march.samples), told)
                if march.interrupted and not part.sizes["time"]:
                    raise KeyboardInterrupt
                if waiting:
                    part = joined([waiting.pop(), part])
                now = march.samples * interval
                if chunks["on_chunk"] is not None:
                    about = (machine, attributes, "running", f"reached {now:.6g} s of {end:.6g} s", end)
                    chunks["on_chunk"](labeled(part, *about), march.checkpoint())
                parts = [*parts, part] if chunks["keep"] else [part]
                kept = march.samples
                if march.interrupted:
                    raise KeyboardInterrupt
                if march.failure:
                    name, text = march.failure
                    break
        except KeyboardInterrupt:
            if not keep_on_interrupt:
                raise
            text = f"interrupted at {kept * interval:.6g} s of {end:.6g} s; what was computed is kept"
            name = "interrupted"
        return labeled(
            joined([*waiting, *parts]) if waiting or parts else march.first(), machine, attributes, name, text, end
        )


def _duration(machine: ChamberMachine, duration: float | str | None) -> float:
    if duration is None:
        if machine.run is None:
            raise QuestionError("duration: not given, and the machine has no run.duration; give one of them")
        return float(machine.run.duration)
    end = float(to_si(duration, "s"))
    if end < 0.0:
        raise QuestionError(f"duration: given {end:g} s; must not be negative")
    return end


def default_step(machine: ChamberMachine) -> float:
    """A twenty-fifth of the shortest contact at 4 m/s, less for a restitution below a half, s."""
    # the error of the rebound speed goes with the jump of the force at the turning point, and with the step squared
    left = float(machine.contact.restitution)
    if machine.contact.rebound is not None:
        left = max(LEAST_LEFT, float(restitution_at((machine.contact.rebound, left, 0.0), np.array([FAST]))[0]))
    jump = math.sqrt(left**-2 - 1.0)
    return contact_time(machine) / max(STEPS_IN_CONTACT, 15.0 * jump)


def _step_of_body(machine: ChamberMachine) -> float:
    """A two-hundredth of the fastest motion of the body with its balls held, s: an error of its phase of 4e-5."""
    free, m, _, k, _ = linear_body(machine)
    fastest = math.sqrt(max(eigvalsh(k, m).max(), 0.0)) if len(free) else 0.0
    turning = 2.0 * highest_speed(machine)  # of a thin disc that precesses
    return 2.0 * math.pi / (200.0 * max(fastest, turning, 1.0))


def _step(step: float | str, shortest: float) -> float:
    h = float(to_si(step, "s"))
    longest = shortest / LEAST_IN_CONTACT
    if not 0.0 < h <= longest * (1.0 + 1e-9):
        raise QuestionError(
            f"step: given {h:g} s; the shortest contact lasts {shortest:.3g} s (at 4 m/s), so it must be greater than zero "
            f"and at most {longest:.3g} s. Shorten it, or make the contact softer"
        )
    return h


# A run in progress: its numbers, its first energy, and the next samples.


Array = Any
AT_ONCE = 0.1  # s of computing, after which Ctrl-C and other threads get their turn
OF_A_BALL = 30e-9  # s that its step takes, about


class March:
    """Takes a machine's balls from sample to sample."""

    def __init__(self, machine: ChamberMachine, chamber: Chamber, every: int, method: str, energy: float) -> None:
        self.machine, self.chamber, self.every, self.method = machine, chamber, every, method
        self.first_energy = energy
        self.failure: tuple[str, str] | None = None
        self.interrupted = False

    @property
    def samples(self) -> int:
        """Samples passed since time 0, not counting that one."""
        return int(self.chamber.progress.steps) // self.every

    def first(self) -> xr.Dataset:
        """The sample of the state as it is, with reactions of this instant."""
        return self._labeled(self.samples, sample_now(self.chamber), 1)

    def take(self, count: int, passed: Callable[[int], Any] | None = None) -> xr.Dataset:
        """The next ``count`` samples; fewer if the motion grew without limit, which ``failure`` then says, or ``interrupted``.

        ``passed`` is called with the samples since time 0 several times in a second. If it raises ``KeyboardInterrupt``, or
        Ctrl-C does, what was computed is answered.
        """
        done = self.samples
        samples = room_for(self.chamber, count, self.every)
        at_once = max(round(AT_ONCE / (self.every * max(len(self.chamber.balls), 1) * OF_A_BALL)), 1)
        try:
            for first in range(0, count, at_once):
                some = slice(first, first + at_once)
                raise_noted()
                _advance(self.method, self.chamber, Samples(self.every, samples.rows[some], samples.balls[some]))
                if self.chamber.progress.trouble:
                    break
                if passed is not None:
                    passed(self.samples)
        except KeyboardInterrupt:
            self.interrupted = True
        got = self.samples - done
        finite = _finite(samples)[:got]
        trouble = self.chamber.progress.trouble
        if trouble == TOO_DENSE:
            self.failure = (
                "too dense",
                "more balls came close to each other than is possible; the contacts are too soft",
            )
        if trouble == LOST_BALLS or not finite.all():
            got = got if finite.all() else int(np.argmin(finite))
            self.failure = ("not finite", "the motion grew without limit; shorten the step, check masses and stiffness")
        return self._labeled(done + 1, samples, got)

    def checkpoint(self) -> dict[str, Array]:
        """Arrays from which the run goes on to the last bit."""
        return {
            **{name: np.asarray(value).copy() for name, value in _chamber_attributes(self.chamber).items()},
            "first_energy": np.array(self.first_energy),
            "every": np.array(self.every),
            "method": np.array(self.method),
        }

    def _labeled(self, start: int, samples: Samples, count: int) -> xr.Dataset:
        times = (start + np.arange(count)) * self.every * self.chamber.run.step
        return chamber_dataset(
            self.machine, self.chamber, times, samples.rows[:count], samples.balls[:count], self.first_energy
        )


def _finite(samples: Samples) -> Array:
    """Whether all numbers of a sample are, (k,)."""
    finite = np.ones(len(samples.rows), bool)
    for rows in (samples.rows, samples.balls):
        for name in rows.dtype.names:
            finite &= np.isfinite(rows[name].reshape(len(finite), -1)).all(axis=1)
    return finite


def begin(
    machine: ChamberMachine,
    step: float,
    every: int,
    method: str,
    seed: int,
    settle: bool,
    waiting: Callable[[], Any] | None = None,
    *,
    hold_balls: bool = False,
) -> March:
    """A run at time 0; ``waiting`` is called again and again while the balls settle."""
    from autobalancer.kernels.chamber.time_steps import start

    positions, filled = (np.zeros((0, 3)), False) if hold_balls else fill(machine, seed)
    if filled and settle:
        positions = settled(machine, positions, step, waiting)
    chamber = assemble_chamber(machine, positions, step)
    start(chamber)
    return March(machine, chamber, every, method, total_energy(chamber))


def restore(machine: ChamberMachine, step: float, every: int, held: dict[str, Array]) -> March:
    """The run of a checkpoint.

    Raises
    ------
    QuestionError
        If it is of another machine, step, sample or method.
    """
    total = held["balls"].size if "balls" in held else 0
    chamber = assemble_chamber(machine, np.zeros((total, 3)), step)
    requested = _chamber_attributes(chamber)
    if missing := (set(requested) | {"first_energy", "every", "method"}) - set(held):
        raise QuestionError(
            f"resume: not a checkpoint of a chamber run of this version; it lacks {', '.join(sorted(missing))}"
        )
    same = all((held[name].dtype, held[name].shape) == (one.dtype, one.shape) for name, one in requested.items())
    if not same or any(held[name].size != 1 for name in ("first_energy", "every", "method")):
        raise QuestionError(
            "resume: the checkpoint is damaged or belongs to another machine; resume it with its own machine file"
        )
    before = float(held["run"]["step"])
    if int(held["every"]) != every or before != step:
        raise QuestionError(
            f"resume: the checkpoint has steps of {before:.17g} s, {int(held['every'])} to a sample; "
            f"asked for {step:.17g} s, {every} to a sample. Give the step and sample of that run"
        )
    if not all(np.array_equal(held[name], np.asarray(requested[name])) for name in DESCRIBED):
        raise QuestionError("resume: the checkpoint belongs to another machine; resume it with its own machine file")
    for name, value in requested.items():
        _fill(value, held[name])
    return March(machine, chamber, every, str(held["method"]), float(held["first_energy"]))


def _chamber_attributes(chamber: Chamber) -> dict[str, Any]:
    """What describes a run and what it changes, by name."""
    kept = {name: getattr(chamber, name) for name in DESCRIBED + CHANGED if name != "pairs"}
    return kept | {f"pairs_{name}": value for name, value in chamber.pairs._asdict().items()}


def _fill(target: Any, source: Array) -> None:
    if target.shape == ():
        for name in target.dtype.names:
            target[name] = source[name]
    else:
        target[...] = source


def _advance(method: str, chamber: Chamber, samples: Samples) -> None:
    if method == "runge_kutta":
        from autobalancer.kernels.chamber.time_steps import runge_kutta

        runge_kutta(chamber, samples)
        return
    from autobalancer.kernels.chamber.time_steps import verlet

    verlet(chamber, samples, 1.0)


# Filled balls come to rest on the bottom before the machine starts (Pakuła 2021, appendix 3).


DECAY = 40.0  # 1/s: at which velocities of the balls fade, the same for light and heavy ones
FADE = 1e-3  # s: how often they are made to
SOFT, LONGEST = 1e-2, 2.0  # stiffness, over the real one, with which they fall, and how long that may last at most, s
HARD = 0.3  # s: the last part, with the real stiffness, lasts no longer
SLOW = 3e-3  # m/s: faster than this a ball is not at rest; slower ones creep, as friction that always slides lets them
LOOK = 0.02  # s


def settled(machine: ChamberMachine, positions: Array, step: float, waiting: Callable[[], Any] | None = None) -> Array:
    """Positions (n, 3) in the chambers after the balls have fallen and calmed down, with the rotor held.

    They fall with softer contacts, which allow longer steps. ``waiting`` is called every 20 ms of that time.
    """
    fallen = _fall(machine, positions, step * SOFT**-0.4, SOFT, LONGEST, waiting)
    return _fall(machine, fallen, step, 1.0, HARD, waiting)


def _fall(
    machine: ChamberMachine,
    positions: Array,
    step: float,
    soft: float,
    longest: float,
    waiting: Callable[[], Any] | None,
) -> Array:
    from autobalancer.kernels.chamber.time_steps import start, verlet

    chamber = assemble_chamber(machine, positions, step)._replace(profile=PROFILE.rows(1))
    balls = chamber.balls
    for stiffness in (balls.race_stiffness, balls.flat_stiffness, balls.inner_stiffness, chamber.pair_stiffness):
        stiffness *= soft
    balls.velocity, balls.spin = 0.0, 0.0
    chamber.machine.driven, chamber.machine.free[0], chamber.body.rate[THETA] = 0, -1, 0.0
    start(chamber)
    every = max(round(FADE / step), 1)
    fading = float(np.exp(-DECAY * every * step))
    samples = room_for(chamber, round(LOOK / FADE), every)
    quiet = 0
    for _ in range(max(round(longest / LOOK), 1)):
        verlet(chamber, samples, fading)
        if waiting is not None:
            waiting()
        quiet = quiet + 1 if float(np.abs(samples.balls.velocity[-1]).max()) < SLOW else 0
        if quiet == 2:
            break
    return np.array(samples.balls.position[-1])


# From raw samples to a labelled result.


DIMENSIONS = ((), ("time",), ("time", "axis"), ("time", "bearing", "axis"))  # by their number
SAVED_FIELDS = [field.name for field in SAMPLE.fields if field.name not in ("body_rate", "tilting")]
LOSSES = [field.name for field in ACCOUNT.fields if field.name.startswith("loss_")]


def chamber_dataset(
    machine: ChamberMachine, chamber: Chamber, times: Array, samples: Rows, balls: Rows, energy: float
) -> xr.Dataset:
    """Samples as ``verlet`` keeps them as a dataset; ``energy`` is that at time 0."""
    kinetic, potential = energies(chamber, samples, balls)
    total = kinetic + potential + samples.energy_contact
    lost = sum(samples[name] for name in LOSSES)
    data: dict[str, Any] = {name: (DIMENSIONS[samples[name].ndim], samples[name]) for name in SAVED_FIELDS}
    data |= {f"ball_{name}": (("time", "ball", "axis"), balls[name]) for name in balls.dtype.names}
    data |= {
        "energy_kinetic": ("time", kinetic),
        "energy_potential": ("time", potential),
        "energy_error": ("time", total - energy - samples.work_motor + lost),
    }
    if chamber.contact.cylinders:
        data["tilting"] = ("time", samples.tilting)
    coordinates: dict[str, Any] = {
        "time": times,
        "ball": np.arange(1, chamber.balls.shape[0] + 1),
        "axis": np.array(["x", "y", "z"], dtype=object),
        "bearing": np.array([1, 2]),
        "ball_radius": ("ball", chamber.balls.radius.copy()),
        "ball_mass": ("ball", chamber.balls.mass.copy()),
        "chamber": ("ball", chamber.balls.chamber + 1),
    }
    if chamber.contact.cylinders:
        coordinates["ball_length"] = ("ball", 2.0 * chamber.balls.half_length)
    return label(xr.Dataset({key: (dims, np.array(value)) for key, (dims, value) in data.items()}, coordinates))


def joined(parts: list[xr.Dataset]) -> xr.Dataset:
    """Parts of a run one after the other."""
    if len(parts) == 1:
        return parts[0]
    return xr.concat(parts, "time", data_vars="minimal", coords="minimal", compat="override", join="override")


def labeled(
    run: xr.Dataset, machine: ChamberMachine, attributes: dict[str, Any], outcome: str, text: str, duration: float
) -> xr.Dataset:
    """The dataset with attributes that say what it is."""
    about = run.assign_attrs(
        title=f"Run of {machine.name}",
        **provenance(),
        machine=machine_text(machine),
        machine_name=machine.name,
        **attributes,
        outcome=outcome,
        outcome_text=text,
        duration=duration,
    )
    return ChamberRun.of(about)


# A run of deep chambers as what a person asks first.


class ChamberRun(Run):
    """A run of balls that move freely in deep chambers."""

    __slots__ = ()
    shown_as = Form()
    times = ("time",)

    def verdict(self) -> Verdict:
        """The verdict on it."""
        return chamber_verdict(self)

    def _balls(self) -> str:
        if not self.sizes["ball"]:
            return "held in the middles of their chambers"
        chambers = np.unique(self["chamber"].values).size
        return f"{self.sizes['ball']} in {chambers} deep chamber{'s' * (chambers > 1)}"


# Energy of balls, body and rotor in sampled states.


def energies(chamber: Chamber, samples: Rows, balls: Rows) -> tuple[Array, Array]:
    """Kinetic and potential energy without that in contacts, (times,) each, of samples as ``verlet`` keeps them, J."""
    p = chamber.machine
    q, v = np.hstack([samples.body_position, samples.body_rotation]), samples.body_rate
    theta, w = samples.rotor_angle, samples.speed
    along, up = _turned(p.unbalance, theta)
    couple_c, couple_s = _turned(p.couple, theta)
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, p.inertia, v) + 0.5 * p.polar_inertia * w**2
    kinetic += v[:, 0] * (v[:, 4] * up - v[:, 5] * along + w * (q[:, 4] * along + q[:, 5] * up))
    kinetic += w * (along * v[:, 2] - up * v[:, 1] - couple_c * v[:, 4] - couple_s * v[:, 5])
    mass, inertia, gravity = chamber.balls.mass, chamber.balls.inertia, p.gravity
    kinetic += 0.5 * np.einsum("i,tij->t", mass, balls.velocity**2)
    kinetic += 0.5 * np.einsum("i,tij->t", inertia, balls.spin**2)
    potential = 0.5 * np.einsum("ti,ij,tj->t", q, p.stiffness, q)
    potential -= gravity[1] * along + gravity[2] * up + gravity[0] * (q[:, 4] * up - q[:, 5] * along)
    potential -= np.einsum("i,tij,j->t", mass, places(chamber, samples, balls), gravity)
    return kinetic, potential


def _turned(vector: Array, theta: Array) -> tuple[Array, Array]:
    c, s = np.cos(theta), np.sin(theta)
    return vector[0] * c - vector[1] * s, vector[0] * s + vector[1] * c


def places(chamber: Chamber, samples: Rows, balls: Rows) -> Array:
    """Places of the balls in space, (times, n, 3), m."""
    turn = np.tile(np.eye(3), (len(samples), 1, 1))
    a, b, c = samples.body_rotation.T
    turn[:, 0, 1], turn[:, 0, 2], turn[:, 1, 0] = c, -b, -c
    turn[:, 1, 2], turn[:, 2, 0], turn[:, 2, 1] = a, b, -a
    own = balls.position.copy()
    own[:, :, 0] += chamber.rooms.center[chamber.balls.chamber]
    return np.linalg.solve(turn[:, None], own[..., None])[..., 0] + samples.body_position[:, None]


def total_energy(chamber: Chamber) -> float:
    """Energy of the state as it is, with that in contacts, J."""
    samples = sample_now(chamber)
    kinetic, potential = energies(chamber, samples.rows, samples.balls)
    return float(kinetic[0] + potential[0] + chamber.power.stored)


# Room for samples, and the sample of an instant.


def room_for(chamber: Chamber, count: int, every: int) -> Samples:
    """Room for ``count`` samples, each after ``every`` steps."""
    return Samples(every, SAMPLE.rows(count), MOTION.rows(count, chamber.balls.shape[0]))


def sample_now(chamber: Chamber) -> Samples:
    """The sample of the state as it is, with reactions of this instant."""
    from autobalancer.kernels.chamber.time_steps import note_sample

    since = chamber.since.copy()
    for name in ("bearing_1", "bearing_2", "constraint"):
        since[name] = chamber.body[name]
    samples = room_for(chamber, 1, 1)
    note_sample(chamber._replace(since=since), 1.0, samples.rows[0], samples.balls[0])
    return samples
