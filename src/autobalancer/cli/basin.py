"""``autobalancer basin``: which end state follows from which start."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from autobalancer.cli.options import Csv, Json, MachineFile, Outs, Plot, Seed, SpeedUnit, Unit
from autobalancer.cli.words import note, say


def basin(
    machine: MachineFile,
    speed: Annotated[str, typer.Option(help='Final rotor speed, such as "1200 rpm".')],
    x: Annotated[str, typer.Option(help='Starts along x: "NAME=from:to:count"; see below.')] = "",
    y: Annotated[str, typer.Option(help="Starts along y, in the same form.")] = "",
    random: Annotated[int, typer.Option(help="Instead of --x and --y: number of random starts.")] = 0,
    seed: Seed = 0,
    acceleration: Annotated[str, typer.Option(help='Run up from rest, such as "10 rad/s^2".')] = "",
    hold: Annotated[str, typer.Option(help='Longest time at the final speed, such as "30 s".')] = "",
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Run a machine from many starts and say in percent where it ends.

    A NAME is ball_angle[1], ball_speed[1] or the same of another ball, or acceleration.
    With gravity in the plane, and for rotors that tilt or bend, only --random
    answers: an end is the verdict on a run.

    Example: autobalancer basin discoidal.toml \\
      --speed "1200 rpm" --random 500 --plot basin.png
    """
    from autobalancer import basin as ask
    from autobalancer import plot_basin
    from autobalancer.cli.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.progress import progress_bar
    from autobalancer.cli.quantities import optional, quantity
    from autobalancer.cli.sheet import Column, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    axes = dict(_axis(option, text) for option, text in (("--x", x), ("--y", y)) if text)
    with progress_bar("runs") as update:
        found = ask(
            machine,
            quantity("--speed", speed, "rad/s"),
            axes or None,
            random=random,
            seed=seed,
            acceleration=optional("--acceleration", acceleration, "rad/s^2"),
            hold=optional("--hold", hold, "s"),
            progress=update,
        )
    shares = {str(name): float(found["share"].sel(end=name)) for name in found["end"].values}
    files.save(found, lambda: plot_basin(found, speed_unit=speed_unit))
    runs = int(found["state"].size)
    left = _left(found)
    if as_json:
        drawn = {"seed": seed} if random else {}
        print_json({"machine": str(machine), "runs": runs, **drawn, "share": shares, **left})
        return
    there = {name: 100.0 * share for name, share in shares.items() if share > 0.0}
    columns = [Column("end", list(there)), Column("share", list(there.values()), "%", ".2f")]
    if random:
        for column, name in (("from", "share_low"), ("to", "share_high")):
            columns.append(Column(column, [100.0 * float(found[name].sel(end=end)) for end in there], "%", ".2f"))
    if as_csv:
        print_csv(columns)
        return
    print_sheet(columns)
    typer.echo(f"{runs} runs" + (f", random starts of seed {seed}" if random else ""))
    for line in _lines(left):
        say(line, indent="  ")
    for text in (left["note"], left["gravity_note"]):
        if text:
            note(text)
    files.say()


def _left(found: Any) -> dict[str, Any]:
    """What the ends leave, SI."""

    def plain(name: str) -> Any:
        return found[name].values.tolist()

    quantiles = [str(float(q)) for q in found["quantile"].values]
    left: dict[str, Any] = {
        "residual_unbalance": dict(zip(quantiles, plain("residual_quantile"), strict=True)),
        "unbalance": plain("unbalance"),
        "released": str(found.attrs["released"]),
        "note": str(found.attrs.get("friction_text", "")),
        "gravity_note": str(found.attrs.get("gravity_text", "")),
    }
    if "verdict_share" in found:
        left["verdict_share"] = dict(zip(found["verdict"].values.tolist(), plain("verdict_share"), strict=True))
    for name in ("deflection", "vibration"):
        if f"{name}_quantile" in found:
            left[name] = dict(zip(quantiles, plain(f"{name}_quantile"), strict=True))
            left[f"{name}_without_balls"] = plain(f"{name}_without_balls")
    return left


def _lines(left: dict[str, Any]) -> list[str]:
    from autobalancer.results.number_text import length_text, moment_text

    shares = left.get("verdict_share", {})
    words = ", ".join(f"{word} {100 * share:.3g} %" for word, share in shares.items() if share > 0.0)
    lines = [f"verdict: {words}"] if words else []
    for name, text, key, whole in (
        ("residual unbalance", moment_text, "residual_unbalance", "unbalance"),
        ("deflection", length_text, "deflection", "deflection_without_balls"),
        ("vibration", length_text, "vibration", "vibration_without_balls"),
    ):
        middle, often, most = left.get(key, dict.fromkeys("abc", float("nan"))).values()
        if middle == middle:
            lines.append(
                f"{name}, {left['released']}: median {text(middle)}, 95 % below {text(often)}, "
                f"at most {text(most)}; without balls {text(left[whole])}"
            )
    return lines


def _axis(option: str, text: str) -> tuple[str, list[float]]:
    from autobalancer.cli.quantities import named, values

    name, span = named(option, text)
    unit = "rad" if "angle" in name else "rad/s" if "speed" in name else "rad/s^2"
    return name, [float(value) for value in values(option, span, unit)]
