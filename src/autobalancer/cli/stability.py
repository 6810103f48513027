"""Commands that answer before a run."""

from __future__ import annotations

import math
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Reply, command
from autobalancer.cli.terminal.options import COUNT, In, MachineFile, Speeds
from autobalancer.cli.terminal.sheet import speed_sign, speed_text
from autobalancer.errors import QuestionError, one_of

if TYPE_CHECKING:
    import numpy as np

    from autobalancer.results.answers.answer import Answer
    from autobalancer.tables import Column

TOPIC = "Stability"  # where the help of autobalancer lists the commands below


Unbalance = Annotated[float | None, In("kg*m"), 'Such as "594 g*mm"; by default that of the machine.']
Speed = Annotated[float | None, In("rad/s"), 'Rotor speed where it is not varied, such as "1200 rpm".']


# ``autobalancer check``: what can be said of a machine before it runs.


@command(out=None, unit="speed", topic="First 2")
def check(machine: MachineFile) -> Reply:
    """Check a machine file and print its masses, critical speeds, capability, drag and border speeds.

    Of a machine with deep chambers: filling, contact time and step in place of drag and borders. A file of another kind, such
    as a study, a design specification or a balancing job, is read as what it is, with all its faults.

    Example: autobalancer check discoidal.toml
    """
    from autobalancer.progress import looking_for

    if reply := _other_kind(machine):
        return reply
    found = ab.check(machine, looking_for)
    return Reply(found, found.as_dict(), heading=found.name, facts=found.rows(speed_text), notes=found.warnings)


def _other_kind(path: Path) -> Reply | None:
    """What is said of a file that is read without a fault and is no machine."""
    from autobalancer.files.text_files import read_toml
    from autobalancer.machine.schema import OTHERS, other_kind

    kind = other_kind(read_toml(path)) if path.suffix.lower() == ".toml" and path.is_file() else None
    if kind is None:
        return None
    noun, module, reader, question = OTHERS[kind]
    getattr(import_module(f"autobalancer.{module}"), reader)(path)
    answered_by = f"autobalancer {question.format(path)}"
    text = f"{path}: a {noun} without faults; '{answered_by}' answers it"
    return Reply(None, {"file": str(path), "kind": kind, "command": answered_by}, lines=[text])


# ``autobalancer borders``: the border speeds of a machine, over a parameter, and the least viscosity for a speed.


@command(draw=True, unit="speed", topic="First 6")
def borders(
    machine: MachineFile,
    unbalance: Annotated[float | None, In("kg*m"), 'Such as "594 g*mm"; by default the largest of the machine.'] = None,
    windows: Annotated[
        bool, typer.Option("--windows", help="Also list all stable speed ranges up to --up-to.")
    ] = False,
    over: Annotated[str, 'Borders over a parameter, "NAME=from:to:count[:log]"; unbalance and viscosity alone.'] = "",
    only: Annotated[str, 'Only these, with commas between: "release speed, capture speed" are found fast.'] = "",
    up_to: Annotated[
        float | None,
        In("rad/s"),
        "Highest speed, for release, capture and --windows; by default that of the drive.",
    ] = None,
    minimum_viscosity_at: Annotated[float | None, In("rad/s"), 'Least viscosity for this speed, "1200 rpm".'] = None,
    minimum_drag_at: Annotated[float | None, In("rad/s"), "Least drag for this speed."] = None,
    files: Any = None,
) -> Reply:
    """Print the averaged border, the exact border, the release speed and the capture speed, each with its notes.

    With --over also as a table over a parameter, which --out and --plot write.

    Example: autobalancer borders discoidal.toml \\
      --over unbalance --plot borders.png --minimum-viscosity-at "1200 rpm"
    """
    from autobalancer.assembly.terms import unknown
    from autobalancer.errors import RangeWarning, unwarned
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.results.display_units import moment_text
    from autobalancer.stability.friction import held_by_friction
    from autobalancer.stability.maps.exact import NAMES, theory_of
    from autobalancer.stability.summary import friction_rows

    if (files.out or files.plot is not None) and not over:
        raise QuestionError("borders: --out and --plot show the borders over a parameter; name it with --over")
    described, names = load_race_machine(machine), _names(only)
    answer: dict[str, Any] = {
        "machine": str(machine),
        "borders": [vars(border) for border in ab.stability.borders(described, unbalance, only=names, up_to=up_to)],
    }
    held = held_by_friction(described, unbalance=unbalance)
    answer["friction"] = held.as_dict()
    if windows:
        answer["stable_windows"] = _windows(described, up_to, unbalance)
    answer["ignores"] = {name: unknown(described, theory_of(name)) for name in names or NAMES}
    with unwarned(RangeWarning):  # which says what is ignored, as the lines of these numbers do
        for key, speed in (("viscosity", minimum_viscosity_at), ("drag", minimum_drag_at)):
            if speed is not None:
                answer[f"minimum_{key}"] = _minimum(key, described, speed, unbalance, names)
    lines = [*_lines(answer), *(f"{name}: {text}" for name, text in friction_rows(held, speed_text, brief=True))]
    if not over:
        return Reply(None, answer, described.name, (), _columns(answer["borders"]), lines=lines, brief=True)
    curve = _curve(described, over, names, up_to)
    own = "" if unbalance is None else f", but with an unbalance of {moment_text(unbalance)}"
    lines = [f"beside the table, the machine as its file describes it{own}:", *lines]
    answer["over"] = {str(key): curve[key].values for key in (*curve.dims, *curve.data_vars)}
    return Reply(
        curve,
        answer,
        described.name,
        lines=lines,
        notes=(),
        draw=lambda: ab.plot.answer(curve, speed_unit=speed_sign()),
    )


def _windows(machine: Any, top: float | None, unbalance: float | None) -> dict[str, Any]:
    from autobalancer.assembly.drive_train import highest_prescribed
    from autobalancer.stability.maps.exact import stable_windows

    highest = top if top is not None else highest_prescribed(machine)
    if highest is None:
        raise QuestionError("--windows: the drive has no highest speed; give one with --up-to")
    found = stable_windows(machine, highest, unbalance=unbalance)
    return {"up_to": highest, "windows": [list(pair) for pair in found.windows], "note": found.note}


def _names(only: str) -> tuple[str, ...]:
    """ "exact border, worst case" has a comma of its own."""
    from autobalancer.stability.maps.exact import NAMES

    left, found = only, []
    for name in sorted(NAMES, key=len, reverse=True):
        if name in left:
            found.append(name)
            left = left.replace(name, "")
    return tuple(found) if not left.strip(" ,") else (left.strip(" ,"),)


def _minimum(key: str, machine: Any, speed: float, unbalance: float | None, names: tuple[str, ...]) -> dict[str, float]:
    """Least viscosity or drag for a speed, by each kind of border that the machine has."""
    ask = ab.stability.minimum_viscosity if key == "viscosity" else ab.stability.minimum_drag
    kinds = ("exact border", "exact border, worst case", "averaged border", "release speed", "capture speed")
    there = {border.name for border in ab.stability.borders(machine, only=names) if not math.isnan(border.speed)}
    found = {name: ask(machine, speed, name, unbalance=unbalance) for name in kinds if name in there}
    return {"speed": float(speed), **found}


def _curve(machine: Any, over: str, names: tuple[str, ...], top: float | None) -> Answer:
    from autobalancer.cli.terminal.options import named_range, parameter_values
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.stability.maps.curve import border_curve

    name, span = named_range("--over", over)
    values = parameter_values("--over", over, machine)[1] if span else _usual(name)
    with progress_bar(name) as update:
        return border_curve(machine, name, values, only=names, up_to=top, progress=update)


def _usual(name: str) -> Any:
    """Values for a parameter that was named without any: viscosities of the catalog; nothing for others."""
    import numpy as np

    return np.geomspace(0.2e-6, 200e-6, 121) if name == "viscosity" else None


def _columns(borders: list[dict[str, Any]]) -> list[Column]:
    from autobalancer.results.display_units import speed_axis
    from autobalancer.stability.border import Border
    from autobalancer.tables import Column

    unit = speed_axis(speed_sign())
    return [
        Column("border", [border["name"] for border in borders]),
        Column("speed", [Border(**border).cell(unit.factor) for border in borders], unit.sign),
        Column("note", [border["note"] for border in borders], wraps=True),
    ]


def _lines(answer: dict[str, Any]) -> list[str]:
    """Borders with their notes, stable ranges and minima as sentences."""
    width = max((len(border["name"]) for border in answer["borders"]), default=0)
    from autobalancer.stability.border import Border

    lines: list[str] = []
    for border in answer["borders"]:
        lines.append(f"{border['name']:<{width}}   {Border(**border).text(speed_text)}")
        lines += [f"  {border['note']}"] if border["note"] else []
    if "stable_windows" in answer:
        windows = answer["stable_windows"]
        lines.append(f"stable up to {speed_text(windows['up_to'])}:{'' if windows['windows'] else ' nowhere'}")
        lines += [f"  {speed_text(low)} to {speed_text(high)}" for low, high in windows["windows"]]
        lines += [f"  {windows['note']}"] if windows["note"] else []
    for key, factor, unit in (("viscosity", 1e6, "mm^2/s"), ("drag", 1.0, "N m s")):
        if f"minimum_{key}" in answer:
            found = dict(answer[f"minimum_{key}"])
            lines.append(f"least {key} for {speed_text(found.pop('speed'))} and above:")
            for which, value in found.items():
                ignored = ", ".join(answer["ignores"][which])
                says = f"   (ignores {ignored})" if ignored else ""
                lines.append(f"  {which}: {_amount(value * factor, unit)}{says}")
    return lines


def _amount(value: float, unit: str) -> str:
    return "none is enough" if math.isinf(value) else "any" if value == 0.0 else f"{value:.4g} {unit}"


# ``autobalancer branches``: steady states and periodic motions along a parameter.


DOUBLING = "period doubling"
FEW = 3  # period doublings of a branch that are listed unasked


@command("stability.branches", take="switch orbits", draw=True, unit="speed")
def branches(
    machine: MachineFile,
    over: Annotated[str, '"NAME=from:to", such as "speed=55 rad/s:110 rad/s"; also downwards.'],
    speed: Speed = None,
    state: Annotated[
        str, "Where to begin: balanced, mixed, coincident, 'in line', spread, stalled, 'partly stalled' or all."
    ] = "balanced",
    every: Annotated[
        bool, typer.Option("--all", help=f"List all period doublings of a branch, not only {FEW}.")
    ] = False,
    **options: Any,
) -> Reply:
    """Follow the states in which the balls rest, and their periodic motions, and list where they begin or lose stability.

    A NAME is speed, unbalance, drag, viscosity, ball_mass, damping, stiffness, or a path such as rotor.damping. Names
    joined by & change in proportion: "ball_mass & drag".

    Example: autobalancer branches discoidal.toml \\
      --over "speed=40 rad/s:110 rad/s" --state all --plot branches.png
    """
    from autobalancer.cli.terminal.options import named_range, unit_of
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.units.quantity import ends

    described, update = load_race_machine(machine), options.pop("progress")
    parameter, span = named_range("--over", over, "from:to")
    start, end = ends("--over", span, unit_of("--over", parameter, described))
    found = ab.stability.branches(
        described,
        parameter,
        start,
        end,
        speed=speed,
        from_state=state,  # type: ignore[arg-type]
        progress=lambda number, share: update(share, 1.0, description=f"branch {number}"),
        **options,
    )
    special, why = found.special_rows(), found.not_followed()
    shown = special if every else _without_cascades(special)
    more = f"{len(special) - len(shown)} more {DOUBLING}s are not shown; --all lists them"
    numbers = {"parameter": parameter, "ignores": found.attrs["ignores"], **({"not_followed": why} if why else {})}
    return Reply(
        found,
        {**numbers, "branches": found.branch_rows(), "special": special},
        more=[("special points", found.special_columns(shown, speed_sign()))] if shown else [],
        lines=[*([more] if len(shown) < len(special) else []), *why],
        notes=(),
    )


def _without_cascades(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The first period doublings of each branch, and everything else."""
    kept, seen = [], dict[int, int]()
    for row in rows:
        if row["type"] == DOUBLING:
            seen[row["branch"]] = seen.get(row["branch"], 0) + 1
        if row["type"] != DOUBLING or seen[row["branch"]] <= FEW:
            kept.append(row)
    return kept


# ``autobalancer eigenvalues``: eigenvalues of a steady state over the speed.


@command("stability.eigenvalues", draw=True, unit="speed", bar="speeds")
def eigenvalues(
    machine: MachineFile,
    speeds: Annotated[
        Any,
        Speeds(COUNT),
        '"from:to" or "from:to:count", or one speed; by default from half to three times the critical speeds that the '
        "machine reaches, and at least up to its highest speed.",
    ] = None,
    state: Annotated[
        str, "balanced, coincident, 'in line', mixed: at some stations at rest, or spread: by forces."
    ] = "balanced",
    unbalance: Unbalance = None,
    **options: Any,
) -> Reply:
    """Say in which speed ranges a steady state is stable, exactly: eigenvalues, or multipliers on anisotropic supports.

    Example: autobalancer eigenvalues discoidal.toml \\
      --speeds "500 rpm:1500 rpm:200" --plot s.png
    """
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.states.questions import Kind, ranges

    one_of("--state", state, *get_args(Kind))
    described = load_race_machine(machine)
    chosen = [float(speed) for speed in (speeds if speeds is not None else usual_speeds(described))]
    found = ab.stability.eigenvalues(described, chosen, state=state, unbalance=unbalance, **options)  # type: ignore[arg-type]
    located = cache(lambda: ranges(described, found, unbalance))
    ignores = [text for text in found.remarks() if text.startswith("ignores ")]
    return Reply(
        found,
        heading=f"{described.name}: {state} state" + (f"; {ignores[0]}" if ignores else ""),
        notes=[text for text in found.remarks() if text not in ignores],
        columns=located().columns(speed_sign()),
        draw=lambda: ab.plot.answer(found, speed_unit=speed_sign(), ranges=located()),
    )


def usual_speeds(machine: Any) -> np.ndarray:
    """Speeds around the critical ones that the machine reaches."""
    import numpy as np

    from autobalancer.assembly.drive_train import highest_prescribed
    from autobalancer.stability.summary import frame_of

    highest = highest_prescribed(machine)
    critical = frame_of(machine, highest).critical_speeds
    if not critical:
        raise QuestionError("--speeds: this rotor has no critical speed to choose a range by; give one")
    # bending speeds far above all that the machine runs at say nothing
    reached = [w for w in critical if w <= (highest or math.inf)] or [min(critical)]
    return np.linspace(0.5 * min(critical), max(3.0 * max(reached), highest or 0.0), COUNT)


# ``autobalancer map``: the growth rate of the balanced state over two parameters.


@command("stability.map", take="positions", draw=True, unit="speed", bar="map")
def map_(
    machine: MachineFile,
    x: Annotated[str, 'Along x: "NAME=from:to:count", with ":log" for equal ratios.'],
    y: Annotated[str, "Along y, in the same form."],
    speed: Speed = None,
    point: Annotated[list[str] | None, 'Operating point "NAME=x value, y value". May be repeated.'] = None,
    **options: Any,
) -> Reply:
    """Find where the balanced state is stable, with averaged border, exact border, release and capture speed.

    A NAME is speed, viscosity, drag, ball_mass, ball_diameter, count, unbalance, damping, stiffness, temperature,
    plateau, rolling_resistance, or a path such as rotor.damping.

    Example: autobalancer map discoidal.toml \\
      --x "speed=50 rad/s:130 rad/s:400" \\
      --y "viscosity=0.2 mm^2/s:100 mm^2/s:400:log" --plot map.png
    """
    from autobalancer.cli.terminal.options import parameter_values
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.results.store import result_csv

    described = load_race_machine(machine)
    (across, x_values), (up, y_values) = (parameter_values(*axis, described) for axis in (("--x", x), ("--y", y)))
    if across == up:
        raise QuestionError(f"--y: given {up!r}, which is along --x already; take two different parameters")
    points = dict(_point(text) for text in point or [])
    axes = {across: x_values, up: y_values}
    found = ab.stability.map(described, axes, speed=speed, operating_points=points, **options)
    rates = found["growth_rate"].values
    numbers = {str(name): found[name].values for name in (*found.dims, *found.data_vars)}
    return Reply(found, {"points": rates.size, "stable": int((rates < 0.0).sum()), **numbers}, csv=result_csv(found))


def _point(text: str) -> tuple[str, tuple[str, str]]:
    name, _, values = text.partition("=")
    pair = [value.strip() for value in values.split(",")]
    if not name.strip() or len(pair) != 2 or not all(pair):
        raise QuestionError(
            f"--point: given {text!r}; write it as \"NAME=x value, y value\", such as 'measured=64 rad/s, 0.65 mm^2/s'"
        )
    return name.strip(), (pair[0], pair[1])
