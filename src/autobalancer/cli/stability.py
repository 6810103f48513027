"""Commands that answer before a run."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import note, say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    import numpy as np

    from autobalancer.stability.diagrams.explorer import Branches
    from autobalancer.stability.maps.curve import BorderCurve
    from autobalancer.tables import Column


# ``autobalancer check``: what can be said of a machine before it runs.


def check(
    machine: MachineFile,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Check a machine file and print its masses, critical speeds, capability, drag and border speeds.

    Of a machine with deep chambers: filling, contact time and step in place of drag and borders.

    Example: autobalancer check discoidal.toml
    """
    from autobalancer.api import check as known
    from autobalancer.cli.terminal.command import one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import Facts
    from autobalancer.progress import looking_for

    one_form(as_json, as_csv)
    found = known(machine, looking_for)
    if as_json:
        print_json(found.as_dict())
        return
    table = Facts(found.name)
    for row in found.rows(speed_text):
        table.add_row(*row)
    if as_csv:
        print_csv(table.columns())
        return
    table.print()
    for warning in found.warnings:
        note(warning)


# ``autobalancer borders``: the border speeds of a machine, over a parameter, and the least viscosity for a speed.


def borders(
    machine: MachineFile,
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default the largest of the machine.')] = "",
    windows: Annotated[
        bool, typer.Option("--windows", help="Also list all stable speed ranges up to --up-to.")
    ] = False,
    over: Annotated[
        str, typer.Option(help='Borders over a parameter, "NAME=from:to:count[:log]"; unbalance and viscosity alone.')
    ] = "",
    only: Annotated[
        str, typer.Option(help='Only these, with commas between: "release speed, capture speed" are found fast.')
    ] = "",
    up_to: Annotated[
        str, typer.Option(help="Highest speed, for release, capture and --windows; by default that of the drive.")
    ] = "",
    minimum_viscosity_at: Annotated[str, typer.Option(help='Least viscosity for this speed, "1200 rpm".')] = "",
    minimum_drag_at: Annotated[str, typer.Option(help="Least drag for this speed.")] = "",
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the averaged border, the exact border, the release speed and the capture speed, each with its notes.

    With --over also as a table over a parameter, which --out and --plot write.

    Example: autobalancer borders discoidal.toml \\
      --over unbalance --plot borders.png --minimum-viscosity-at "1200 rpm"
    """
    from autobalancer.assembly.terms import unknown
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError, RangeWarning, unwarned
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.friction import held_by_friction
    from autobalancer.stability.maps.speeds import NAMES, theory_of
    from autobalancer.stability.summary import friction_rows

    one_form(as_json, as_csv)
    if (out or plot is not None) and not over:
        raise QuestionError("borders: --out and --plot show the borders over a parameter; name it with --over")
    files = Files(out, plot)
    size, top = optional("--unbalance", unbalance, "kg*m"), optional("--up-to", up_to, "rad/s")
    described = load_race_machine(machine)
    names = _names(only)
    answer: dict[str, Any] = {
        "borders": [vars(border) for border in ab.stability.borders(described, size, only=names, up_to=top)],
    }
    held = held_by_friction(described, unbalance=size)
    answer["friction"] = held.as_dict()
    if windows:
        answer["stable_windows"] = _windows(described, top, size)
    answer["ignores"] = {name: unknown(described, theory_of(name)) for name in names or NAMES}
    with unwarned(RangeWarning):  # which says what is ignored, as the lines of these numbers do
        answer |= _minima(described, minimum_viscosity_at, minimum_drag_at, size, names)
    curve = _curve(described, over, names, top) if over else None
    if curve is not None:
        files.save(curve, lambda: ab.plot.border_curve(curve, speed_unit=speed_unit))
        answer["over"] = {str(key): curve[key].values for key in (*curve.dims, *curve.data_vars)}
    if as_json:
        print_json({"machine": str(machine), **answer})
        return
    table = _columns(answer["borders"]) if curve is None else curve.columns(speed_sign())
    if as_csv:
        print_csv(table)
        return
    _print(described.name, answer)
    for name, text in friction_rows(held, speed_text, brief=True):
        say(f"{name}: {text}", indent="  ")
    if curve is not None:
        print_sheet(table, f"over {curve[str(next(iter(curve.dims)))].attrs['long_name']}")
    files.say()


def _windows(machine: Any, top: float | None, unbalance: float | None) -> dict[str, Any]:
    from autobalancer.errors import QuestionError
    from autobalancer.stability.maps.exact import stable_windows
    from autobalancer.stability.summary import summary

    highest = top if top is not None else summary(machine).highest_speed
    if highest is None:
        raise QuestionError("--windows: the drive has no highest speed; give one with --up-to")
    found = stable_windows(machine, highest, unbalance=unbalance)
    return {"up_to": highest, "windows": [list(pair) for pair in found.windows], "note": found.note}


def _names(only: str) -> tuple[str, ...]:
    """ "exact border, worst case" has a comma of its own."""
    from autobalancer.stability.maps.speeds import NAMES

    left, found = only, []
    for name in sorted(NAMES, key=len, reverse=True):
        if name in left:
            found.append(name)
            left = left.replace(name, "")
    return tuple(found) if not left.strip(" ,") else (left.strip(" ,"),)


def _minima(
    machine: Any, viscosity_at: str, drag_at: str, unbalance: float | None, names: tuple[str, ...]
) -> dict[str, Any]:
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.stability.maps.curve import minimum_drag, minimum_viscosity

    found: dict[str, Any] = {}
    for key, text, ask in (("viscosity", viscosity_at, minimum_viscosity), ("drag", drag_at, minimum_drag)):
        if text:
            speed = quantity(f"--minimum-{key}-at", text, "rad/s")
            found[f"minimum_{key}"] = {
                "speed": float(speed),
                **{name: ask(machine, speed, name, unbalance=unbalance) for name in _asked(machine, names)},
            }
    return found


def _asked(machine: Any, names: tuple[str, ...]) -> list[str]:

    kinds = ("exact border", "exact border, worst case", "averaged border", "release speed", "capture speed")
    there = {border.name for border in ab.stability.borders(machine, only=names) if not math.isnan(border.speed)}
    return [name for name in kinds if name in there]


def _curve(machine: Any, over: str, names: tuple[str, ...], top: float | None) -> BorderCurve:
    from autobalancer.cli.terminal.options import named, parameter_values
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.stability.maps.curve import border_curve

    name, span = named("--over", over)
    values = parameter_values("--over", over, machine)[1] if span else _usual(name)
    with progress_bar(name) as update:
        return border_curve(machine, name, values, only=names, up_to=top, progress=update)


def _usual(name: str) -> Any:
    """Values for a parameter that was named without any: viscosities of the catalog; nothing for others."""
    import numpy as np

    return np.geomspace(0.2e-6, 200e-6, 121) if name == "viscosity" else None


def _columns(borders: list[dict[str, Any]]) -> list[Column]:
    from autobalancer.tables import Column

    return [
        Column("border", [border["name"] for border in borders]),
        Column("speed", [_number(border["speed"]) for border in borders], speed_sign()),
        Column("note", [border["note"] for border in borders], wraps=True),
    ]


def _number(speed: float) -> float | str | None:
    """What a table shows of a border: *never* is a statement, too."""
    if math.isnan(speed):
        return None
    return "never" if math.isinf(speed) else float(speed_number(speed, ".10g"))


def _print(name: str, answer: dict[str, Any]) -> None:
    typer.secho(name, bold=True)
    width = max((len(border["name"]) for border in answer["borders"]), default=0)
    for border in answer["borders"]:
        typer.echo(f"{border['name']:<{width}}   {speed_text(border['speed']) if border['known'] else 'not known'}")
        if border["note"]:
            say(border["note"], indent="  ", first="  ")
    if "stable_windows" in answer:
        windows = answer["stable_windows"]
        typer.echo(f"stable up to {speed_text(windows['up_to'])}:{'' if windows['windows'] else ' nowhere'}")
        for low, high in windows["windows"]:
            typer.echo(f"  {speed_text(low)} to {speed_text(high)}")
        if windows["note"]:
            say(windows["note"], indent="  ", first="  ")
    for key, factor, unit in (("viscosity", 1e6, "mm^2/s"), ("drag", 1.0, "N m s")):
        if f"minimum_{key}" in answer:
            found = dict(answer[f"minimum_{key}"])
            typer.echo(f"least {key} for {speed_text(found.pop('speed'))} and above:")
            for which, value in found.items():
                ignored = ", ".join(answer["ignores"][which])
                says = f"   (ignores {ignored})" if ignored else ""
                say(f"  {which}: {_amount(value * factor, unit)}{says}", indent="    ")


def _amount(value: float, unit: str) -> str:
    return "none is enough" if math.isinf(value) else "any" if value == 0.0 else f"{value:.4g} {unit}"


# ``autobalancer branches``: steady states and periodic motions along a parameter.


DOUBLING = "period doubling"
FEW = 3  # period doublings of a branch that are listed unasked


def branches(
    machine: MachineFile,
    over: Annotated[str, typer.Option(help='"NAME=from:to", such as "speed=55 rad/s:110 rad/s"; also downwards.')],
    speed: Annotated[str, typer.Option(help='Rotor speed where it is not the parameter, such as "1200 rpm".')] = "",
    state: Annotated[
        str,
        typer.Option(
            help="Where to begin: balanced, mixed, coincident, 'in line', spread, stalled, 'partly stalled' or all."
        ),
    ] = "balanced",
    switch: Annotated[bool, typer.Option(help="Go on along what branches off.")] = True,
    orbits: Annotated[bool, typer.Option(help="Follow periodic motions born at Hopf points.")] = True,
    every: Annotated[
        bool, typer.Option("--all", help=f"List all period doublings of a branch, not only {FEW}.")
    ] = False,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Follow the states in which the balls rest, and their periodic motions, and list where they begin or lose stability.

    A NAME is speed, unbalance, drag, viscosity, ball_mass, damping, stiffness, or a path such as rotor.damping. Names
    joined by & change in proportion: "ball_mass & drag".

    Example: autobalancer branches discoidal.toml \\
      --over "speed=40 rad/s:110 rad/s" --state all --plot branches.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import named, optional, unit_of
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.diagrams.branches import branches as ask
    from autobalancer.units.quantity import ends

    one_form(as_json, as_csv)
    files = Files(out, plot)
    described = load_race_machine(machine)
    parameter, span = named("--over", over, "from:to")
    start, end = ends("--over", span, unit_of("--over", parameter, described))
    with progress_bar("branch") as update:
        found = ask(
            described,
            parameter,
            start,
            end,
            speed=optional("--speed", speed, "rad/s"),
            from_state=state,  # type: ignore[arg-type]
            switch=switch,
            orbits=orbits,
            progress=lambda number, share: update(share, 1.0, description=f"branch {number}"),
        )
    files.save(found, lambda: ab.plot.branches(found, speed_unit=speed_unit))
    if as_json:
        rows = {"branches": found.branch_rows(), "special": found.special_rows()}
        about = {"machine": str(machine), "parameter": parameter, "ignores": found.attrs["ignores"]}
        missing = {"not_followed": said} if (said := found.not_followed()) else {}
        print_json({**about, **missing, **rows})
        return
    if as_csv:
        print_csv(found.columns(speed_unit))
        return
    _branches_print(found, speed_unit, every)
    files.say()


def _branches_print(found: Branches, speed_unit: str, every: bool) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet, say

    print_sheet(found.columns(speed_unit), found.heading())
    rows = found.special_rows()
    shown = rows if every else _without_cascades(rows)
    if shown:
        print_sheet(found.special_columns(shown, speed_unit), "special points")
    if len(shown) < len(rows):
        say(f"{len(rows) - len(shown)} more {DOUBLING}s are not shown; --all lists them")
    for line in found.not_followed():
        say(line)


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


COUNT = 401  # speeds in a range that gives no count


def stability(
    machine: MachineFile,
    speeds: Annotated[
        str,
        typer.Option(
            help='"from:to" or "from:to:count", or one speed; by default from half to three times the critical speeds that the '
            "machine reaches, and at least up to its highest speed."
        ),
    ] = "",
    state: Annotated[
        str,
        typer.Option(help="balanced, coincident, 'in line', mixed: at some stations at rest, or spread: by forces."),
    ] = "balanced",
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; by default that of the machine.')] = "",
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Say in which speed ranges a steady state is stable, exactly: eigenvalues, or multipliers on anisotropic supports.

    Example: autobalancer eigenvalues discoidal.toml \\
      --speeds "500 rpm:1500 rpm:200" --plot s.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, speed_range
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.stability.states.questions import Kind, eigenvalues, ranges

    one_form(as_json, as_csv)
    files = Files(out, plot)
    if state not in get_args(Kind):
        raise QuestionError(f"--state: given {state!r}; must be balanced, mixed, coincident, 'in line' or spread")
    described = load_race_machine(machine)
    chosen = speed_range("--speeds", speeds, COUNT) if speeds else _eigenvalues_usual(machine)
    size = optional("--unbalance", unbalance, "kg*m")
    with progress_bar("speeds") as update:
        found = eigenvalues(
            described,
            [float(speed) for speed in chosen],
            state=state,  # type: ignore[arg-type]
            unbalance=size,
            progress=update,
        )
    located = cache(lambda: ranges(described, found, size))
    files.save(found, lambda: ab.plot.eigenvalues(found, speed_unit=speed_unit, ranges=located()))
    missing = [float(w) for w in found.attrs["speeds_without_state"]]
    if as_json:
        names = ("speed", "growth_rate", "verdict", "leading_motion")
        rows = [
            dict(zip(names, row, strict=True))
            for row in zip(*(found[name].values.tolist() for name in names), strict=True)
        ]
        print_json(
            {
                "machine": str(machine),
                "state": state,
                "ignores": found.attrs["ignores"],
                "rows": rows,
                "speeds_without_state": missing,
            }
        )
        return
    table = located().columns(speed_unit)
    if as_csv:
        print_csv(table)
        return
    ignores = f"; ignores {found.attrs['ignores']}" if found.attrs["ignores"] else ""
    print_sheet(table, f"{described.name}: {state} state{ignores}")
    if missing:
        typer.echo(f"no such state at {len(missing)} of the speeds")
    files.say()


def _eigenvalues_usual(machine: object) -> np.ndarray:
    import numpy as np

    from autobalancer.errors import QuestionError
    from autobalancer.stability.summary import summary

    about = summary(machine)  # type: ignore[arg-type]
    critical = about.critical_speeds
    if not critical:
        raise QuestionError("--speeds: this rotor has no critical speed to choose a range by; give one")
    # bending speeds far above all that the machine runs at say nothing
    reached = [w for w in critical if w <= (about.highest_speed or math.inf)] or [min(critical)]
    return np.linspace(0.5 * min(critical), max(3.0 * max(reached), about.highest_speed or 0.0), COUNT)


# ``autobalancer map``: the growth rate of the balanced state over two parameters.


def map_(
    machine: MachineFile,
    x: Annotated[str, typer.Option(help='Along x: "NAME=from:to:count", with ":log" for equal ratios.')],
    y: Annotated[str, typer.Option(help="Along y, in the same form.")],
    speed: Annotated[str, typer.Option(help='Rotor speed where it is not an axis, such as "1200 rpm".')] = "",
    positions: Annotated[str, typer.Option(help="Of more than two balls: worst or best.")] = "worst",
    point: Annotated[
        list[str] | None, typer.Option(help='Operating point "NAME=x value, y value". May be repeated.')
    ] = None,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Find where the balanced state is stable, with averaged border, exact border, release and capture speed.

    A NAME is speed, viscosity, drag, ball_mass, ball_diameter, count, unbalance, damping, stiffness, temperature,
    plateau, rolling_resistance, or a path such as rotor.damping.

    Example: autobalancer map discoidal.toml \\
      --x "speed=50 rad/s:130 rad/s:400" \\
      --y "viscosity=0.2 mm^2/s:100 mm^2/s:400:log" --plot map.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_json
    from autobalancer.cli.terminal.options import optional, parameter_values
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.results.export import result_csv

    one_form(as_json, as_csv)
    files = Files(out, plot)
    fixed = optional("--speed", speed, "rad/s")
    described = load_race_machine(machine)
    (across, x_values), (up, y_values) = (parameter_values(*axis, described) for axis in (("--x", x), ("--y", y)))
    if across == up:
        raise QuestionError(f"--y: given {up!r}, which is along --x already; take two different parameters")
    with progress_bar("map") as update:
        found = ab.stability.map(
            described,
            {across: x_values, up: y_values},
            speed=fixed,
            positions=positions,  # type: ignore[arg-type]
            operating_points=dict(_point(text) for text in point or []),
            progress=update,
        )
    files.save(found, lambda: ab.plot.map(found, speed_unit=speed_unit))
    if as_json:
        rates = found["growth_rate"].values
        names = {str(name): found[name].values for name in (*found.dims, *found.data_vars)}
        print_json({"machine": str(machine), "points": rates.size, "stable": int((rates < 0.0).sum()), **names})
        return
    if as_csv:
        typer.echo(result_csv(found), nl=False)
        return
    say("; ".join((found.stable_text(), *found.remarks())))
    if held := found.held_text():
        say(f"friction: {held}")
    files.say()


def _point(text: str) -> tuple[str, tuple[str, str]]:
    from autobalancer.errors import QuestionError

    name, _, values = text.partition("=")
    pair = [value.strip() for value in values.split(",")]
    if not name.strip() or len(pair) != 2 or not all(pair):
        raise QuestionError(
            f"--point: given {text!r}; write it as \"NAME=x value, y value\", such as 'measured=64 rad/s, 0.65 mm^2/s'"
        )
    return name.strip(), (pair[0], pair[1])
