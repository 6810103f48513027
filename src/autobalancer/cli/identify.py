"""Commands that find out about a machine from measurements: parameters, stability by a hammer test."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, RESULT, Reply, command
from autobalancer.cli.terminal.options import Ends, In, MachineFile
from autobalancer.cli.terminal.sheet import speed_number, speed_sign, speed_text
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.machine import Machine
    from autobalancer.measurement.loop import RaceBalls
    from autobalancer.rotordynamics.parameter_fit import FreeParameter
    from autobalancer.tables import Column

TOPIC = "From measurements"  # where the help of autobalancer lists the commands below


@command("rotor.identify", take="loss loss_scale starts", draw=True, allowed=(*MACHINE, *RESULT))
def identify(
    machine: MachineFile,
    measurements: Annotated[Path, "Measurement file: what is free and what was measured."],
    free: Annotated[list[str] | None, 'More free parameters, "NAME=from:to", NAME a path. May be repeated.'] = None,
    **options: Any,
) -> Reply:
    """Fit parameters of a machine to measured modes, critical speeds, response curves and known values.

    Example: autobalancer identify rodrigues_rig.toml \\
      --measurements rodrigues_critical_speeds.toml \\
      --out fitted.toml --out fit.nc
    """
    from autobalancer.files.machine_file import load_race_machine

    described = load_race_machine(machine)
    parameters, measured = ab.rotor.load_measurements(measurements)
    parameters += [_free(text, described) for text in free or []]
    found = ab.rotor.identify(described, parameters, measured, **options)
    data, about = found.data, found.data.attrs
    chosen = [name for name in data.variables if name != "other_parameter" and "point" not in data[name].dims]
    keys = ("chi_square", "degrees_of_freedom", "scatter_ratio", "rank", "outcome", "loss", "notes", "machine")
    chi = (
        f"chi square {about['chi_square']:.4g}, {about['degrees_of_freedom']} degrees of freedom, rank {about['rank']}"
    )
    # netCDF knows neither lists of texts as attributes nor booleans
    plain = data.copy()
    plain.attrs["notes"] = "\n".join(data.attrs["notes"])
    plain["at_bound"] = plain["at_bound"].astype("int8")
    return Reply(
        plain,
        {str(name): data[name].values for name in chosen} | {name: about[name] for name in keys},
        about["title"],
        (),
        _parameters(data),
        more=[("Measurements", _measurements(data))],
        lines=[chi],
        notes=about["notes"],
        draw=lambda: ab.plot.answer(data),
        machine=found.machine,
    )


def _free(text: str, machine: Machine) -> FreeParameter:
    from autobalancer.cli.terminal.options import named_range, unit_of
    from autobalancer.rotordynamics.parameter_fit import FreeParameter
    from autobalancer.units.quantity import ends

    path, span = named_range("--free", text, "from:to")
    return FreeParameter(path, *ends("--free", span, unit_of("--free", path, machine)))


def _parameters(data: xr.Dataset) -> list[Column]:
    from autobalancer.rotordynamics.identify import shown_parameter, with_spread
    from autobalancer.tables import Column

    bound = [bool(value) for value in data["at_bound"].values]
    factors, units = zip(
        *(shown_parameter(data.isel(parameter=p)) for p in range(data.sizes["parameter"])), strict=True
    )
    spread = [float(value) for value in factors * data["uncertainty"].values]
    said = ["at its bound" if stuck else with_spread(value) for stuck, value in zip(bound, spread, strict=True)]
    return [
        Column("parameter", [str(name) for name in data["parameter"].values], wraps=True),
        Column("identified", factors * data["value"].values, form=".7g"),
        Column("uncertainty", said),
        Column("unit", list(units)),
        Column("start", factors * data["start"].values, form=".6g"),
    ]


def _measurements(data: xr.Dataset) -> list[Column]:
    from autobalancer.rotordynamics.identify import grouped, shown_unit
    from autobalancer.tables import Column

    rows: list[list[Any]] = []
    for label, part in grouped(data):
        count = part.sizes["row"]
        if count > 1:
            rms = math.sqrt(float((part["deviation"] ** 2).mean()))
            rows.append([f"{label}, {count} values", None, None, None, "", f"rms {rms:.2f}"])
            continue
        factor, unit = shown_unit(part)
        numbers = [factor * float(part[name][0]) for name in ("measured", "before", "after")]
        rows.append([label, *numbers, unit, f"{float(part['deviation'][0]):+.2f}"])
    heads = ("quantity", "measured", "before", "after", "unit", "deviation in sigma")
    cells = zip(*rows, strict=True)
    return [
        Column(head, list(cell), form=".6g", wraps=head == "quantity") for head, cell in zip(heads, cells, strict=True)
    ]


# ``autobalancer receptance``: stability from a hammer test.


@command("measure.receptance", take="modes noise", draw=True, allowed=(*RESULT, *MACHINE), unit="speed", bar="fit")
def receptance(
    file: Annotated[Path, typer.Argument(help="Table with units in its column names, or universal file (type 58).")],
    machine: Annotated[Path | None, "Machine file: takes its balls and its largest unbalance."] = None,
    balls: Annotated[int, "Without a machine: number of equal balls."] = 0,
    ball_mass: Annotated[float | None, In("kg"), 'Mass of one, such as "7.6 g".'] = None,
    orbit_radius: Annotated[float | None, In("m"), 'Of the ball centers, such as "77 mm".'] = None,
    drag: Annotated[float | None, In("N*m*s"), 'beta of one ball, such as "5.5e-6 N*m*s".'] = None,
    with_balls: Annotated[bool, typer.Option("--with-balls", help="The balls were on the rotor in the test.")] = False,
    unbalance: Annotated[str, 'Such as "594 g*mm"; or "any": worst case.'] = "",
    speed: Annotated[
        list[float] | None, In("rad/s"), 'Margins at this speed, such as "1200 rpm". May be repeated.'
    ] = None,
    search: Annotated[
        Any, Ends("rad/s"), 'Speeds in which to look for the border, "from:to": "500 rpm:3000 rpm".'
    ] = None,
    band: Annotated[Any, Ends("rad/s"), 'Frequencies used in the fit, "from:to": "5 Hz:200 Hz".'] = None,
    function: Annotated[int | None, "Which function of a universal file."] = None,
    resamples: Annotated[int, "Repeated fits for the uncertainty of the border."] = 20,
    mass_added: Annotated[
        str | None, 'Fixed to the rotor in the test and no part of it, such as "20 g": is taken off.'
    ] = None,
    files: Any = None,
    **options: Any,
) -> Reply:
    """Exact border, least drag and margins from a measured receptance, without a model of the rotor.

    With --machine it is also written as .toml, with a rotor of the fitted modes. The picture is the loop at the first
    speed, else the fit.

    Example: autobalancer receptance discoidal_hammer.csv \\
      --machine discoidal.toml --speed "1200 rpm"
    """
    chosen = _balls(machine, balls, ball_mass, orbit_radius, drag)
    written = any(path.suffix.lower() in MACHINE for path in files.out)
    if written and (machine is None or with_balls):
        raise QuestionError(
            "--out: a machine file wants --machine, which is written with this rotor, and the rotor without balls: give the mass "
            "of those that were on it as --mass-added, not --with-balls"
        )
    measured = ab.measure.load_receptance(file, function=function, mass_added=mass_added)
    how: dict[str, Any] = {"balls_on_rotor": with_balls, "unbalance": _unbalance(machine, unbalance, chosen)}
    fit = ab.measure.receptance(measured, band=band, **options)
    update = options["progress"]
    border = ab.measure.receptance_border(fit, chosen, searched=search, resamples=resamples, progress=update, **how)
    at_speeds = ab.measure.receptance_stability(fit, chosen, speed, **how) if speed else None
    loops = [ab.measure.receptance_loop(fit, chosen, one, balls_on_rotor=with_balls) for one in speed or ()]
    doubts = {*border.attrs["warnings"].split("\n")}
    doubts |= {*at_speeds.attrs["warnings"].split("\n")} if at_speeds is not None else set()
    return Reply(
        fit if at_speeds is None else at_speeds,
        _receptance_numbers(fit, border, at_speeds, loops) | {"ignores": _ignored(machine)},
        str(fit.attrs["title"]),
        _receptance_facts(fit, border, at_speeds, loops, machine),
        fit.columns() if at_speeds is None else _margins(at_speeds),
        brief=True,
        notes=sorted(filter(None, doubts)),
        draw=lambda: ab.plot.answer(loops[0] if loops else fit),
        machine=_with_rotor(machine, fit) if machine is not None and written else None,
    )


def _with_rotor(machine: Path, fit: xr.Dataset) -> Machine:
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.receptances import measured_rotor, with_measured_rotor

    return with_measured_rotor(load_race_machine(machine), measured_rotor(fit))


def _balls(machine: Path | None, count: int, mass: float | None, radius: float | None, drag: float | None) -> RaceBalls:
    from autobalancer.measurement.loop import balls_of, equal_balls

    if machine is not None:
        return balls_of(machine)
    if count < 1 or mass is None or radius is None or drag is None:
        raise QuestionError("give --machine, or --balls, --ball-mass, --orbit-radius and --drag")
    return equal_balls(count, mass, radius, drag, spin_ratio=0.4)


def _unbalance(machine: Path | None, text: str, balls: RaceBalls) -> float | None:
    from autobalancer.assembly.drive_train import largest_unbalance
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.files.machine_file import load_race_machine

    if text == "any" or (not text and (machine is None or balls.count > 2)):
        return None
    return quantity("--unbalance", text, "kg*m") if text else abs(largest_unbalance(load_race_machine(machine or "")))


def _receptance_numbers(
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


def _margins(at_speeds: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

    across = [float(speed_number(w, ".10g")) for w in at_speeds["speed"].values]
    return [
        Column("speed", across, speed_sign()),
        Column("growth rate", at_speeds["growth_rate"].values, "1/s"),
        Column("least drag over that given", at_speeds["drag_factor"].values),
        Column("gain margin", at_speeds["gain_margin"].values),
        Column("phase margin", [math.degrees(value) for value in at_speeds["phase_margin"].values], "deg"),
    ]


def _receptance_facts(
    fit: xr.Dataset, border: xr.Dataset, at_speeds: xr.Dataset | None, loops: list[xr.Dataset], machine: Path | None
) -> list[tuple[str, str]]:
    """Fit, modes, border, stable ranges and margins as names and texts."""
    from autobalancer.measurement.loop import viscosity_of

    about = fit.attrs
    rows = [("fit", f"error {100.0 * about['fit_error']:.2g} %, mass {about['effective_mass']:.4g} kg")]
    rows += [("mode", _mode_text(fit.isel(mode=i))) for i in range(fit.sizes["mode"])]
    name = "exact border" + (", worst case" if border.attrs["state"].startswith("worst") else "")
    ignored = _ignored(machine)
    rows.append((name, "; ".join(filter(None, (_border(border), ignored)))))
    for low, high in zip(border["stable_from"].values, border["stable_to"].values, strict=True):
        rows.append(("stable", f"{speed_text(low)} to {speed_text(high)}"))
    viscosity = viscosity_of(machine) if machine is not None else None
    for i, loop in enumerate(loops if at_speeds is not None else ()):
        label, text = _row(at_speeds.isel(speed=i), loop, viscosity)  # type: ignore[union-attr]
        rows.append((label, "; ".join(filter(None, (text, ignored)))))
    return rows


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
