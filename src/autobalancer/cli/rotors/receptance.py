"""``autobalancer receptance``: stability from a hammer test."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.cli.terminal.sheet import Column
    from autobalancer.machine import Machine
    from autobalancer.measurement.loop.balls import RaceBalls


def receptance(
    file: Annotated[Path, typer.Argument(help="Table with units in its column names, or universal file (type 58).")],
    machine: Annotated[
        Path | None, typer.Option(help="Machine file: takes its balls and its largest unbalance.")
    ] = None,
    balls: Annotated[int, typer.Option(help="Without a machine: number of equal balls.")] = 0,
    ball_mass: Annotated[str, typer.Option(help='Mass of one, such as "7.6 g".')] = "",
    orbit_radius: Annotated[str, typer.Option(help='Of the ball centers, such as "77 mm".')] = "",
    drag: Annotated[str, typer.Option(help='beta of one ball, such as "5.5e-6 N*m*s".')] = "",
    with_balls: Annotated[bool, typer.Option("--with-balls", help="The balls were on the rotor in the test.")] = False,
    unbalance: Annotated[str, typer.Option(help='Such as "594 g*mm"; or "any": worst case.')] = "",
    speed: Annotated[
        list[str] | None, typer.Option(help='Margins at this speed, such as "1200 rpm". May be repeated.')
    ] = None,
    search: Annotated[
        str, typer.Option(help='Speeds in which to look for the border, "from:to": "500 rpm:3000 rpm".')
    ] = "",
    modes: Annotated[int, typer.Option(help="Number of modes to fit; by default chosen by the noise.")] = 0,
    band: Annotated[str, typer.Option(help='Frequencies used in the fit, "from:to": "5 Hz:200 Hz".')] = "",
    noise: Annotated[
        str, typer.Option(help="estimated from the data; relative (to each value); or absolute.")
    ] = "estimated",
    function: Annotated[int, typer.Option(help="Which function of a universal file.")] = 0,
    resamples: Annotated[int, typer.Option(help="Repeated fits for the uncertainty of the border.")] = 20,
    mass_added: Annotated[
        str, typer.Option(help='Fixed to the rotor in the test and no part of it, such as "20 g": is taken off.')
    ] = "",
    out: Annotated[
        list[Path] | None,
        typer.Option(
            help="Result file, .nc, .csv or .json; or .toml, the file of --machine with a rotor of the fitted modes. May be "
            "repeated."
        ),
    ] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Picture, .png, .svg or .pdf: the loop at the first speed, else the fit.")
    ] = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Exact border, least drag and margins from a measured receptance, without a model of the rotor.

    Example: autobalancer receptance discoidal_hammer.csv \\
      --machine discoidal.toml --speed "1200 rpm"
    """
    from autobalancer.cli.terminal.output import MACHINE, RESULT, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.loop.border import receptance_border
    from autobalancer.measurement.loop.curve import receptance_loop
    from autobalancer.measurement.loop.growth import receptance_stability
    from autobalancer.rotordynamics.receptance.measured import load_receptance
    from autobalancer.units.ranges import ends

    one_form(as_json, as_csv)
    files = Files(out, plot, allowed=(*RESULT, *MACHINE))
    speeds = [quantity("--speed", text, "rad/s") for text in speed or []]
    searched = ends("--search", search, "rad/s") if search else None
    chosen = _balls(machine, balls, ball_mass, orbit_radius, drag)
    written = any(path.suffix.lower() in MACHINE for path in files.out)
    if written and (machine is None or with_balls):
        raise QuestionError(
            "--out: a machine file wants --machine, which is written with this rotor, and the rotor without balls: give the mass "
            "of those that were on it as --mass-added, not --with-balls"
        )
    measured = load_receptance(file, function=function or None, mass_added=mass_added or None)
    used = ends("--band", band, "rad/s") if band else None
    how: dict[str, Any] = {"balls_on_rotor": with_balls, "unbalance": _unbalance(machine, unbalance, chosen)}
    with progress_bar("fit") as update:
        fit = ab.measure.receptance(measured, modes=modes or None, noise=noise, band=used, progress=update)  # type: ignore[arg-type]
    with progress_bar("border") as update:
        border = receptance_border(fit, chosen, searched=searched, resamples=resamples, progress=update, **how)
    at_speeds = receptance_stability(fit, chosen, speeds, **how) if speeds else None
    loops = [receptance_loop(fit, chosen, speed, balls_on_rotor=with_balls) for speed in speeds]
    files.save(
        fit if at_speeds is None else at_speeds,
        lambda: ab.plot.nyquist(loops[0]) if loops else ab.plot.receptance(fit),
        machine=_with_rotor(machine, fit) if machine is not None and written else None,
    )
    if as_json:
        print_json(_numbers(fit, border, at_speeds, loops) | {"ignores": _ignored(machine)})
        return
    if as_csv:
        print_csv(_modes(fit) if at_speeds is None else _margins(at_speeds))
        return
    _show(fit, border, at_speeds, loops, machine)
    files.say()


def _with_rotor(machine: Path, fit: xr.Dataset) -> Machine:
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.receptance.rotor import measured_rotor, with_measured_rotor

    return with_measured_rotor(load_race_machine(machine), measured_rotor(fit))


def _balls(machine: Path | None, count: int, mass: str, radius: str, drag: str) -> RaceBalls:
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.loop.balls import balls_of, equal_balls

    if machine is not None:
        return balls_of(machine)
    if count < 1 or not (mass and radius and drag):
        raise QuestionError("give --machine, or --balls, --ball-mass, --orbit-radius and --drag")
    given = (("--ball-mass", mass, "kg"), ("--orbit-radius", radius, "m"), ("--drag", drag, "N*m*s"))
    numbers = (quantity(*option) for option in given)
    return equal_balls(count, *numbers, spin_ratio=0.4)


def _unbalance(machine: Path | None, text: str, balls: RaceBalls) -> float | None:
    from autobalancer.assembly.profile import largest_unbalance
    from autobalancer.cli.terminal.quantities import quantity
    from autobalancer.files.machine_file import load_race_machine

    if text == "any" or (not text and (machine is None or balls.count > 2)):
        return None
    return quantity("--unbalance", text, "kg*m") if text else abs(largest_unbalance(load_race_machine(machine or "")))


def _numbers(
    fit: xr.Dataset, border: xr.Dataset, at_speeds: xr.Dataset | None, loops: list[xr.Dataset]
) -> dict[str, Any]:
    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    numbers: dict[str, Any] = {
        "fit": {
            "modes": int(fit.attrs["modes"]),
            "error": float(fit.attrs["fit_error"]),
            "effective_mass": float(fit.attrs["effective_mass"]),
            "band": [float(fit.attrs["band_low"]), float(fit.attrs["band_high"])],
            "poles": [[float(p.real), float(p.imag)] for p in poles],
            **{name: fit[name].values.tolist() for name in map(str, fit.data_vars) if name.startswith("mode_")},
        },
        "exact_border": border.attrs["exact_border"],
        "exact_border_deviation": border.attrs["exact_border_deviation"],
        "state": border.attrs["state"],
        "stable": [
            list(pair)
            for pair in zip(border["stable_from"].values.tolist(), border["stable_to"].values.tolist(), strict=True)
        ],
        "warnings": [text for text in border.attrs["warnings"].split("\n") if text],
    }
    if at_speeds is not None:
        numbers["speeds"] = [
            {"speed": float(s), **{str(name): at_speeds[name].values[i].item() for name in at_speeds.data_vars}}
            | {f"{name}_of_evenly_spread_balls": loops[i].attrs[name] for name in ("gain_margin", "phase_margin")}
            for i, s in enumerate(at_speeds["speed"].values)
        ]
        numbers["warnings"] = sorted({*numbers["warnings"], *filter(None, at_speeds.attrs["warnings"].split("\n"))})
    return numbers


def _modes(fit: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    columns = []
    for name, factor, unit in (("frequency", 0.5 / math.pi, "Hz"), ("damping_ratio", 100.0, "%"), ("mass", 1.0, "kg")):
        for end, more in (("", ""), ("_deviation", ", standard deviation")):
            columns.append(Column(name.replace("_", " ") + more, factor * fit[f"mode_{name}{end}"].values, unit))
    return columns


def _margins(at_speeds: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    across = [float(speed_number(w, ".10g")) for w in at_speeds["speed"].values]
    return [
        Column("speed", across, speed_sign()),
        Column("growth rate", at_speeds["growth_rate"].values, "1/s"),
        Column("least drag over that given", at_speeds["drag_factor"].values),
        Column("gain margin", at_speeds["gain_margin"].values),
        Column("phase margin", [math.degrees(value) for value in at_speeds["phase_margin"].values], "deg"),
    ]


def _show(
    fit: xr.Dataset, border: xr.Dataset, at_speeds: xr.Dataset | None, loops: list[xr.Dataset], machine: Path | None
) -> None:
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.measurement.loop.growth import viscosity_of

    a = fit.attrs
    rows = [("fit", f"error {100.0 * a['fit_error']:.2g} %, mass {a['effective_mass']:.4g} kg")]
    rows += [("mode", _mode_text(fit.isel(mode=i))) for i in range(fit.sizes["mode"])]
    name = "exact border" + (", worst case" if border.attrs["state"].startswith("worst") else "")
    ignored = _ignored(machine)
    rows.append((name, "; ".join(filter(None, (_border(border), ignored)))))
    for low, high in zip(border["stable_from"].values, border["stable_to"].values, strict=True):
        rows.append(("stable", f"{speed_text(low)} to {speed_text(high)}"))
    viscosity = viscosity_of(machine) if machine is not None else None
    doubts = {*border.attrs["warnings"].split("\n")}
    if at_speeds is not None:
        told = [_row(at_speeds.isel(speed=i), loops[i], viscosity) for i in range(at_speeds.sizes["speed"])]
        rows += [(label, "; ".join(filter(None, (text, ignored)))) for label, text in told]
        doubts |= {*at_speeds.attrs["warnings"].split("\n")}
    print_facts(rows, str(a["title"]))
    for text in sorted(filter(None, doubts)):
        note(text)


def _mode_text(mode: xr.Dataset) -> str:
    texts: list[str] = []
    for name, factor, unit in (("frequency", 0.5 / math.pi, "Hz"), ("damping_ratio", 100.0, "%"), ("mass", 1.0, "kg")):
        value, spread = (factor * float(mode[f"mode_{name}{end}"]) for end in ("", "_deviation"))
        shown = f"{value:.{_digits(value, spread)}g}" + (f" +- {spread:.2g}" if spread > 1e-6 * abs(value) else "")
        texts.append(f"{name.replace('_', ' ') + ' ' if texts else ''}{shown} {unit}")
    return ", ".join(texts)


def _digits(value: float, spread: float) -> int:
    """So many digits of the value as end where the first two of its standard deviation do, six at most."""
    if not (0.0 < spread < abs(value)):
        return 6 if spread == 0.0 else 3
    return min(6, max(2, 2 + math.floor(math.log10(abs(value))) - math.floor(math.log10(spread))))


def _ignored(machine: Path | None) -> str:
    from autobalancer.assembly.terms import Theory, ignores
    from autobalancer.files.machine_file import load_race_machine

    return ignores(load_race_machine(machine), Theory.LOOP) if machine is not None else ""


def _border(border: xr.Dataset) -> str:
    speed, deviation = border.attrs["exact_border"], border.attrs["exact_border_deviation"]
    if math.isinf(speed):
        return f"none up to {speed_text(border.attrs['searched'][1])}"
    return speed_text(speed) + (
        f", standard deviation {speed_text(deviation, '.2g')}" if math.isfinite(deviation) else ""
    )


def _row(at: xr.Dataset, loop: xr.Dataset, viscosity: float | None) -> tuple[str, str]:
    value = {str(name): at[name].values.item() for name in at.data_vars}
    verdict = "stable" if value["growth_rate"] < 0.0 else "unstable"
    text = f"{verdict}, growth rate {value['growth_rate']:.3g} 1/s"
    factor = value["drag_factor"]
    text += f"\nneeds at least {factor:.3g} times the drag" if math.isfinite(factor) else "\nno drag is enough"
    if viscosity is not None and math.isfinite(factor):
        text += f", {1e6 * factor * viscosity:.3g} mm^2/s"
    if verdict == "stable":
        text += f"\nwith the balls where they balance: {_margin_text(value)}"
    if loop.attrs["growth_rate"] < 0.0:
        text += f"\nevenly spread, as the picture draws them: {_margin_text(loop.attrs)}"
    else:
        text += "\nevenly spread, as the picture draws them: unstable"
    return f"at {speed_text(float(at['speed']))}", text


def _margin_text(value: dict[str, Any]) -> str:
    return f"gain margin {value['gain_margin']:.3g}, phase margin {math.degrees(value['phase_margin']):.3g} deg"
