"""``autobalancer receptance``: stability from a hammer test."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.measurement.balls import RaceBalls


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
        list[str] | None, typer.Option(help='Margins at this speed, such as "1200 rpm"; repeat it.')
    ] = None,
    search: Annotated[str, typer.Option(help='Speeds in which to look for the border, "low:high".')] = "",
    modes: Annotated[int, typer.Option(help="Number of modes to fit; by default chosen by the noise.")] = 0,
    noise: Annotated[str, typer.Option(help="relative (to each value) or absolute.")] = "relative",
    function: Annotated[int, typer.Option(help="Which function of a universal file.")] = 0,
    resamples: Annotated[int, typer.Option(help="Repeated fits for the uncertainty of the border.")] = 20,
    plot: Annotated[Path | None, typer.Option(help="Picture: the loop at the first speed, else the fit.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print numbers in SI for a program.")] = False,
) -> None:
    """Exact border, least drag and margins from a measured receptance, without a model of the rotor.

    Example: autobalancer receptance hammer.csv --machine examples/machines/discoidal.toml --speed "1200 rpm"
    """
    from autobalancer.measurement.rational_fit import fit_receptance
    from autobalancer.measurement.receptance import load_receptance
    from autobalancer.measurement.receptance_border import receptance_border
    from autobalancer.measurement.receptance_stability import receptance_stability
    from autobalancer.units import option_to_si

    chosen = _balls(machine, balls, ball_mass, orbit_radius, drag)
    fit = fit_receptance(load_receptance(file, function=function or None), modes=modes or None, noise=noise)  # type: ignore[arg-type]
    how: dict[str, Any] = {"balls_on_rotor": with_balls, "unbalance": _unbalance(machine, unbalance, chosen)}
    speeds = [option_to_si(text, "rad/s") for text in speed or []]
    border = receptance_border(fit, chosen, searched=_range(search), resamples=resamples, **how)
    at_speeds = receptance_stability(fit, chosen, speeds, **how) if speeds else None
    if plot is not None:
        _draw(fit, chosen, speeds, with_balls, plot)
    if as_json:
        typer.echo(json.dumps(_plain(fit, border, at_speeds) | {"ignores": _ignored(machine)}, indent=2))
        return
    _show(fit, border, at_speeds, machine)
    if plot is not None:
        typer.echo(f"written: {plot}")


def _balls(machine: Path | None, count: int, mass: str, radius: str, drag: str) -> RaceBalls:
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.balls import balls_of, equal_balls
    from autobalancer.units import option_to_si

    if machine is not None:
        return balls_of(machine)
    if count < 1 or not (mass and radius and drag):
        raise QuestionError("give --machine, or --balls, --ball-mass, --orbit-radius and --drag")
    numbers = (option_to_si(text, unit) for text, unit in ((mass, "kg"), (radius, "m"), (drag, "N*m*s")))
    return equal_balls(count, *numbers, spin_ratio=0.4)


def _unbalance(machine: Path | None, text: str, balls: RaceBalls) -> float | None:
    from autobalancer import load_machine
    from autobalancer.stability.lateral import largest_unbalance
    from autobalancer.units import option_to_si

    if text == "any" or (not text and (machine is None or balls.count > 2)):
        return None
    return option_to_si(text, "kg*m") if text else largest_unbalance(load_machine(machine or ""))


def _range(text: str) -> tuple[float, float] | None:
    from autobalancer.errors import QuestionError
    from autobalancer.units import option_to_si

    if not text:
        return None
    low, mark, high = text.partition(":")
    if not mark:
        raise QuestionError(f"--search: given {text!r}; write it as low:high, e.g. '500 rpm:3000 rpm'")
    return option_to_si(low, "rad/s"), option_to_si(high, "rad/s")


def _draw(fit: xr.Dataset, balls: RaceBalls, speeds: list[float], with_balls: bool, out: Path) -> None:
    from autobalancer.measurement.receptance_loop import receptance_loop
    from autobalancer.plots.receptance import plot_nyquist, plot_receptance
    from autobalancer.plots.save import save_picture

    if speeds:
        save_picture(plot_nyquist(receptance_loop(fit, balls, speeds[0], balls_on_rotor=with_balls)), out)
    else:
        save_picture(plot_receptance(fit), out)


def _plain(fit: xr.Dataset, border: xr.Dataset, at_speeds: xr.Dataset | None) -> dict[str, Any]:
    from autobalancer.cli.check import _finite

    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    numbers: dict[str, Any] = {
        "fit": {
            "modes": int(fit.attrs["modes"]),
            "error": float(fit.attrs["fit_error"]),
            "effective_mass": float(fit.attrs["effective_mass"]),
            "poles": [[float(p.real), float(p.imag)] for p in poles],
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
            for i, s in enumerate(at_speeds["speed"].values)
        ]
        numbers["warnings"] = sorted({*numbers["warnings"], *filter(None, at_speeds.attrs["warnings"].split("\n"))})
    return dict(_finite(numbers))  # type: ignore[call-overload, no-any-return]


def _show(fit: xr.Dataset, border: xr.Dataset, at_speeds: xr.Dataset | None, machine: Path | None) -> None:
    from rich.console import Console
    from rich.table import Table

    from autobalancer.measurement.rational_fit import modes_of
    from autobalancer.measurement.receptance_stability import viscosity_of

    table = Table(title=str(fit.attrs["title"]), show_header=False, title_justify="left", min_width=60)
    table.add_column(style="bold")
    table.add_column()
    table.add_row("fit", f"error {100.0 * fit.attrs['fit_error']:.2g} %, mass {fit.attrs['effective_mass']:.4g} kg")
    for frequency, ratio in modes_of(fit):
        table.add_row("mode", f"{frequency / (2.0 * math.pi):.4g} Hz, damping ratio {100.0 * ratio:.3g} %")
    name = "exact border" + (", worst case" if border.attrs["state"].startswith("worst") else "")
    ignored = _ignored(machine)
    table.add_row(name, "; ".join(filter(None, (_border(border), ignored))))
    for low, high in zip(border["stable_from"].values, border["stable_to"].values, strict=True):
        table.add_row("stable", f"{_speed(low)} to {_speed(high)}")
    viscosity = viscosity_of(machine) if machine is not None else None
    for i in range(at_speeds.sizes["speed"] if at_speeds is not None else 0):
        assert at_speeds is not None
        label, text = _row(at_speeds.isel(speed=i), viscosity)
        table.add_row(label, "; ".join(filter(None, (text, ignored))))
    console = Console(soft_wrap=False)
    console.print(table)
    doubts = {
        *border.attrs["warnings"].split("\n"),
        *(at_speeds.attrs["warnings"].split("\n") if at_speeds is not None else ()),
    }
    for text in sorted(filter(None, doubts)):
        console.print(f"[yellow]note:[/yellow] {text}")


def _ignored(machine: Path | None) -> str:
    from autobalancer import load_machine
    from autobalancer.stability.ignored import ignored_at_rest, without

    return without(ignored_at_rest(load_machine(machine))) if machine is not None else ""


def _border(border: xr.Dataset) -> str:
    speed, deviation = border.attrs["exact_border"], border.attrs["exact_border_deviation"]
    if math.isinf(speed):
        return f"none up to {_speed(border.attrs['searched'][1])}"
    return _speed(speed) + (f", standard deviation {deviation:.2g} rad/s" if math.isfinite(deviation) else "")


def _row(at: xr.Dataset, viscosity: float | None) -> tuple[str, str]:
    value = {str(name): at[name].values.item() for name in at.data_vars}
    verdict = "stable" if value["growth_rate"] < 0.0 else "unstable"
    text = f"{verdict}, growth rate {value['growth_rate']:.3g} 1/s"
    factor = value["drag_factor"]
    text += f"\nneeds at least {factor:.3g} times the drag" if math.isfinite(factor) else "\nno drag is enough"
    if viscosity is not None and math.isfinite(factor):
        text += f", {1e6 * factor * viscosity:.3g} mm^2/s"
    if verdict == "stable":
        text += f"\ngain margin {value['gain_margin']:.3g}, phase margin {math.degrees(value['phase_margin']):.3g} deg"
    return f"at {_speed(float(at['speed']))}", text


def _speed(speed: float) -> str:
    return f"{speed:.5g} rad/s = {speed * 30.0 / math.pi:.5g} rpm"
