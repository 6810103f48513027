"""Questions that are asked alike of balls in races and of deep chambers: one function, whichever machine or run it is given."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack

from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import any_machine
from autobalancer.files.samples import beside
from autobalancer.files.text_files import question_data, read_toml
from autobalancer.machine import Machine
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine_kinds import RACES, arguments_of, machine_kind, refuse_unknown
from autobalancer.progress import Progress, in_notebook, looking_for
from autobalancer.simulation import RunOptions

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.results.answers.answer import Answer
    from autobalancer.results.verdict import Verdict
    from autobalancer.simulation.chamber.chamber_summary import ChamberSummary
    from autobalancer.simulation.record import Event, Sampling
    from autobalancer.stability.summary import Summary
    from autobalancer.studies.design.designs import Designed


AnyMachine = Machine | ChamberMachine | str | Path


class SimulateOptions(RunOptions, total=False):
    """What :func:`simulate` takes for one kind of machine or the other."""

    save: Sampling | Sequence[Sampling]  # balls in races
    events: Sequence[Event]
    frame: Literal["auto", "rotor", "space"]
    hold_balls: bool  # both
    mass_spread: float
    step: float | str | None  # deep chambers
    sample: float | str
    settle: bool
    resume: dict[str, Any] | None
    on_chunk: Callable[[xr.Dataset, dict[str, Any]], Any] | None
    keep: bool
    chunk: int


class CompareOptions(TypedDict, total=False):
    """What :func:`compare` takes: of machines all but the last, of a run and a measurement the last two."""

    at: Sequence[float | str] | float | str
    duration: float | str | None
    tolerance: float
    bins: int
    workers: int | None
    progress: Callable[[int, int], None] | None
    seed: int
    tacho: str


def simulate(
    machine: AnyMachine,
    *,
    duration: float | str | None = None,
    seed: int = 0,
    progress: Progress | Literal[False] | None = None,
    keep_on_interrupt: bool = False,
    **options: Unpack[SimulateOptions],
) -> xr.Dataset:
    """Run a machine in time.

    Parameters
    ----------
    machine
        A machine, with races or deep chambers, or the path of a machine file.
    duration
        Seconds, or a text such as ``"20 s"``; by default the ``run.duration`` of the machine.
    seed
        For the start positions of balls that have none in the machine, and for the filling of chambers.
    progress
        Called with (time, duration) a few times a second. ``None`` shows a bar where a person is looking, ``False`` none.
    keep_on_interrupt
        If true, Ctrl-C ends the run with the outcome ``interrupted`` and returns what was computed.
    **options
        Of balls in races: ``save``, ``events``, ``tolerance``, ``method``, ``frame``, ``hold_balls``, ``mass_spread``,
        ``max_steps``, see :func:`autobalancer.simulation.run.simulate_races` and
        :class:`~autobalancer.simulation.RunOptions`. Of deep chambers: ``step``, ``sample``, ``method``,
        ``settle``, ``hold_balls``, ``resume``, ``on_chunk``, ``keep``, ``chunk``, see
        :func:`autobalancer.simulation.chamber.chamber_run.simulate_chamber`.

    Returns
    -------
    xarray.Dataset
        See the pages on results and on the deep chamber; ``attrs["outcome"]`` says how the run ended.

    Raises
    ------
    MachineError
        If the machine cannot be run.
    QuestionError
        If an argument is not possible, or belongs to the other kind of machine.
    """
    described = any_machine(machine)
    common = {"duration": duration, "seed": seed, "progress": progress, "keep_on_interrupt": keep_on_interrupt}
    answer: xr.Dataset = machine_kind(described).answer("simulate", described, {**common, **options})
    return answer


def check(machine: AnyMachine, say: Callable[[str], None] | None = None) -> Summary | ChamberSummary:
    """What is known of a machine before a run: masses, critical speeds, capability, drag, border speeds, and what looks wrong.

    Of deep chambers: filling, contact time and step in place of drag and borders. Each border, and what friction holds, has
    10 s of computing; what is not found by then says so.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    say
        Is told what takes over a second; by default a line where somebody is looking, on a terminal or in a notebook.

    Returns
    -------
    Summary or ChamberSummary
        Frozen, in SI; prints itself as a table, also in a notebook.

    Raises
    ------
    MachineError
        If the machine is not possible as described.
    """
    described = any_machine(machine)
    answer: Summary | ChamberSummary = machine_kind(described)["check"](
        described, say or (looking_for if in_notebook() or sys.stderr.isatty() else None)
    )
    return answer


def design(
    given: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    seen: Callable[[Designed], None] | None = None,
) -> Designed:
    """Find the balancer for a rotor: which race, how many balls, which fluid; or the balls and the fluid of a deep chamber.

    Closed forms rule out what does not fit, cannot balance the largest unbalance or presses too hard. In races exact borders rule
    out what stalls or is not stable at an operating speed at some temperature; what is left runs with scatter (unbalance,
    temperature, starts and what the specification names). In deep chambers short runs halve what is left again and again, and
    the few best have full runs. What ran is ranked by its limits and two objectives.

    Parameters
    ----------
    given
        The path of a specification file (TOML), or a dict of the same form; see the pages on design for its keys.
    folder
        Where finished runs are kept, and taken up again by the same call later. By default nothing is kept on the way.
    workers
        Threads; by default one for each core. The result does not depend on it.
    progress
        Called with (runs done, runs in all).
    seen
        Called with the answer so far whenever a candidate has run; of deep chambers when all have.

    Returns
    -------
    xarray.Dataset
        Over ``design``: what every candidate is, ``stage`` and ``reason`` of those that were ruled out; of the others numbers and
        shares of their runs with intervals, whether each ``meets`` the limits, its Pareto ``front`` and ``place``, and its
        machine file. :func:`designed_machine` makes a machine of it.

    Raises
    ------
    QuestionError
        For a fault in the specification, named with its key; for limits that contradict each other; if no candidate is left, with
        what ruled the last ones out; for a folder of another design.
    MachineError
        If the machine is impossible.
    """
    data, _, place, _ = question_data(given, "specification", "design")
    machine = data.get("machine")
    if isinstance(machine, (str, Path)):  # else a rig, or a reader says what is wrong with it
        path = beside(place, machine)
        machine = read_toml(path) if path.is_file() else None
    kind = RACES if machine is None else machine_kind(machine)
    answer: Designed = kind["design"](given, folder=folder, workers=workers, progress=progress, seen=seen)
    return answer


def verdict(run: xr.Dataset, held: xr.Dataset | None = None, *, last: float | str | None = None) -> Verdict:
    """Whether a run ends balanced, and what remains at each place, plane and support.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`.
    held
        The same machine from ``simulate(machine, hold_balls=True)``, which gives the peak without balls. For balls in races
        with external excitation also the vibration without balls, which otherwise every run has.
    last
        Deep chambers: seconds at the end that are the steady state; by default a tenth of the run.

    Raises
    ------
    QuestionError
        If an argument belongs to the other kind of run, or the run did not keep what is needed.
    """
    options = {name: value for name, value in (("held", held), ("last", last)) if value is not None}
    answer: Verdict = machine_kind(run).answer("verdict", run, options)
    return answer


def run_measures(run: xr.Dataset, measure: str = "", **options: Any) -> Any:
    """All measures of a run in one dataset; each has its unit and its long name, which says where it is measured.

    With the name of a ``measure`` that one alone, over time or at every place: ``vibration``, ``static_deflection``,
    ``residual_unbalance``, ``support_forces``, ``deflection_envelope``, ``residual_vibration``, ``peak_deflection``,
    ``settling_time``, ``break_away_speed`` or ``ball_angle_to_unbalance``; of a deep chamber ``collision_statistics``,
    ``balls_unbalance`` or ``residual_of_balls``.

    A run of a deep chamber whose speed still changes has no steady state, and nan for it unless ``last`` is given.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`.
    **options
        Of deep chambers: ``unbalance``, ``couple``, ``chamber_places``, ``last``, ``tolerance``, see
        :func:`autobalancer.results.chamber_measures.chamber_measures`. Of one measure its own, such as ``place`` or ``last``.

    Raises
    ------
    QuestionError
        If the run did not keep what is needed, there is no such measure, or an option belongs to the other kind of run.
    """
    kind = machine_kind(run)
    if measure and measure not in kind.measures:
        known = ", ".join(kind.measures)
        raise QuestionError(
            f"run_measures: measure: given {measure!r}; {kind.words} have {known}, and all in one table"
        )
    return kind.answer(measure or "run_measures", run, options)


def compare(
    given: Mapping[str, AnyMachine] | Sequence[AnyMachine] | xr.Dataset | str | Path,
    measured: xr.Dataset | None = None,
    **options: Unpack[CompareOptions],
) -> Answer:
    """Put machines side by side, or a run and what was measured.

    Parameters
    ----------
    given
        Machines or the paths of their files, each of which is run; a mapping gives them names. Or one run, with samples.
    measured
        Beside a run: signals, orders, or ball angles of a film or photograph, of the machine that it is of.
    **options
        Of machines: ``at``, ``duration``, ``tolerance``, ``bins``, ``seed``, ``workers``, ``progress``, see
        :func:`autobalancer.studies.compare.compare`. Of a run: ``seed`` of the noise and keywords of the tacho, see
        :func:`autobalancer.measurement.overlay.overlay`.

    Returns
    -------
    Answer
        One row for each machine or each measure, drawn by ``ab.plot.answer``.

    Raises
    ------
    QuestionError
        For machines with one name, a run without samples, or a measurement of other places or times.
    """
    import xarray as xr

    if isinstance(given, xr.Dataset):
        from autobalancer.measurement.overlay import overlay

        if measured is None:
            raise QuestionError("compare: given a run alone; give the measurement, too, as in compare(run, measured)")
        return overlay(given, measured, **options)
    from autobalancer.studies.compare import compare as machines_side_by_side

    if measured is not None:
        raise QuestionError("compare: a measurement is compared with a run: give ab.simulate(machine) in its place")
    refuse_unknown("compare", options, arguments_of(machines_side_by_side)[1:], "machines")
    return machines_side_by_side(given, **options)  # type: ignore[arg-type, misc]  # which are those of machines
