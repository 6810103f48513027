"""Commands that ask how the rotor itself moves: modes, responses, torsion, liquid, the planar oscillator in its place."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import autobalancer as ab
from autobalancer.cli.terminal.command import MACHINE, RESULT, Reply, as_plain, command
from autobalancer.cli.terminal.options import COUNT, In, MachineFile, Ranged, Speeds, quantity
from autobalancer.cli.terminal.sheet import speed_sign, speed_text
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.tables import Column


SpeedRange = Annotated[
    Any, Speeds(COUNT), '"from:to" or "from:to:count", such as "600 rpm:5500 rpm:400", or one speed.'
]


# ``autobalancer modes`` and ``campbell``: natural frequencies and critical speeds.


@command("rotor.modes", take="speed:rad/s balls modes rubber_amplitude:m motion", draw="modes", unit="both")
def modes(machine: MachineFile, **options: Any) -> Reply:
    """Print natural frequencies with damping and direction of whirl, and the critical speeds, which are without damping.

    Example: autobalancer modes rigid_rotor.toml --speed "1200 rpm"
    """
    return _with_critical_speeds(ab.rotor.modes(machine, **options), machine, options["balls"])


@command("rotor.campbell", take="balls modes", draw="campbell", unit="both")
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


@command("rotor.response", take="balls quantity", draw="", unit="speed")
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
            return (ab.plot.polar_response if kind == "polar" else ab.plot.response)(smooth, **look)
        orbits = ab.rotor.whirl_orbits(described, float(speeds[0]), *about, balls=options["balls"])
        return (ab.plot.whirl_along_axis if kind == "axis" else ab.plot.whirl_orbits)(orbits, **look)

    numbers = as_plain(found)
    if not many:
        return Reply(found, numbers, columns=_whirl(found), facts=(), draw=draw)
    peaks = ab.rotor.response_peaks(described, float(speeds[0]), float(speeds[-1]), *about, **options)
    mean = f"mean over the stations, greatest {options['quantity']}"
    return Reply(found, numbers, more=[(mean, peaks.columns(speed_sign()))], lines=peaks.remarks(), draw=draw)


def _place(machine: Any, text: str) -> str | float:
    """The name of a station, or a position where no station has this name."""
    known = any(station.name == text for station in machine.stations)
    return text if known or text.strip()[:1] not in set("+-.0123456789") else float(quantity("--station", text, "m"))


def _whirl(found: xr.Dataset) -> list[Column]:
    """How each station whirls at one speed."""
    from autobalancer.results.display_units import length_text
    from autobalancer.tables import Column

    at, rate = found.isel(speed=0), {"displacement": "", "velocity": "/s", "acceleration": "/s^2"}
    sizes = {
        name: [length_text(float(size)) + rate[found.attrs["quantity"]] for size in at[name].values]
        for name in ("semi_major", "semi_minor")
    }
    return [
        Column("station", [str(name) for name in at["station"].values]),
        Column("whirl", at["whirl"].values.tolist()),
        *(Column(name.replace("_", "-"), texts) for name, texts in sizes.items()),
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
    found = ab.rotor.torsional_modes(machine, **options)
    critical = ab.rotor.torsional_critical_speeds(machine, harmonics=harmonic)
    tables = [("torsional critical speeds, without damping", critical.columns(speed_sign()))]
    if critical.sizes["crossing"]:
        tables.append(("with damping: where the frequency of a mode is met", critical.damped_columns(speed_sign())))
    return Reply(found, as_plain(found) | {"critical_speeds": as_plain(critical)}, more=tables)


@command("rotor.torsional_response", draw="torsional_response", unit="speed")
def torsional_response(machine: MachineFile, speeds: SpeedRange) -> None:
    """Print the greatest torques and twists in a drive train, by unbalance weight, bad alignment and ripples of the torque.

    Example: autobalancer torsional-response coupled_drive.toml \\
      --speeds "100 rpm:5000 rpm:400" --plot torsion.png
    """


@command("rotor.liquid_response", draw="liquid_response", unit="speed")
def liquid_response(machine: MachineFile, speeds: SpeedRange) -> Reply:
    """Print how far a rotor whose balancers are rings of liquid deflects in a steady whirl, with the liquid and without.

    Example: autobalancer liquid-response liquid_ring.toml \\
      --speeds "100 rpm:1000 rpm:400" --plot liquid.png
    """
    found = ab.rotor.liquid_response(machine, speeds)
    return Reply(found, facts=found.rows(speed_text))


# ``autobalancer equivalent-planar``: the planar oscillator that replaces a rotor at the plane of its balls.


@command(
    "rotor.equivalent_planar",
    take="method frequency",
    draw="equivalent_planar",
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
