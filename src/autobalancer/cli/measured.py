"""Commands for measured signals and films: the group ``measure``."""

from __future__ import annotations

from math import degrees, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import autobalancer as ab
from autobalancer.cli import measured_signals
from autobalancer.cli.measured_signals import tell
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, Seed
from autobalancer.cli.terminal.sheet import note, say
from autobalancer.tables import whole_degrees

if TYPE_CHECKING:
    from autobalancer.measurement.balancing.balance import Balancing
    from autobalancer.results.answers.answer import Answer


# ``autobalancer measure balance``, ``four-run``, ``run-down``: unbalance and corrections from readings.


RunsFile = Annotated[Path, typer.Argument(help="Runs with their masses and readings, .toml.")]
Deviation = Annotated[
    str | None, typer.Option(help="Standard deviation of a reading in percent of it, where a reading has none.")
]


def balance(
    file: RunsFile,
    goal: Annotated[
        str, typer.Option(help="What shall be least of what remains: its mean square (mean), or the greatest.")
    ] = "mean",
    largest: Annotated[str | None, typer.Option(help='Greatest correction mass, such as "20 g".')] = None,
    plane: Annotated[list[str] | None, typer.Option(help="To correct; all by default. May be repeated.")] = None,
    deviation: Deviation = None,
    holes: Annotated[int | None, typer.Option(help="Split each correction over so many evenly spaced holes.")] = None,
    mass: Annotated[list[str] | None, typer.Option(help="That there is for the holes. May be repeated.")] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Correction masses from runs without and with trial masses, with influence coefficients.

    Example: autobalancer measure balance two_plane_job.toml --largest "5 g" --plot balance.png
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import balancing

    files = Files(out, plot)
    found = ab.measure.balance(
        file, goal=goal, largest=largest, planes=plane or None, deviation=deviation  # type: ignore[arg-type]
    )  # fmt: skip
    files.save(found, lambda: balancing(found))
    tell(found, as_json, as_csv)
    if holes is not None and not (as_json or as_csv):
        _tell_holes(found, holes, mass)
    if not (as_json or as_csv):
        files.say()


def _tell_holes(found: Balancing, holes: int, masses: list[str] | None) -> None:
    from math import degrees

    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.tables import Column

    unit = found["correction"].attrs["units"]
    sign, factor = ("g", 1e3) if unit == "kg" else ("g mm", 1e6)
    rows: list[tuple[str, float, float, float]] = []
    for name, size, angle in zip(
        found["plane"].values, found["correction"].values, found["correction_angle"].values, strict=True
    ):
        given = f"{size:.17g} {'kg' if unit == 'kg' else 'kg*m'}"
        split = ab.measure.split_mass(given, float(angle), holes=holes, masses=masses)
        rows += [
            (str(name), degrees(at) % 360.0, factor * part, factor * split.residual)
            for at, part in zip(split.angles, split.masses, strict=True)
        ]
    heads = (("plane", ""), ("hole at", "deg"), ("mass", sign), ("left in plane", sign))
    print_sheet(
        [Column(head, [row[k] for row in rows], text, ".4g") for k, (head, text) in enumerate(heads)],
        "Split over holes",
    )


def four_run(
    file: RunsFile,
    deviation: Deviation = None,
    both: Annotated[bool, typer.Option("--both", help="Two answers where the runs cannot decide.")] = False,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Correction in one plane from amplitudes alone: one run without and three with a trial mass.

    Example: autobalancer measure four-run four_runs.toml --plot circles.png
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import four_run as picture

    files = Files(out, plot)
    found = ab.measure.four_run(file, deviation=deviation, both=both)
    files.save(found, lambda: picture(found))
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def run_down(
    machine: MachineFile,
    file: Annotated[
        Path,
        typer.Argument(
            help="Table: speed \\[rpm], place, direction, amplitude \\[um], phase \\[deg], perhaps amplitude deviation \\[um]; "
            "or orders of this package (.nc)."
        ),
    ],
    plane: Annotated[
        list[str] | None, typer.Option(help="Whose unbalance is asked for: a station, or a position such as 0.1 (m).")
    ] = None,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Unbalance of all planes from one run-down and a model of the rotor.

    Example: autobalancer measure run-down two_plane_rotor.toml run_down_orders.csv --plane lower --plane upper
    """
    from autobalancer.cli.terminal.output import Files
    from autobalancer.plots.measured.balancing import run_down as picture

    files = Files(out, plot)
    found = ab.measure.unbalance_from_run_down(machine, file, planes=[_place(one) for one in plane] if plane else None)
    files.save(found, lambda: picture(found))
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def _place(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


# ``autobalancer measure trial-mass`` and ``split-mass``: before and after a balancing job.


def trial_mass(
    radius: Annotated[str, typer.Option(help='At which it will be, such as "100 mm".')],
    speed: Annotated[str, typer.Option(help='At which it will run, such as "1500 rpm".')],
    rotor_mass: Annotated[str | None, typer.Option(help='Of the rotor, such as "20 kg".')] = None,
    grade: Annotated[str | None, typer.Option(help='Balance quality grade, such as "G 6.3" or 6.3 (mm/s).')] = None,
    machine: Annotated[Path | None, typer.Option(help="Machine file, as a model.")] = None,
    reading: Annotated[str | None, typer.Option(help='Without trial mass, such as "0.1 mm" (peak).')] = None,
    phase: Annotated[str | None, typer.Option(help="Of this reading, lead over the mark.")] = None,
    running: Annotated[str | None, typer.Option(help="Below or above the critical speed.")] = None,
    as_json: Json = False,
) -> None:
    """How large a trial mass should be, and where it should go.

    Example: autobalancer measure trial-mass --radius "100 mm" --speed "1500 rpm" --rotor-mass "20 kg"
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.sheet import print_facts

    plan = ab.measure.trial_mass(
        radius=float(quantity("--radius", radius, "m")),
        speed=float(quantity("--speed", speed, "rad/s")),
        rotor_mass=None if rotor_mass is None else float(quantity("--rotor-mass", rotor_mass, "kg")),
        grade=grade,
        machine=machine,
        reading=reading,
        phase=None if phase is None else float(quantity("--phase", phase, "rad")),
        running=running,  # type: ignore[arg-type]
    )
    if as_json:
        print_json(asdict(plan))
        return
    rows = [
        (
            "mass",
            f"{1e3 * plan.mass:.3g} g at a radius of {1e3 * plan.radius:.4g} mm ({1e6 * plan.unbalance:.4g} g mm)",
        ),
        ("from", plan.rule),
        ("pulls with", f"{plan.force:.3g} N at this speed"),
    ]
    if not isnan(plan.angle):
        rows.append(("place", f"{whole_degrees(plan.angle)} deg from the mark, in the sense of rotation"))
    if not isnan(plan.change):
        rows.append(("changes the reading by", f"{100.0 * plan.change:.3g} %"))
    print_facts(rows, "Trial mass")
    for text in plan.remarks:
        note(text)


def split_mass(
    mass: Annotated[str, typer.Argument(help='Wanted, such as "15 g" or "900 g*mm".')],
    angle: Annotated[str, typer.Argument(help='Of it, such as "40 deg".')],
    holes: Annotated[int, typer.Option(help="Evenly spaced ones.")],
    first: Annotated[str, typer.Option(help="Angle of one of them.")] = "0 deg",
    available: Annotated[list[str] | None, typer.Option("--mass", help="That there is. May be repeated.")] = None,
    largest: Annotated[str | None, typer.Option(help="Greatest mass in a hole, where any size is possible.")] = None,
    most: Annotated[int, typer.Option(help="Holes that may be used with given masses.")] = 3,
    as_json: Json = False,
) -> None:
    """Split a correction over holes: exactly, or as near as the masses that there are can come.

    Example: autobalancer measure split-mass "15 g" "40 deg" --holes 6
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.sheet import print_sheet, say
    from autobalancer.tables import Column

    found = ab.measure.split_mass(
        mass,
        float(quantity("ANGLE", angle, "rad")),
        holes=holes,
        first=float(quantity("--first", first, "rad")),
        masses=available or None,
        largest=largest,
        most=most,
    )
    if as_json:
        print_json(asdict(found))
        return
    sign, factor = ("g", 1e3) if found.unit == "kg" else ("g mm", 1e6)
    print_sheet(
        [
            Column("hole at", [degrees(at) % 360.0 for at in found.angles], "deg", ".4g"),
            Column("mass", [factor * one for one in found.masses], sign, ".4g"),
        ]
    )
    say(f"left: {factor * found.residual:.3g} {sign} at {whole_degrees(found.residual_angle)} deg")


# ``autobalancer measure balls`` and ``measure film``: balls of a film, and a film of a run.


def balls(
    film: Annotated[Path, typer.Argument(help="Film (.mp4 and others), or a photograph (.png, .jpg).")],
    setup: Annotated[Path, typer.Option(help="TOML file with race, balls and marks.")],
    frame_rate: Annotated[
        str, typer.Option(help='Of the camera, such as "240 Hz"; by default what the film says.')
    ] = "",
    first_speed: Annotated[str, typer.Option(help="Rotor speed at the first picture; by default slow.")] = "",
    first_ball_speed: Annotated[
        str, typer.Option(help="Of the balls in the rotor at the first picture; by default slow.")
    ] = "",
    critical_speed: Annotated[str, typer.Option(help="For events of capture and release.")] = "",
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Follow the balls of a race through a film, or read their angles from a photograph.

    Example: autobalancer measure balls race.mp4 --setup race.toml --out race.nc
    """
    from autobalancer.cli.terminal.options import optional
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.plots.drawing.style import save_picture

    one_form(as_json, as_csv)
    files = Files(out, plot)
    known = ab.measure.load_film_setup(setup)
    single = film.suffix.lower() in (".png", ".jpg", ".jpeg")
    if single and (plot or frame_rate or first_speed or first_ball_speed or critical_speed):
        raise QuestionError(f"{film}: is a photograph; --plot, --frame-rate and the speeds are for films")
    if single:
        found: Answer = ab.measure.photographed_angles(film, known)
    else:
        rate, speed = optional("--frame-rate", frame_rate, "Hz"), optional("--first-speed", first_speed, "rad/s")
        slip = optional("--first-ball-speed", first_ball_speed, "rad/s")
        critical = optional("--critical-speed", critical_speed, "rad/s")
        with progress_bar("pictures") as update:
            found = ab.measure.track_balls(
                film,
                known,
                frame_rate=rate,
                first_speed=speed or 0.0,
                first_ball_speed=slip or 0.0,
                critical_speed=critical,
                progress=update,
            )
    files.save(found)
    if plot is not None:
        save_picture(ab.plot.ball_film(found), plot)
    if as_json:
        print_json(found)
        return
    if as_csv:
        print_csv(found.columns())
        return
    print_facts(found.facts(), found.heading())
    print_sheet(found.columns())
    files.say()


def film(
    run: Annotated[Path, typer.Argument(help="Result of a run with enough samples (.nc).")],
    out: Annotated[Path, typer.Option(help="The film, as .mp4; its set-up is written beside it as .toml.")],
    tilt: Annotated[str, typer.Option(help="Angle between the lens and the axis of the rotor.")] = "0 deg",
    turning: Annotated[bool, typer.Option("--turning", help="The camera turns with the rotor.")] = False,
    frame_rate: Annotated[str, typer.Option(help="Of the camera.")] = "240 Hz",
    exposure: Annotated[str, typer.Option(help="How long the shutter is open.")] = "0.2 ms",
    stroboscope: Annotated[bool, typer.Option("--stroboscope", help="One flash and picture a turn.")] = False,
    noise: Annotated[float, typer.Option(help="Standard deviation of a pixel, share of full scale.")] = 0.01,
    lost: Annotated[float, typer.Option(help="Share of the pictures that are lost.")] = 0.0,
    size: Annotated[str, typer.Option(help="Of the picture, COLUMNSxROWS.")] = "1280x720",
    race: Annotated[int, typer.Option(help="Which race, counted from 1.")] = 1,
    start: Annotated[str, typer.Option(help='Begin with this time of the run, such as "1 s".')] = "",
    end: Annotated[str, typer.Option(help='End with it, such as "3 s".')] = "",
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Film a race of a run as a camera would see it: perspective, blur, light, noise, marks.

    Example: autobalancer measure film stall.nc --out race.mp4 --tilt "30 deg" \\
      --end "0.1 s" --size 480x360
    """
    from autobalancer.cli.terminal.options import optional, quantity
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.progress_bar import progress_bar

    columns, rows = _size(size)
    camera = ab.measure.film_camera(
        run, tilt=quantity("--tilt", tilt, "rad"), width=columns, height=rows, turning=turning, race=race
    )
    how = ab.measure.Exposure(
        frame_rate=float(quantity("--frame-rate", frame_rate, "Hz")),
        time=quantity("--exposure", exposure, "s"),
        stroboscope="turn" if stroboscope else "",
        noise=noise,
        lost=lost,
    )
    known = ab.measure.film_setup(run, camera, race=race)
    with progress_bar("pictures") as update:
        made = ab.measure.render_film(
            run,
            out,
            camera=camera,
            exposure=how,
            start=optional("--start", start, "s"),
            end=optional("--end", end, "s"),
            race=race,
            seed=seed,
            progress=update,
        )
    ab.measure.save_film_setup(known, out.with_suffix(".toml"))
    if as_json:
        print_json({"film": str(out), "setup": str(out.with_suffix(".toml")), "pictures": made.time.size})
        return
    say(f"{made.time.size} pictures from {made.time[0]:.6g} s to {made.time[-1]:.6g} s")
    say(f"film: {out}")
    say(f"set-up: {out.with_suffix('.toml')}")


def _size(text: str) -> tuple[int, int]:
    columns, cross, rows = text.lower().partition("x")
    if not (cross and columns.strip().isdecimal() and rows.strip().isdecimal()):
        raise ab.errors.QuestionError(f"--size: given {text!r}; write COLUMNSxROWS, such as 1280x720")
    return int(columns), int(rows)


# ``autobalancer measure race-shape``, ``rest-friction``, ``drag-from-lag``: races and balls from measurements.


def race_shape(
    file: Annotated[Path, typer.Argument(help="Table: angle \\[deg], and radius \\[mm] or deviation \\[um].")],
    waves: Annotated[int, typer.Option(help="Undulations per revolution up to which the profile is kept.")] = 15,
    center: Annotated[
        str,
        typer.Option(help="Around what it was measured: the axis of the rotor, or a setup whose eccentricity goes."),
    ] = "axis",
    out: Annotated[Path | None, typer.Option(help="The lines of a machine file, as .toml.")] = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Roundness, eccentricity and waves of a race from its measured profile, for a machine file.

    Example: autobalancer measure race-shape race_profile.csv --out race.toml --plot race.png
    """
    from autobalancer.cli.terminal.output import MACHINE, Files
    from autobalancer.plots.drawing.style import save_picture
    from autobalancer.plots.measured.race import race_shape as picture
    from autobalancer.safe_file import write_text_safely

    files = Files(out, plot, MACHINE)
    found = ab.measure.race_shape(file, waves=waves, center=center)  # type: ignore[arg-type]
    if out is not None:
        write_text_safely(out, found.machine_lines())
    if plot is not None:
        save_picture(picture(found), plot)
    tell(found, as_json, as_csv)
    if not (as_json or as_csv):
        files.say()


def rest_friction(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: angle \\[deg] of each rest, from the place opposite the unbalance.")
    ],
    speed: Annotated[str, typer.Option(help='At which the ball rested, such as "1200 rpm".')],
    plot: Plot = None,
    as_json: Json = False,
) -> None:
    """Adherence between a ball and its race from where it came to rest in many run-ups.

    Example: autobalancer measure rest-friction one_ball_run_up.toml rest_positions.csv --speed "1200 rpm"
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.output import Files, print_json
    from autobalancer.cli.terminal.sheet import print_facts
    from autobalancer.plots.drawing.style import save_picture
    from autobalancer.plots.measured.race import rests as picture

    files = Files(None, plot)
    found = ab.measure.rest_friction(machine, file, float(quantity("--speed", speed, "rad/s")))
    if plot is not None:
        save_picture(picture(found), plot)
    if as_json:
        print_json(asdict(found))
        return
    low, high = degrees(found.width_low), degrees(found.width_high)
    middle = f"{degrees(found.middle):.3g} +- {degrees(found.middle_deviation):.2g} deg from the balanced place"
    print_facts(
        [
            ("adherence", f"{found.adherence:.4g}, from {found.low:.4g} to {found.high:.4g} with 95 %"),
            ("rests lie within", f"{degrees(found.width):.4g} deg, from {low:.4g} to {high:.4g} deg with 95 %"),
            ("middle", middle),
            ("rests", str(len(found.angles))),
        ],
        "Friction from rest positions",
    )
    for text in found.remarks:
        note(text)
    files.say()


def drag_from_lag(
    machine: MachineFile,
    file: Annotated[
        Path, typer.Argument(help="Table: time \\[s], rotor speed \\[rpm], ball speed \\[rpm], both in space.")
    ],
    rolling: Annotated[bool, typer.Option("--rolling/--no-rolling", help="With rolling resistance.")] = True,
    as_json: Json = False,
) -> None:
    """Drag and rolling resistance of a ball from how far it lags behind the rotor in a run-up.

    Example: autobalancer measure drag-from-lag one_ball_run_up.toml ball_lag.csv
    """
    from dataclasses import asdict

    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.sheet import print_facts

    found = ab.measure.drag_from_lag(machine, file, rolling=rolling)
    if as_json:
        print_json(asdict(found))
        return
    print_facts(
        [
            ("drag", f"{found.drag:.4g} +- {found.drag_deviation:.2g} N m s"),
            ("rolling resistance", f"{found.rolling_resistance:.4g} +- {found.rolling_resistance_deviation:.2g}"),
            ("correlation of both", f"{found.correlation:.3g}"),
            ("left of the speed", f"{found.scatter:.3g} rad/s"),
        ],
        "Drag from the lag of a ball",
    )
    for text in found.remarks:
        note(text)


# ``autobalancer measure``: the group and its commands; a new command is a file here and a line below.


app = typer.Typer(
    name="measure",
    help="From measured signals and films to numbers with their uncertainty.",
    no_args_is_help=True,
)
app.command()(measured_signals.signals)
app.command()(measured_signals.orders)
app.command()(measured_signals.spectrum)
app.command("order-map")(measured_signals.order_map)
app.command()(measured_signals.damping)
app.command()(measured_signals.orbit)
app.command()(measured_signals.envelope)
app.command()(measured_signals.record)
app.command()(balance)
app.command("four-run")(four_run)
app.command("run-down")(run_down)
app.command("trial-mass")(trial_mass)
app.command("split-mass")(split_mass)
app.command("race-shape")(race_shape)
app.command("rest-friction")(rest_friction)
app.command("drag-from-lag")(drag_from_lag)
app.command("rubber-signals")(measured_signals.rubber_signals)
app.command()(balls)
app.command()(film)
