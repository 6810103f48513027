"""``autobalancer measure balls`` and ``measure film``: balls of a film, and a film of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, Outs, Plot, Seed
from autobalancer.cli.terminal.words import say

if TYPE_CHECKING:
    from autobalancer.results.answers.answer import Answer


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
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.plots.drawing.save import save_picture

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
    from autobalancer.cli.terminal.output import print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity

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
