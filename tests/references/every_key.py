"""Small machines that together have every key of a machine file, and each of them with one key changed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from autobalancer.errors import MachineError
from autobalancer.machine import Machine
from autobalancer.machine.keys import TAGS
from autobalancer.machine.part import Part
from autobalancer.machine.path import with_entry

CHANGE = 1.03
BALL = {"diameter": 0.01, "density": 7800.0}
OIL = {"density": 950.0, "viscosity": 5e-5, "virtual_mass": 2.5}
PAIR = {"orbit_radius": 0.08, "drag": {"law": "viscous", "damping": 2e-4}, "balls": [{"count": 2, **BALL}]}
WET = {**PAIR, "fluid": OIL, "drag": {"law": "cd_times_re", "cd_times_re": 60.0}}
RUBBING = {"friction": {"rolling_resistance": 1e-3, "adherence": 2e-3}}
PLANAR = {"kind": "planar", "mass": 10.0, "stiffness": 4e4, "damping": 60.0, "inertia": 0.1}
CONSTANT = {"kind": "speed", "profile": {"kind": "constant", "speed": 120.0}}
RECORD = {"time": [0.0, 1.0, 2.0], "direction": 0.2}
SUPPORTS = [
    {"position": -0.1, "stiffness": 2e4, "damping": 30.0, "tilt_stiffness": 50.0, "tilt_damping": 0.1},
    {"position": 0.12, "table": {"speed": [0.0, 5000.0], "stiffness": [2e4, 2.2e4], "damping": [30.0, 31.0]}},
]
PLANES = [
    {"name": "left", "station": -0.06, "races": [PAIR | RUBBING]},
    {"station": "right", "races": [PAIR | RUBBING | {"eccentricity": 1e-5, "eccentricity_angle": 0.3}]},
]
UNEVEN = [
    {"moment": 3e-4, "angle": 0.4, "station": -0.06},
    {"mass": 0.01, "radius": 0.02, "station": 0.03},
    {"couple": 2e-5, "angle": 1.0},
]
MOTORS: dict[str, dict[str, Any]] = {
    "torque": {"torque": 2.0, "damping": 0.01},
    "target_torque": {"gain": 0.02, "damping": 0.01,
         "profile": {"kind": "hill", "end": 120.0, "half_time": 2.0, "exponent": 2.0}},
    "torque_table": {"speed": [0.0, 200.0], "torque": [2.0, 1.0], "damping": 0.01},
    "asynchronous": {"rated_torque": 2.0, "overload": 2.0, "synchronous_speed": 150.0, "breakdown_slip": 0.2, "damping": 0.01},
}  # fmt: skip
PROFILES: list[dict[str, Any]] = [
    {"kind": "ramp", "start": 10.0, "end": 120.0, "duration": 5.0, "delay": 1.0},
    {"kind": "table", "time": [0.0, 5.0], "speed": [0.0, 120.0]},
    {"kind": "dwell", "speeds": [80.0, 120.0], "hold": 2.0, "acceleration": 5.0},
    {"kind": "reduction", "start": 1.0, "peak": 130.0, "reduced": 90.0, "end": 120.0, "acceleration": 10.0, "hold_peak": 1.0,
     "hold_reduced": 1.0, "dwell": 40.0, "hold_dwell": 1.0},
]  # fmt: skip
FORCES: list[dict[str, Any]] = [
    {"kind": "race_springs", "stiffness": 0.5, "free_length": 0.02},
    {"kind": "radial_spring", "stiffness": 20.0, "free_length": 0.05},
    {"kind": "repelling_balls", "moment": 0.05},
    {"kind": "pins", "count": 2, "hold": 0.05, "reach": 0.004, "release_speed": 80.0},
    {"kind": "magnets", "force_at_contact": 0.5, "reach": 0.004, "radius": 0.09, "count": 3, "angle": 0.2},
]


def machine(*races: dict[str, Any], rotor: dict[str, Any] | None = None, **more: Any) -> Machine:
    """A planar machine, or one on another rotor."""
    entries = {
        "name": "small",
        "axis": "vertical",
        "rotor": rotor or PLANAR,
        "unbalances": [{"moment": 3e-4, "angle": 0.4}],
        "balancers": [{"races": list(races or (PAIR,))}],
        "drive": CONSTANT,
    }
    return Machine(**(entries | more))


def machines() -> Iterator[Machine]:
    """All of them."""
    meeting = {"restitution": 0.5, "friction": 0.1, "slip_speed": 0.01}
    room = {"width": 0.015, "height": 0.015}
    rebound = {"yield_speed": 0.1, "exponent": 0.2, "critical_stokes": 10.0}
    shaken = [
        {"kind": "base_motion", "displacement": 1e-5, "frequency": 50.0, "phase": 0.1, "direction": 0.2},
        {"kind": "base_motion", "acceleration": 1.0, "order": 2.0},
        {"kind": "force", "force": 1.0, "frequency": 50.0, "phase": 0.1, "direction": 0.2},
        {"kind": "force", "force": 1.0, "order": 2.0},
        {"kind": "recorded_force", "force": [0.0, 1.0, 0.0], **RECORD},
        {"kind": "recorded_base_motion", "acceleration": [0.0, 1.0, 0.0], **RECORD},
    ]
    scheduled = [{"mass": 0.01, "radius": 0.03, "angle": 0.4, "schedule": {"time": [1.0, 2.0], "factor": [0.5, 0.9]}}]
    yield machine(
        WET | room | RUBBING | {"contact": meeting | {"rebound": rebound}},
        excitations=shaken,
        unbalances=scheduled,
        start={"rotor_angle": 0.1, "deflection": [1e-5, 1e-5], "velocity": [1e-3, 1e-3]},
        run={"duration": 5.0},
    )
    table = {"speeds": [0.1, 0.2], "factors": [1.0, 0.8]}
    coupling = {"stiffness": 1e3, "damping": 0.1, "inertia": 0.01, "error": 1e-3, "order": 2.0, "phase": 0.1}
    unequal = [
        {**BALL, "start_angles": 0.1},
        {"mass": 0.004, "diameter": 0.011, "start_angles": 2.0, "start_speeds": 0.1},
    ]
    yield machine(
        {"race_radius": 0.085, "drag": PAIR["drag"], **RUBBING, "balls": unequal,
         "harmonics": [{"order": 2, "amplitude": 1e-5, "angle": 0.1}],
         "contact": {"restitution": 0.5, "stiffness": 1e5, "rebound": table}, "eccentricity": 1e-5, "eccentricity_angle": 0.3},
        rotor=PLANAR | {"hardening": {"cubic_stiffness": 1e9, "clearance": 1e-5, "contact_stiffness": 1e5}},
        drive=CONSTANT | {"couplings": [coupling]},
    )  # fmt: skip
    law = {"hardening": {"distance": [1e-5, 2e-4], "force": [1.0, 3.0]}}
    wave = {
        "roundness": {"deviations": [0.0, 1e-6, 2e-6, 1e-6, 0.0, -1e-6, -2e-6, -1e-6], "angle": 0.1, "harmonics": 2}
    }
    critical = {"kind": "planar", "mass": 10.0, "critical_speed": 63.0, "damping_ratio": 0.05, "inertia": 0.1}
    motion = {"stiffness": 50.0, "damping": 0.1}
    for number, (kind, motor) in enumerate(MOTORS.items()):
        drive = {"kind": kind, **motor}
        if number == 0:
            drive |= {"couplings": [{"stiffness": 1e3, "inertia": 0.01}], "mount": {"inertia": 0.1, **motion},
                      "ripples": [{"torque": 0.1, "order": 6.0, "phase": 0.1}]}  # fmt: skip
        yield machine(
            PAIR | RUBBING | wave, rotor=critical | law if number < 2 else critical, drive=drive, start={"speed": 1.0}
        )
    wide = {"kind": "planar", "mass": 10.0, "stiffness": 4e4, "half_power_bandwidth": 0.1}
    for number, profile in enumerate(PROFILES):
        walls = {"partitions": {"count": 3, "angle": 0.1}} if number == 0 else RUBBING
        yield machine(PAIR | walls, rotor=wide, drive={"kind": "speed", "profile": profile})
    rubber = {"stiffness": 3e4, "damping": 20.0, "friction": {"breakaway_amplitude": [1e-4], "stiffness": [5e3]},
              "maxwell": {"relaxation_time": [0.01], "stiffness": [5e3]}}  # fmt: skip
    yield machine(PAIR | RUBBING | {"collisions": False}, rotor={"kind": "planar", "mass": 10.0, "rubber": rubber})
    for force in FORCES:
        yield machine(PAIR | {"forces": [force]})
    climbing = {"kind": "inclined_race", "incline": 0.5, "inner_radius": 0.078, "outer_radius": 0.085}
    floor = {"stiffness": 1e6, "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": 0.01}
    yield machine(PAIR | {"forces": [climbing], "resolved": floor})
    for filled in ({"layer": 2e-3, "width": 2.03e-3}, {"liquid": 0.05}):
        ring = {"radius": 0.1, "height": 0.05, "fluid": OIL | {"virtual_mass": 0.5}, **filled}
        yield machine(balancers=[], liquid_rings=[ring])
    touching = {"stiffness": 1e6, "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": 0.01, "rest_speed": 1e-3,
                "floor_friction": 0.05, "ball_friction": 0.02, "start_gap": 1e-5,
                "friction_law": {"kind": "stribeck", "peak": 0.2, "peak_speed": 0.05}}  # fmt: skip
    yield machine(PAIR | RUBBING | {"resolved": touching})
    hertz = {
        "reduced_modulus": 1e9,
        "restitution": 0.5,
        "sliding_friction": 0.1,
        "slip_speed": 0.01,
        "rebound": rebound,
    }
    yield machine(WET | RUBBING | {"resolved": hertz | {"rest_speed": 1e-3}})
    yield machine(PAIR | {"resolved": {"stiffness": 1e6, "damping": 1.0, "sliding_friction": 0.1, "slip_speed": 0.01}})
    for drag in (
        {"law": "cd_times_re", "cd_times_re": 60.0, "range": "whole", "plateau": 0.2},
        {"law": "table", "reynolds": [0.1, 10.0, 1000.0], "coefficient": [500.0, 6.0, 0.6]},
        {"law": "race_geometry", "clear_width": 1e-3},
        {"law": "discoidal"},
        {"law": "free_sphere"},
        {"law": "sphere_on_plane"},
    ):
        yield machine(WET | RUBBING | {"drag": drag, "slipstream": True})
    for shear in (
        {"law": "carreau", "time": 0.1, "exponent": 0.5, "width": 2.0, "high": 0.1, "at_ball": 0.5},
        {"law": "cross", "time": 0.1, "power": 0.7, "high": 0.1, "at_ball": 0.5},
        {"law": "power_law", "exponent": 0.5, "lowest": 1.0, "highest_rate": 1e4, "at_ball": 0.5},
        {"law": "table", "rates": [1.0, 3.0], "shares": [1.0, 0.8], "at_ball": 0.5},
    ):
        yield machine(WET | RUBBING | {"fluid": OIL | {"shear": shear}})
    yield machine(WET | RUBBING | {"fluid": {"name": "water", "temperature": 293.15}})
    rollers = [
        {"body": "roller", "count": 2, "diameter": 0.01, "length": 0.012, "density": 7800.0, "inner_diameter": 0.004}
    ]
    yield machine(PAIR | RUBBING | {"balls": rollers})
    pendulums = [{"body": "pendulum", "count": 2, "mass": 0.01, "inertia": 1e-6, "bearing_radius": 0.01}]
    yield machine(PAIR | RUBBING | {"balls": pendulums})
    modes = [
        {"mass": 10.0, "frequency": 63.0, "damping_ratio": 0.05},
        {"mass": 12.0, "frequency": 300.0, "damping_ratio": 0.05},
    ]
    yield machine(PAIR | RUBBING, rotor={"kind": "modal", "resonances": modes, "inertia": 0.1})
    yield from _with_planes()
    yield from _on_shafts_and_bodies()


def _with_planes() -> Iterator[Machine]:
    planes = {"balancers": PLANES, "stations": [{"name": "right", "position": 0.05}]}
    rigid = {"kind": "rigid", "mass": 10.0, "transverse_inertia": 0.05, "polar_inertia": 0.02}
    supported = {"rotor": rigid | {"supports": SUPPORTS, "stiffness_proportional_damping": 1e-4}, "unbalances": UNEVEN}
    yield machine(**supported, **planes | {"balancers": PLANES[1:]})  # of one plane more is known, and sooner
    yield machine(**supported, **planes)
    crossed = [SUPPORTS[0] | {"position": 0.1, "cross_stiffness": [10.0, -10.0]}, SUPPORTS[0] | {"position": -0.12}]
    tilted = [*UNEVEN[:2], {"misalignment": 1e-3, "angle": 0.2}]
    yield machine(rotor=rigid | {"supports": crossed}, unbalances=tilted, tilting_races="full", **planes)


def _on_shafts_and_bodies() -> Iterator[Machine]:
    """Two planes on a shaft, and one on two bodies with joints."""
    material = {"density": 7850.0, "youngs_modulus": 2.1e11, "poisson_ratio": 0.3}
    disk = {"name": "disk", "position": 0.1, "mass": 4.0, "transverse_inertia": 0.01, "polar_inertia": 0.02, "offset": 0.01,
            "extent": [-0.01, 0.03]}  # fmt: skip
    steel = {"kind": "shaft", "material": material, "disks": [disk], "stiffness_proportional_damping": 1e-4, "modes": 4,
             "segments": [{"length": 0.2, "diameter": 0.02, "inner_diameter": 0.004, "elements": 4, "shear_coefficient": 0.9}],
             "supports": [{"position": 0.0, "stiffness": 2e4, "damping": 30.0}, SUPPORTS[0] | {"position": 0.12}]}  # fmt: skip
    at = {"stations": [{"name": "top", "position": 0.15}], "unbalances": [{"moment": 3e-4, "station": "top"}]}
    yield machine(rotor=steel, balancers=[{"station": "top", "races": [PAIR | RUBBING]}], **at)
    inertia = {"transverse_inertia": 0.02, "polar_inertia": 0.03}
    bodies = [
        {"name": "disc", "mass": 4.0, "position": 0.14, "rotating": True, **inertia},
        {"name": "housing", "mass": 7.0, "position": -0.02, "rotating": False, **inertia},
    ]
    joints = [
        {"kind": "bearing", "between": ["disc", "housing"], "position": at, "stiffness": 2e6, "damping": 30.0}
        for at in (0.07, -0.05)
    ]
    joints[0]["axial_stiffness"] = 3e6
    feet = {"kind": "bushing", "between": ["housing", "ground"], "position": -0.03, "count": 3, "radius": 0.1, "angle": 0.1,
            "shear_stiffness": 1.6e4, "shear_damping": 20.0, "axial_stiffness": 9e4, "axial_damping": 130.0}  # fmt: skip
    there = {"stations": [{"name": "disc", "position": 0.15, "body": "disc"}]}
    yield machine(
        rotor={"kind": "multibody", "bodies": bodies, "joints": [*joints, feet], "up": "+z", "modes": 4},
        balancers=[{"station": "disc", "races": [PAIR | RUBBING]}],
        unbalances=[{"moment": 3e-4, "station": "disc"}],
        **there,
    )


def variants(base: Machine) -> Iterator[tuple[type[Part], str, Machine]]:
    """Each number of a machine changed, one at a time: the part, its key and the machine."""
    for part, key, path, value in _numbers(base, ""):
        try:
            yield part, key, with_entry(base, path, _changed(value))
        except MachineError:  # such as one of two numbers that must agree
            continue


def _changed(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return value + 1
    return tuple(map(_changed, value)) if isinstance(value, tuple) else CHANGE * value if value else 1e-6


def _numbers(part: Part, at: str) -> Iterator[tuple[type[Part], str, str, Any]]:
    for key in type(part).model_fields:
        value, path = getattr(part, key), f"{at}.{key}".lstrip(".")
        if isinstance(value, Part):
            yield from _numbers(value, path)
        elif isinstance(value, tuple) and value and isinstance(value[0], Part):
            for number, one in enumerate(value, 1):
                yield from _numbers(one, f"{path}[{number}]")
        elif key not in TAGS and key in part.model_fields_set and _is_numeric(value):
            yield type(part), key, path, value


def _is_numeric(value: Any) -> bool:
    return isinstance(value, (bool, int, float)) or (
        isinstance(value, tuple) and bool(value) and all(map(_is_numeric, value))
    )
