"""Commands that ask how the rotor itself moves: modes, responses, torsion, liquid, the planar oscillator in its place."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, RESULT, Reply, as_plain, command
from autobalancer.cli.terminal.options import COUNT, In, MachineFile, Ranged, Speeds, quantity
from autobalancer.cli.terminal.sheet import speed_number, speed_sign, speed_text
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.tables import Column

TOPIC = "Rotor"  # where the help of autobalancer lists the commands below


SpeedRange = Annotated[
    Any, Speeds(COUNT), '"from:to" or "from:to:count", such as "600 rpm:5500 rpm:400", or one speed.'
]


# ``autobalancer modes`` and ``campbell``: natural frequencies and critical speeds.


@command("rotor.modes", take="speed:rad/s balls modes rubber_amplitude:m motion", draw=True, unit="both")
def modes(machine: MachineFile, **options: Any) -> Reply:
    """Print natural frequencies with damping and direction of whirl, and the critical speeds, which are without damping.

    Example: autobalancer modes rigid_rotor.toml --speed "1200 rpm"
    """
    return _with_critical_speeds(ab.rotor.modes(machine, **options), machine, options["balls"])


@command("rotor.campbell", take="balls modes", draw=True, unit="both")
def campbell(
    machine: MachineFile,
    speeds: Annotated[Any, Ranged("rad/s"), 'Rotor speeds, "from:to:count", such as "0:6000 rpm:121".'],
    **options: Any,
) -> Reply:
    """Natural frequencies with damping over the speed, and where they meet it; critical speeds are without damping.

    Example: autobalancer campbell rigid_rotor.toml \\
      --speeds "0 rpm:6000 rpm:121" --plot campbell.png
    """
    return _with_critical_speeds(ab.rotor.campbell(machine, speeds, **options), machine, options["balls"])


def _with_critical_speeds(found: Any, machine: Any, balls: bool) -> Reply:
    try:
        critical = ab.rotor.critical_speeds(machine, balls=balls)
    except QuestionError:  # cross-coupled stiffness leaves none without a range of speeds
        return Reply(found, {**as_plain(found), "critical_speeds": None}, lines=["critical speeds unknown"])
    shown = ("critical speeds, without damping", critical.columns(speed_sign()))
    return Reply(found, {**as_plain(found), "critical_speeds": as_plain(critical)}, more=[shown])


# ``autobalancer response``: the synchronous unbalance response of a rotor.


FEW = 20  # speeds of which each has a row of its own


@command("rotor.response", take="balls quantity", draw=True, unit="speed")
def response(
    machine: MachineFile,
    speeds: SpeedRange,
    station: Annotated[
        list[str] | None, 'Name of a station, or a position such as "-20 mm"; by default all. May be repeated.'
    ] = None,
    unbalance: Annotated[
        float | None,
        In("kg*m"),
        'In the plane of the first balancer, such as "37 g*mm"; by default that of the machine.',
    ] = None,
    kind: Annotated[str, "Of the picture: bode, polar, or at one speed orbits or axis."] = "",
    **options: Any,
) -> Reply:
    """Print the peaks of the unbalance response over a range of speeds, or the whirl of every station at one speed.

    Example: autobalancer response two_plane_rotor.toml \\
      --speeds "600 rpm:5500 rpm:400" --plot bode.png
    """
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.tables import Column

    many = speeds.size > 1
    allowed = ("bode", "polar") if many else ("orbits", "axis")
    if kind not in ("", *allowed):
        what = "a range of speeds" if many else "one speed"
        raise QuestionError(f"--kind: given {kind!r}; for {what} it must be {' or '.join(allowed)}")
    described = load_race_machine(machine)
    about: Any = ([_place(described, text) for text in station] if station else None, unbalance)
    found = ab.rotor.response(described, speeds, *about, **options)

    def draw() -> Any:
        look: Any = {"speed_unit": speed_sign()}
        if many:
            smooth = ab.rotor.response(described, speeds, *about, smooth=True, **options)
            return ab.plot.answer(smooth, "polar_response" if kind == "polar" else "", **look)
        orbits = ab.rotor.whirl_orbits(described, float(speeds[0]), *about, balls=options["balls"])
        return ab.plot.answer(orbits, "whirl_along_axis" if kind == "axis" else "", **look)

    numbers = as_plain(found)
    if not many:
        return Reply(found, numbers, columns=_whirl(found), facts=(), draw=draw)
    peaks = ab.rotor.response_peaks(described, float(speeds[0]), float(speeds[-1]), *about, **options)
    mean = f"mean over the stations, greatest {options['quantity']}"
    more = [(mean, peaks.columns(speed_sign()))]
    if speeds.size <= FEW:
        each = [
            Column(str(name), _sizes(found["semi_major"].sel(station=name), found)) for name in found["station"].values
        ]
        more.insert(0, ("", [Column("at", [speed_text(float(speed)) for speed in speeds]), *each]))
    return Reply(found, numbers, more=more, lines=peaks.remarks(), draw=draw)


def _place(machine: Any, text: str) -> str | float:
    """The name of a station, or a position where no station has this name."""
    known = any(station.name == text for station in machine.stations)
    return text if known or text.strip()[:1] not in set("+-.0123456789") else float(quantity("--station", text, "m"))


def _sizes(values: xr.DataArray, found: xr.Dataset) -> list[str]:
    from autobalancer.results.display_units import length_text

    rate = {"displacement": "", "velocity": "/s", "acceleration": "/s^2"}[found.attrs["quantity"]]
    return [length_text(float(size)) + rate for size in values.values]


def _whirl(found: xr.Dataset) -> list[Column]:
    """How each station whirls at one speed."""
    from autobalancer.tables import Column

    at = found.isel(speed=0)
    return [
        Column("station", [str(name) for name in at["station"].values]),
        Column("whirl", at["whirl"].values.tolist()),
        *(Column(name.replace("_", "-"), _sizes(at[name], found)) for name in ("semi_major", "semi_minor")),
        Column("direction of major", [math.degrees(a) for a in at["inclination"].values], "deg", ".3g"),
        Column("phase", [math.degrees(a) for a in at["phase"].values], "deg", ".4g"),
    ]


# ``autobalancer torsional-modes``, ``torsional-response`` and ``liquid-response``.


@command("rotor.torsional_modes", take="speed:rad/s", unit="both")
def torsional_modes(
    machine: MachineFile,
    harmonic: Annotated[
        list[float] | None, "Cycles per turn of what excites; by default what the machine has. May be repeated."
    ] = None,
    **options: Any,
) -> Reply:
    """Print the torsional natural frequencies of a drive train, and the speeds at which something excites them.

    Example: autobalancer torsional-modes coupled_drive.toml
    """
    from autobalancer.results.answers.answer import Shown

    found = ab.rotor.torsional_modes(machine, **options)
    critical = ab.rotor.torsional_critical_speeds(machine, harmonics=harmonic)
    tables = [("torsional critical speeds, without damping", critical.columns(speed_sign()))]
    if critical.sizes["crossing"]:
        met = critical.shown(
            speed_sign(),
            Shown("crossing_speed", "met at"),
            Shown("crossing_harmonic", "frequency over speed", form="g"),
            Shown("crossing_name", "mode"),
            Shown("crossing_damping_ratio", "damping ratio", "%", ".3g"),
        )
        tables.append(("with damping: where the frequency of a mode is met", met))
    return Reply(found, as_plain(found) | {"critical_speeds": as_plain(critical)}, more=tables)


@command("rotor.torsional_response", draw=True, unit="speed")
def torsional_response(machine: MachineFile, speeds: SpeedRange) -> None:
    """Print the greatest torques and twists in a drive train, by unbalance weight, bad alignment and ripples of the torque.

    Example: autobalancer torsional-response coupled_drive.toml \\
      --speeds "100 rpm:5000 rpm:400" --plot torsion.png
    """


@command("rotor.liquid_response", draw=True, unit="speed")
def liquid_response(machine: MachineFile, speeds: SpeedRange) -> Reply:
    """Print how far a rotor whose balancers are rings of liquid deflects in a steady whirl, with the liquid and without.

    Example: autobalancer liquid-response liquid_ring.toml \\
      --speeds "100 rpm:1000 rpm:400" --plot liquid.png
    """
    found = ab.rotor.liquid_response(machine, speeds)
    return Reply(found, facts=found.facts(speed_text))


# ``autobalancer equivalent-planar``: the planar oscillator that replaces a rotor at the plane of its balls.


@command(
    "rotor.equivalent_planar",
    take="method frequency",
    draw=True,
    allowed=(*MACHINE, *RESULT),
    unit="speed",
)
def equivalent_planar(
    machine: MachineFile,
    station: Annotated[str | None, "Station or position; by default that of the first balancer."] = None,
    **options: Any,
) -> Reply:
    """Find the planar oscillator that stands for a rotor at the plane of its balls, and say how far it holds.

    Example: autobalancer equivalent-planar rigid_rotor.toml \\
      --out planar.toml
    """
    from autobalancer.files.machine_file import load_race_machine

    described = load_race_machine(machine)
    place = None if station is None else _place(described, station)
    found = ab.rotor.equivalent_planar(described, place, **options)
    numbers = as_plain(found.data) | {"description": found.machine.description}
    return Reply(found.data, numbers, lines=[found.machine.description], machine=found.machine)


# Commands that ask what the fluid does to balls: drag from its equations, flow in a race, the equilibrium angle.


# ``autobalancer ball-drag``: the drag of a ball in its race, from the equations of the fluid.


@command(
    "flow.ball_drag",
    take="gap:m motion ball_ahead:m mesh_gap fineness balancer race",
    draw=True,
    bar="flow",
    topic="Fluid in a race",
)
def ball_drag(
    machine: MachineFile,
    reynolds: Annotated[
        list[float] | None, "Reynolds number; may be repeated, ascending. 0: no inertia of the fluid."
    ] = None,
    **options: Any,
) -> Reply:
    """Compute the drag of a ball in its race by finite elements, and the lines of the machine file that use it.

    Needs pip install "autobalancer\\[drag]". A few seconds for each Reynolds number up to 30, a minute at 100.

    Example: autobalancer ball-drag discoidal.toml --gap "1 um" \\
      --reynolds 0 --reynolds 10 --plot ball.png
    """
    from autobalancer.tables import Column

    options |= {"reynolds": reynolds} if reynolds else {}
    found = ab.flow.ball_drag(machine, **options)
    about = found.attrs
    heads = {"cd_times_re": "c_d Re", "drag_coefficient": "c_d", "lift": "lift/(mu r U)", "through_flow": "mean flow/U"}
    columns = [
        Column("Re", found["reynolds"].values),
        *(Column(head, found[key].values) for key, head in heads.items()),
    ]
    gap = f"{1e6 * about['gap']:.4g} um; ten times less adds {about['cd_times_re_per_decade']:.3g} to c_d Re"
    facts = [
        ("gap", gap),
        ("mesh", f"{about['elements']} elements, gap of {about['mesh_gap']:.3g} ball radii"),
        ("error", f"a mesh 1.5 times coarser differs by {100.0 * about['mesh_error']:.2g} %"),
    ]
    return Reply(found, facts=facts, columns=columns, code=f"in the machine file:\n{about['drag']}")


# ``autobalancer annulus-flow``: how the fluid in a race follows the rotor.


@command(
    "flow.annulus_flow",
    take="times*:s initial_speed:rad/s duration:s model error balancer race",
    draw=True,
    unit="speed",
    bar="flow",
    topic="Fluid in a race",
)
def annulus_flow(
    machine: MachineFile,
    speed: Annotated[
        float | None, In("rad/s"), 'A constant speed, such as "1200 rpm", in place of the profile of the machine.'
    ] = None,
    points: Annotated[str, 'Intervals in radial and axial direction, such as "24x32".'] = "",
    **options: Any,
) -> Reply:
    """Solve the flow in the annulus of a race and say how far the fluid lags behind the rotor.

    Example: autobalancer annulus-flow discoidal.toml \\
      --speed "60 rad/s" --initial-speed "0 rpm" --duration "2 s" \\
      --time "0.1 s" --plot flow.png
    """
    from autobalancer.flow.relaxation import flow_notes
    from autobalancer.results.answers.answer import Shown
    from autobalancer.tables import Column

    found = ab.flow.annulus_flow(machine, speed, points=_points(points), **options)
    about = found.attrs
    ends = float(found["speed"][-1] - found["fluid_speed"][-1])
    facts = [
        ("model", f"{about['model']}: {about['model_reason']}"),
        (
            "annulus",
            f"{1e3 * about['inner']:.5g} to {1e3 * about['outer']:.5g} mm, {1e3 * about['height']:.4g} mm high",
        ),
        ("orbit radius", f"{1e3 * about['orbit_radius']:.5g} mm"),
        ("Ekman number", f"{about['ekman_number']:.3g}, at the greatest speed"),
        ("greatest lag", speed_text(about["greatest_lag"], ".4g")),
        ("lag at the end", speed_text(ends, ".4g")),
        ("spin-up time", f"{about['spin_up_time']:.4g} s" if math.isfinite(about["spin_up_time"]) else "not reached"),
    ]
    names = {"speed": "rotor", "fluid_speed": "fluid at the orbit", "diffusion_speed": "fluid by diffusion alone"}
    columns = [Column("time", found["time"].values, "s")]
    columns += found.shown(speed_sign(), *(Shown(name, head, form=".10g") for name, head in names.items()))
    return Reply(found, facts=facts, columns=columns, brief=True, notes=flow_notes(found))


def _points(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise QuestionError(f"--points: given {text!r}; write radial and axial intervals, such as 24x32")
    return int(parts[0]), int(parts[1])


# ``autobalancer equilibrium-angle``: the equilibrium angle of one ball, and what measured angles say of drag and
# friction.


LINES = 20  # of a curve, on the screen


@command(draw=True, unit="speed", topic="Fluid in a race")
def equilibrium_angle(
    machine: MachineFile,
    speeds: Annotated[
        Any, Speeds(), '"from:to:count" or one speed, such as "2 rpm:60 rpm:30"; by default up to 85 deg.'
    ] = None,
    simulate: Annotated[bool, typer.Option("--simulate", help="Simulate a slow run-up as well.")] = False,
    duration: Annotated[Any, In("s"), "Of the run-up."] = "300 s",
    measured: Annotated[
        Path | None, "Evaluate this table: fluid, density \\[kg/m^3], ..., speed \\[rpm], angle \\[deg]."
    ] = None,
    rolling: Annotated[
        float | None, "With --measured: rolling resistance; by default fitted to overlapping series."
    ] = None,
    resamples: Annotated[int, "With --measured: repeated fits for the uncertainty."] = 100,
    pressure: Annotated[
        bool, typer.Option("--pressure", help="Draw with the pressure force of the turning fluid.")
    ] = False,
) -> Reply:
    """At which angle a single ball stands in a slowly turned race; drag coefficients and friction from measured angles.

    The machine has one ball on a horizontal axis.

    Example: autobalancer equilibrium-angle equilibrium_angle.toml \\
      --measured equilibrium_angles.csv --plot drag.png
    """
    if measured is not None:
        if speeds is not None or simulate:
            raise QuestionError("--measured: evaluates the speeds of the table; leave out --speeds and --simulate")
        series = ab.measure.load_angle_series(measured)
        return _evaluated(ab.measure.evaluate_angles(machine, series, rolling=rolling, resamples=resamples), pressure)
    found = ab.measure.equilibrium_angle(machine, speeds, simulation=simulate, duration=duration)
    count = found.sizes["speed"]
    shown = sorted({round(k * (count - 1) / (LINES - 1)) for k in range(LINES)})
    law = f"drag law {found.attrs['drag_law']}, rolling resistance {found.attrs['rolling_resistance']:g}"
    more = f"{len(shown)} of {count} speeds; --csv and --out have all of them"
    return Reply(
        found,
        columns=_curve_columns(found),
        facts=(),
        brief=True,
        more=[("", _curve_columns(found.isel(speed=shown)))],
        lines=[*([more] if len(shown) < count else []), law],
    )


def _evaluated(found: xr.Dataset, pressure: bool) -> Reply:
    """Drag coefficients and rolling resistance of measured angles."""
    way: Any = "included" if pressure else "left out"
    lines = []
    for which, text in (("left out", "pressure force left out, (6.6)"), ("included", "pressure force included")):
        one = found.sel(pressure_force=which)
        deviation = float(one["rolling_resistance_deviation"])
        sure = f", standard deviation {deviation:.2g}" if math.isfinite(deviation) else ""
        lines.append(f"rolling resistance {float(one['rolling_resistance']):.4g}{sure}: {text}")
    said = {
        "fitted": "fitted to series that overlap",
        "given": "as given",
        "machine": "of the machine, since no series overlap",
    }
    lines.append(f"the coefficient is {said[found.attrs['rolling_resistance_from']]}")
    return Reply(
        found,
        columns=_series_columns(found),
        facts=(),
        lines=lines,
        draw=lambda: ab.plot.answer(found, pressure_force=way, speed_unit=speed_sign()),
    )


def _curve_columns(found: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

    names = {"angle": "statics", "angle_with_pressure": "with pressure", "simulated_angle": "simulated"}
    return [
        Column("speed", [float(speed_number(w, ".10g")) for w in found["speed"].values], speed_sign(), ".4g"),
        Column("Reynolds number", found["reynolds"].values, form=".4g"),
        *(
            Column(text, [math.degrees(value) for value in found[key].values], "deg", ".2f")
            for key, text in names.items()
            if key in found
        ),
    ]


def _series_columns(found: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

    series = found["series"].values
    names = list(dict.fromkeys(series.tolist()))
    parts = [found.isel({found["series"].dims[0]: series == name}) for name in names]
    reynolds = [part["reynolds"].values for part in parts]
    columns = [
        Column("series", names, wraps=True),
        Column("points", [int(re.size) for re in reynolds]),
        Column("Re from", [float(re.min()) for re in reynolds], form=".3g"),
        Column("Re to", [float(re.max()) for re in reynolds], form=".3g"),
    ]
    for way, text in (("left out", "c_d over law"), ("included", "with pressure")):
        over = [part.sel(pressure_force=way) for part in parts]
        ratios = [(one["drag_coefficient"] / one["law_coefficient"]).values for one in over]
        columns.append(Column(f"{text}, least", [float(ratio.min()) for ratio in ratios], form=".3f"))
        columns.append(Column(f"{text}, most", [float(ratio.max()) for ratio in ratios], form=".3f"))
    return columns
