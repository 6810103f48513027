"""Studies: what varies, how it scatters, and when enough is known, from a file or a dict."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import nullcontext, suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from socket import create_connection, gaierror
from time import monotonic, sleep
from typing import Any, cast

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.assembly.drive_train import corners
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import AutobalancerError, QuestionError, one_of, unwarned
from autobalancer.files.text_files import read_toml
from autobalancer.machine import Hill, Machine, PrescribedSpeed
from autobalancer.machine.path import dimension_of
from autobalancer.progress import shows_progress
from autobalancer.random_numbers import Z, generator
from autobalancer.results.answers.answer import Answer, Labeled, provenance
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import significant
from autobalancer.results.folder_store import Span, Store
from autobalancer.results.labels import labeled
from autobalancer.results.verdict import GREATER
from autobalancer.simulation.record import Envelope
from autobalancer.simulation.run import simulate_races
from autobalancer.studies.ensemble.members import Members, without_start_angles
from autobalancer.studies.random_starts import peak_without_balls
from autobalancer.studies.study.chunk import RUN, WALL, AssembledMembers, run_chunk, study_dataset
from autobalancer.studies.study.chunk import Arrays as ChunkArrays
from autobalancer.studies.study.study_file import read_study
from autobalancer.studies.study.study_spec import START, Study, looks
from autobalancer.studies.variations import in_threads

PROBED, MOST_PROBED = 100, 1000  # members that are made before a study begins, and most of them for the sake of a grid


@shows_progress
def study(
    given: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    keep_on_interrupt: bool = False,
) -> Studied:
    """Run a study: a machine many times with values from a grid and from distributions.

    Parameters
    ----------
    given
        The path of a study file (TOML), or a dict of the same form; see the page on studies for its keys.
    folder
        Where finished chunks are kept, and taken up again by the same call later. By default nothing is kept on the way.
    scheduler
        Address of a Dask scheduler whose workers run the members, such as ``"tcp://host:8786"``; by default this process does.
    workers
        Threads of this process; by default one for each core. The result does not depend on it.
    progress
        Called with (members done, members in all).
    keep_on_interrupt
        If true, Ctrl-C returns what is done.

    Returns
    -------
    xarray.Dataset
        Over ``member``: as coordinates everything that varied, ``draw``, ``point`` of the grid and ``seed``; the measures of
        :func:`autobalancer.sweep`, ``outcome``, ``verdict`` and ``balanced`` of each run, border speeds and whatever else the
        study asked for. ``attrs["stopped_by"]`` is ``"confidence"``, ``"members"`` or ``"interrupted"``.

    Raises
    ------
    QuestionError
        For a fault in the study, named with its key; for a folder of another study; for distributions of impossible machines.
    MachineError
        If the machine is impossible.
    ResultError
        If a chunk cannot be written; those before it are kept.
    """
    specification = read_study(given)
    source = given if isinstance(given, (str, Path)) else "study"
    if RUN in specification.results and not specification.duration > 0.0:
        raise QuestionError(f"{source}: duration: the machine has no 'run.duration'; give one in the study")
    try:
        refuse_impossible(specification)
    except QuestionError as reason:
        raise QuestionError(f"{source}: {reason}") from None
    with Store(folder, specification.identity(), "study") if folder is not None else nullcontext() as store:
        work = _Work(specification, store, workers, progress)
        interrupted = work.run(scheduler)
    if interrupted and not keep_on_interrupt:
        raise KeyboardInterrupt
    dataset = study_dataset(specification, work.chunks, work.end)
    stopped = "interrupted" if interrupted else "confidence" if work.enough else "members"
    named = {"study_file": Path(given).name} if isinstance(given, (str, Path)) else {}
    left, passage, ratio = "", "", np.nan
    with suppress(KeyboardInterrupt):  # the members are not lost for that
        if not interrupted and RUN in specification.results and specification.sudden is None:
            left, (passage, ratio) = drag_note(specification), passage_note(specification, dataset)
    about = {"stopped_by": stopped, "drag_warning": left, "passage_text": passage, "passage_ratio": ratio, **named}
    return Studied.of(dataset.assign_attrs(about))


def refuse_impossible(study: Study) -> None:
    """Make some members before a study begins; those that are no machine are refused or counted, as the study says.

    Raises
    ------
    QuestionError
        With the share of impossible members and an example, if the study refuses them.
    """
    if study.impossible == "record":
        return
    wanted = max(PROBED, min(len(study.points), MOST_PROBED))  # every point of the grid, where it has not too many
    made = AssembledMembers(replace(study, impossible="record"), 0, min(wanted, study.count))
    share = len(made.reasons) / made.members.count
    if made.reasons and (study.impossible == "refuse" or share == 1.0):
        example = next(iter(made.reasons.values()))
        raise QuestionError(
            f"{100.0 * share:.3g} % of the first {made.members.count} members cannot be built; the first: {example}. Narrow "
            "the distributions, give them 'low' and 'high', or take impossible = 'truncate' (draw again) or 'record'"
        )


class _Work:
    """What is done, what is to do, and when it is enough."""

    def __init__(self, asked: Study, store: Store | None, workers: int | None, progress: Any) -> None:
        self.asked, self.store, self.progress = asked, store, progress
        self.workers = workers if workers is not None else os.cpu_count() or 1
        self.chunks: dict[Span, ChunkArrays] = store.parts() if store is not None else {}
        self.end, self.enough = asked.count, False
        self._size = FIRST  # members of the next chunk
        self._looked = 0  # draws

    def run(self, scheduler: str | None) -> bool:
        """Run what is missing; whether somebody interrupted it."""
        try:
            if self._look():
                return False
            if scheduler is None:
                here(self.asked, self._missing(), self._take, self.workers, self._within)
            else:
                in_cluster(self.asked, self._missing(), self._take, scheduler)
        except KeyboardInterrupt:
            return True
        return False

    def _missing(self) -> Iterator[Span]:
        """Chunks that are not there, in order; each is as large as the time of those before it says."""
        first = 0
        while first < self.asked.count:
            there = next((span for span in self.chunks if span[0] == first), None)
            if there is None:
                later = [span[0] for span in self.chunks if span[0] > first]
                there = first, min([first + self._size, self.asked.count, *later])
                yield there
            first = there[1]

    def _take(self, span: Span, arrays: ChunkArrays) -> bool:
        self.chunks[span] = arrays
        if self.store is not None:
            self.store.keep(span, arrays)
        self._size = next_size(self._size, span[1] - span[0], float(arrays[WALL][0]))
        if self.progress is not None:
            self.progress(self._done(), self.asked.count)
        return self._look()

    def _within(self, done: int, _total: int) -> None:
        """Some members of the chunk under way are done."""
        if self.progress is not None:
            self.progress(min(self._done() + done, self.asked.count), self.asked.count)

    def _done(self) -> int:
        return sum(last - first for first, last in self.chunks)

    def _look(self) -> bool:
        """Whether enough is known. Looks come after fixed numbers of draws, so that chunks make no difference."""
        stop = self.asked.stop
        if stop is None:
            return False
        points, known = len(self.asked.points), self._known()
        for draws in looks(self.asked.draws):
            if draws * points > known:
                return False
            if draws <= self._looked:
                continue
            self._looked = draws
            values = self._values(stop.of, draws * points).reshape(draws, points)
            if all(stop.reached(values[:, point]) for point in range(points)):
                self.end, self.enough = draws * points, True
                return True
        return False

    def _known(self) -> int:
        """Members from the first one on without a gap."""
        end = 0
        for first, last in sorted(self.chunks):
            if first > end:
                break
            end = max(end, last)
        return end

    def _values(self, name: str, count: int) -> Any:
        parts = [self.chunks[span][name] for span in sorted(self.chunks) if span[0] < count]
        return np.concatenate(parts).astype(float)[:count]


# Chunks of a study run here or by a cluster; each is handed on as soon as it is finished.


Take = Callable[[Span, ChunkArrays], bool]  # keeps a chunk; true if no more are wanted
Look = Callable[[int, int], None]
FIRST = 16  # members of the first chunks
MOST = 100_000  # members of a chunk
WORTH = 2.0  # s, that a worker has with a chunk
WAIT = 5.0  # s, for a scheduler to answer
LOST = 30.0  # s without scheduler or workers, after which nobody waits for them any longer
PAUSE = 0.01  # s, between two looks whether a chunk is finished
RETRIES = 3  # of a chunk whose worker died


def here(study: Study, spans: Iterator[Span], take: Take, workers: int | None, look: Look | None = None) -> None:
    """Run chunks one after the other, the members of each on all cores; ``look`` is told how many of a chunk are done."""
    for first, last in spans:
        if take((first, last), run_chunk(study, first, last, workers, look)):
            return


def in_cluster(study: Study, spans: Iterator[Span], take: Take, address: str) -> None:
    """Run chunks by the workers of a Dask scheduler, some more of them waiting than there are workers.

    Raises
    ------
    QuestionError
        If Dask is not installed, no scheduler answers there, or it or all its workers are lost. What was finished before is kept.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise QuestionError(
            "scheduler: Dask is not installed; install it with: pip install 'autobalancer[cluster]'"
        ) from None
    try:
        _knock(address)
        client = distributed.Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as reason:
        raise QuestionError(f"scheduler: no Dask scheduler answers at {address!r}: {reason}") from None
    try:
        with client:
            _distribute(distributed, client, study, spans, take, address)
    except (OSError, TimeoutError, CancelledError) as reason:
        raise _lost(f"the scheduler at {address!r} was lost: {reason}") from None


def _knock(address: str) -> None:
    """Try the door of a scheduler for a while: plainly, since Dask itself says little of what is wrong and takes long.

    Raises
    ------
    OSError, ValueError
        If nobody opens, or this is no address.
    """
    addressing: Any = import_module("distributed.comm.addressing")
    way, place = addressing.parse_address(address)
    if way not in ("tcp", "tls"):
        raise ValueError("write it as tcp://HOST:PORT")
    host, port = addressing.parse_host_port(place)
    begun = monotonic()
    while True:
        try:
            create_connection((host, port), timeout=WAIT).close()
            return
        except OSError as reason:
            if isinstance(reason, (gaierror, TimeoutError)) or monotonic() - begun > WAIT:
                raise
            sleep(0.1 * WAIT)


def _distribute(distributed: Any, client: Any, study: Study, spans: Iterator[Span], take: Take, address: str) -> None:
    threads = sum(client.nthreads().values())
    if not threads:
        raise QuestionError(f"scheduler: the scheduler at {address!r} has no workers; start some")
    waiting = distributed.as_completed(with_results=True, raise_errors=False, loop=client.loop)
    spans_of, again = {}, dict[Span, int]()

    def submit(span: Span | None) -> None:
        if span is not None:  # with the study each time: what is kept by workers is gone with the last of them
            future = client.submit(run_chunk, study, *span, pure=False, retries=RETRIES)
            spans_of[future.key] = span
            waiting.add(future)

    for _ in range(2 * threads):
        submit(next(spans, None))
    while spans_of:
        _wait(waiting, client, address)
        future, result = next(waiting)
        span = spans_of.pop(future.key)
        if future.status == "finished":
            if take(span, result):
                return
            submit(next(spans, None))
        elif isinstance(result, CancelledError) and client.status == "running" and again.get(span, 0) < RETRIES:
            again[span] = again.get(span, 0) + 1  # its worker was lost with what it had
            submit(span)
        else:
            raise _failure(span, result)


def _wait(waiting: Any, client: Any, address: str) -> None:
    """Wait for a chunk, as long as there is somebody to run it."""
    looked = seen = monotonic()
    while not waiting.has_ready():
        sleep(PAUSE)
        now = monotonic()
        if now - looked > 1.0:
            looked = now
            if client.status == "running" and client.nthreads():
                seen = now
            elif now - seen > LOST or client.status == "closed":
                raise _lost(f"the scheduler at {address!r} or all its workers were lost")


def _failure(span: Span, result: Any) -> Exception:
    """Why a chunk could not be run; faults of the study are those of the worker."""
    reason = result[1] if isinstance(result, tuple) else result
    if isinstance(reason, AutobalancerError):
        return reason
    members = f"members {span[0] + 1} to {span[1]}"
    if isinstance(reason, CancelledError):
        return _lost(f"it was lost, or the workers that had {members}")
    return _lost(f"{members} could not be run: {type(reason).__name__}: {reason}")


def _lost(said: str) -> QuestionError:
    return QuestionError(f"scheduler: {said}. What was finished before is in the folder, and the same call goes on")


def next_size(size: int, members: int, wall: float) -> int:
    """Members for a chunk worth the trouble, from the time (s) that so many took; the first times are no good measure."""
    wanted = WORTH * members / max(wall, 1e-6)
    return int(min(max(wanted, FIRST), 4 * max(size, FIRST), MOST))


# Whether the drag law of a study holds for its balls: seen in one member of each point, run alone.


MOST_NOTES = 8  # points that are looked at, the first and the last among them
PASSAGES = 15  # members of such a point that are run without balls


def points_of_interest(study: Study) -> list[int]:
    """Points of which single members are run alone, counted from 0."""
    return np.unique(np.linspace(0, len(study.points) - 1, MOST_NOTES).astype(int)).tolist()  # type: ignore[no-any-return]


def drag_note(study: Study) -> str:
    """What a run of such a member says of the range of its drag law, of the point at which it is left furthest; else empty."""
    worst, text = 0.0, ""
    for number in points_of_interest(study):
        try:
            made = AssembledMembers(study, number, number + 1)
            assembly, _ = made.members.ready(0, made.plan)
            if not any(ball.drag_curve is not None or ball.slipstream or ball.stokes for ball in assembly.balls):
                break  # the drag is given as a number
            with unwarned():
                run = simulate_races(
                    made.members.machine_of(0),
                    duration=study.duration,
                    save=[Envelope(study.bins)],
                    tolerance=study.tolerance,
                    seed=int(made.members.seeds[0]),
                )
        except AutobalancerError:  # it is impossible, and its reason stands with the members
            continue
        over = float(run.attrs.get("drag_reynolds", 0.0)) / float(run.attrs.get("drag_reynolds_limit", np.inf))
        if run.attrs.get("drag_warning") and over > worst:
            worst, text = over, str(run.attrs["drag_warning"])
    return text


def passage_note(study: Study, dataset: xr.Dataset) -> tuple[str, float]:
    """What members say of their passages, each beside its own run with held balls, and the median of these ratios.

    Of each point the first members that ran are looked at; of the points the one counts whose median ratio is greatest, and
    the text says at how many a passage is worse. It is empty, and the number nan, where no passage is worse.
    """
    peaks, place, width = dataset["peak_deflection"].values, dataset["point"].values - 1, len(study.points)
    points = points_of_interest(study)
    worst, text, where, bad = np.nan, "", "", 0
    for number in points:
        ratios, members = [], list[int]()
        for row in np.flatnonzero((place == number) & np.isfinite(peaks))[:PASSAGES]:
            member = int(dataset["member"].values[row]) - 1
            first = (
                member // width * width if study.impossible == "truncate" else member
            )  # such draws are made together
            made = AssembledMembers(study, first, first + width if study.impossible == "truncate" else member + 1)
            with suppress(AutobalancerError), unwarned():
                machine = made.members.machine_of(member - first)
                held = float(peak_without_balls(machine, study.tolerance, study.duration))
                ratios.append(float(peaks[row]) / held if held > 0.0 else np.nan)
                members.append(member)
        known = np.array(ratios)[np.isfinite(ratios)]
        worse = int((known > GREATER).sum())
        bad += worse > 0
        if not worse or np.median(known) <= worst:
            continue
        worst, most = float(np.median(known)), int(np.nanargmax(ratios))
        where = Studied.of(dataset).point_texts()[number] if width > 1 else ""
        which = f"draw {members[most] // width + 1} of this point" if width > 1 else f"member {members[most] + 1}"
        text = (
            f"the greatest deflection on the way is more than a tenth greater than without balls in {worse} of "
            f"{known.size} members, each beside its own run without balls; median {significant(worst)} times as much, at "
            f"most {significant(ratios[most])} times ({which})"
        )
    if text and width > 1:
        looked = f"{len(points)} points" + f" that were looked at of {width}" * (len(points) < width)
        text = f"a passage is worse at {bad} of {looked}; at the worst of these, {where}: {text}"
    return text, worst


# How far a machine goes on its way up, and down again: the envelopes of many members as percentiles over the time.


LEVEL = "below_"
PERCENT = (5.0, 25.0, 50.0, 75.0, 95.0, 100.0)


@shows_progress
def envelopes(
    given: str | Path | Mapping[str, Any] | Machine,
    *,
    members: int = 100,
    point: int = 1,
    coast_down: bool = False,
    bins: int = 400,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Labeled:
    """Percentiles of the deflection over the time of many runs of one machine.

    Parameters
    ----------
    given
        A study, as for :func:`autobalancer.study`, of which the first draws count; or a machine, which runs from random starts.
    members
        How many runs.
    point
        Of the grid of a study.
    coast_down
        Whether the rotor comes down again after its run, as fast as it went up.
    bins
        Intervals of time.
    seed
        For the starts of a machine; a study has its own.
    workers
        Threads; the result does not depend on it.
    progress
        Called with (runs done, runs in all).

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``below_5`` to ``below_100``, deflection in each interval of time below which so many percent are;
        ``speed`` of the rotor.

    Raises
    ------
    QuestionError
        If there is no such point; if an unbalance appears; for ``coast_down`` of a drive by a torque or along an S-shaped run-up.
    """
    study = read_study({"machine": given, "seed": seed} if _is_machine(given) else cast(Any, given))
    if study.sudden is not None:
        raise QuestionError("envelopes: an unbalance that appears joins two runs; give a study of whole runs")
    if not 1 <= point <= len(study.points):
        raise QuestionError(f"envelopes: point: given {point}; the grid has 1 to {len(study.points)}")
    # the first members of the point run with the envelope of their deflection alone
    count = min(members, study.draws)
    if count < 2:
        raise QuestionError(f"envelopes: members: given {members}; give at least 2")
    jobs, duration = _members(study, count, point - 1, coast_down)
    runs = in_threads(lambda job: _envelope(*job, duration, study.tolerance, bins), jobs, workers, progress)
    high = np.array([run[0] for run in runs if run is not None])
    if high.shape[0] < 2:
        raise QuestionError("envelopes: fewer than two of the members can run")
    # all have the same bins, as the drive is the same
    _, time, speed = next(run for run in runs if run is not None)
    levels = {
        f"{LEVEL}{percent:g}": ("time", values, f"deflection of {percent:g} % of the runs", "m")
        for percent, values in zip(PERCENT, np.nanpercentile(high, PERCENT, axis=0), strict=True)
    }
    dataset = labeled(
        levels | {"speed": ("time", speed, "rotor speed", "rad/s")},
        {"time": ("time", time, "time", "s")},
        {
            "title": f"Envelopes of {high.shape[0]} runs of {study.machine.name}",
            **provenance(),
            "machine_name": study.machine.name,
            "members": high.shape[0],
            "greatest": float(np.nanmax(high)),
        },
    )
    return Labeled.of(dataset)


def _is_machine(argument: Any) -> bool:
    """Whether it is a machine, or the path of its file: that has a rotor, a study has none."""
    if not isinstance(argument, (str, Path)):
        return isinstance(argument, Machine)
    try:
        return "rotor" in read_toml(Path(argument))
    except QuestionError:
        return False  # whoever reads it says what is wrong


def _members(study: Study, count: int, point: int, coast_down: bool) -> tuple[list[tuple[Machine, int]], float]:
    """Machines with their seeds, and how long they run."""
    machine = without_start_angles(study.machine) if study.random_starts else study.machine
    columns = study.columns(0, count * len(study.points), {})
    members = Members(machine, columns, None, study.seed, "")
    result, duration = [], study.duration
    for draw in range(count):
        number = draw * len(study.points) + point
        try:
            one = members.machine_of(number)
            if coast_down:
                one, duration = _there_and_back(one, study.duration)
        except QuestionError:
            raise
        except AutobalancerError:
            continue
        result.append((one, int(members.seeds[number])))
    return result, duration


def _there_and_back(machine: Machine, duration: float) -> tuple[Machine, float]:
    """The machine whose speed follows its profile, and then the same backwards."""
    drive = machine.drive
    if not isinstance(drive, PrescribedSpeed) or isinstance(drive.profile, Hill):
        raise QuestionError("envelopes: coast_down: the drive must prescribe the speed, by straight pieces")
    up = [(time, speed) for time, speed in corners(drive.profile) if time < duration]
    up = [*([(0.0, up[0][1])] if up[0][0] > 0.0 else []), *up, (duration, up[-1][1])]
    whole = [*up, *((2.0 * duration - time, speed) for time, speed in up[-2::-1])]
    table = {"kind": "table", "time": [time for time, _ in whole], "speed": [speed for _, speed in whole]}
    return with_value_at(machine, "drive.profile", table), 2.0 * duration


def _envelope(machine: Machine, seed: int, duration: float, tolerance: float, bins: int) -> tuple[Any, Any, Any] | None:
    try:
        with unwarned():  # of each run the same
            run = simulate_races(machine, duration=duration, seed=seed, tolerance=tolerance, save=[Envelope(bins)])
    except AutobalancerError:
        return None
    high = np.full(bins, np.nan)
    high[: run.sizes["bin"]] = run["envelope_high"].values
    if run.sizes["bin"] < bins:
        return None
    return high, run["envelope_time"].values, run["envelope_speed"].values


# Which scatter drives the scatter of a result: Sobol' indices of a plan made for them, rank correlations of any other.


RESAMPLED = 500  # bootstrap samples of an interval
FEWEST = 20  # draws
SPEARMAN = 1.06  # variance of Fisher's z of a rank correlation, times n - 3 (Fieller, Hartley and Pearson 1957)


def sensitivity(study: xr.Dataset, quantity: str) -> Answer:
    """How much each input of a study adds to the scatter of a quantity.

    Parameters
    ----------
    study
        A result of :func:`autobalancer.study`. With ``plan = "sensitivity"`` there are Sobol' indices, else rank correlations.
    quantity
        A number of each member, such as ``"peak_deflection"``, ``"settling_time"`` or ``"balanced"``.

    Returns
    -------
    xarray.Dataset
        Over ``input``, with a grid also over ``point``. Sobol' indices: ``first`` (share of the variance by the input alone) and
        ``total`` (share that is gone if it is known, with all in which it takes part). Else ``rank_correlation``
        (Spearman). Each with ``_low`` and ``_high``, the ends of its 95 % interval. ``attrs["draws"]`` says how many counted.

    Raises
    ------
    QuestionError
        If the study has no such quantity, nothing in it scatters, too few draws have a number, or all numbers are equal.

    Notes
    -----
    Sobol' indices by Saltelli et al. (2010) for the first and Jansen (1999) for the total, with intervals by bootstrap.
    Random starts of the balls are one input, ``start``. Draws without a number do not count.
    """
    one_of("quantity", quantity, *Studied.of(study).numbers())
    inputs = list(map(str, np.atleast_1d(study.attrs.get("inputs", []))))  # a file keeps a list of one as a text
    sobol = study.attrs.get("plan") == "sensitivity"
    columns = {} if sobol else {name: study[_dimension(name)].values for name in inputs if name != START}
    _refuse_inputs(inputs, sobol, [name for name, values in columns.items() if values.dtype.kind not in "fi"])
    points = np.unique(study["point"].values)
    items = [
        (_indices if sobol else _ranks)(
            study.isel(member=np.flatnonzero(study["point"].values == point)), quantity, inputs
        )
        for point in points
    ]
    inputs = inputs if sobol else [name for name in inputs if name != START]
    draws = [int(item.pop("draws")) for item in items]
    result = labeled(
        {name: (("point", "input"), np.array([item[name] for item in items]), TEXTS[name], "1") for name in items[0]},
        {"input": ("input", [_dimension(name) for name in inputs]), "point": ("point", points)},
        {
            "title": f"Sensitivity of {quantity}",
            **provenance(),
            "quantity": quantity,
            "quantity_text": str(study[quantity].attrs.get("long_name", quantity)),
            "study_name": study.attrs.get("study_name", "study"),
            "draws": draws,
            "remarks": [] if sobol else _remarks(study),
        },
    )
    if isinstance(study, Studied) and points.size > 1:
        result = result.assign_coords(at=("point", study.point_texts()))
    if points.size == 1:
        result = result.isel(point=0, drop=True)
    return Answer.of(result, "Sensitivity")


def _remarks(study: xr.Dataset) -> list[str]:
    """What rank correlations leave out."""
    remarks = []
    if START in np.atleast_1d(study.attrs.get("inputs", [])):
        remarks.append("random starts of the balls are not among the inputs; with plan = 'sensitivity' they are")
    if json.loads(study.attrs.get("study", "{}")).get("correlation"):
        remarks.append("inputs that were drawn together borrow rank correlation from one another")
    return remarks


TEXTS = {
    f"{name}{end}": f"{text}{words}"
    for name, text in (
        ("first", "share of the variance by the input alone"),
        ("total", "share of the variance in which the input takes part"),
        ("rank_correlation", "rank correlation (Spearman)"),
    )
    for end, words in (
        ("", ""),
        ("_low", ", lower end of its 95 % interval"),
        ("_high", ", upper end of its 95 % interval"),
    )
}


def _indices(study: xr.Dataset, quantity: str, inputs: list[str]) -> dict[str, Any]:
    width = len(inputs) + 2
    values = study[quantity].values.astype(float)
    values = values[: values.size // width * width].reshape(-1, width)
    values = values[np.isfinite(values).all(axis=1)]
    count = values.shape[0]
    _enough(count, values, quantity)
    first, total = _sobol_indices(values)
    take = generator(0).integers(0, count, (RESAMPLED, count))
    again = np.array([_sobol_indices(values[rows]) for rows in take])  # (resampled, 2, inputs)
    low, high = np.quantile(again, (0.025, 0.975), axis=0)
    return {
        "first": first,
        "first_low": low[0],
        "first_high": high[0],
        "total": total,
        "total_low": low[1],
        "total_high": high[1],
        "draws": count,
    }


def _sobol_indices(values: Floats) -> tuple[Floats, Floats]:
    """First and total indices from runs with the inputs A, B and A with one of B, (samples, inputs + 2)."""
    middle = values[:, :2].mean()
    a, b, changed = values[:, :1] - middle, values[:, 1:2] - middle, values[:, 2:] - middle
    variance = values[:, :2].var()
    if not variance > 0.0:
        return np.zeros(changed.shape[1]), np.zeros(changed.shape[1])
    return (b * (changed - a)).mean(axis=0) / variance, ((a - changed) ** 2).mean(axis=0) / (2.0 * variance)


def _ranks(study: xr.Dataset, quantity: str, inputs: list[str]) -> dict[str, Any]:
    from scipy.stats import spearmanr

    values = study[quantity].values.astype(float)
    known = np.isfinite(values)
    count = int(known.sum())
    _enough(count, values[known], quantity)
    columns = [study[_dimension(name)].values[known] for name in inputs if name != START]
    middle = np.array([float(spearmanr(column, values[known]).statistic) for column in columns])
    half = Z * np.sqrt(SPEARMAN / (count - 3))
    z = np.arctanh(np.clip(middle, -1.0 + 1e-15, 1.0 - 1e-15))
    return {
        "rank_correlation": middle,
        "rank_correlation_low": np.tanh(z - half),
        "rank_correlation_high": np.tanh(z + half),
        "draws": count,
    }


def refuse_without_sensitivity(study: Study) -> None:
    """Refuse a study that :func:`sensitivity` could say nothing of, before it runs.

    Raises
    ------
    QuestionError
        If nothing scatters that can be ranked, or there are too few draws.
    """
    texts = [name for name, one in study.scatter.items() if any(isinstance(v, str) for v in getattr(one, "values", ()))]
    _refuse_inputs(study.inputs, study.plan == "sensitivity", texts)
    if study.members < FEWEST:
        raise QuestionError(f"sensitivity: members: given {study.members}; at least {FEWEST} are needed")


def _refuse_inputs(inputs: list[str], sobol: bool, texts: list[str]) -> None:
    if not inputs:
        raise QuestionError("sensitivity: nothing scatters in this study; give distributions under 'vary'")
    if not sobol and set(inputs) == {START}:
        raise QuestionError(
            "sensitivity: only starts are random here; the plan 'sensitivity' says what they add, and distributions under 'vary' "
            "are ranked by any plan"
        )
    if not sobol and texts:
        raise QuestionError(f"sensitivity: {texts[0]!r} has texts, which have no ranks; take the plan 'sensitivity'")


def _enough(count: int, values: Floats, quantity: str) -> None:
    if count < FEWEST:
        raise QuestionError(f"quantity {quantity!r}: only {count} draws have a number; at least {FEWEST} are needed")
    if not np.ptp(values) > 0.0:
        raise QuestionError(f"quantity {quantity!r}: is the same in all draws, so nothing drives its scatter")


def _dimension(name: str) -> str:
    return name if name == START else dimension_of(name)
