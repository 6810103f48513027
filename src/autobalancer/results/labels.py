"""The vocabulary of results: one name, one unit, one meaning, for simulated and measured data alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import xarray as xr


@dataclass(frozen=True)
class Label:
    """Long name, SI unit and, where they matter, the frame and the symbol in formulas (LaTeX)."""

    long_name: str
    units: str
    frame: str = ""
    symbol: str = ""


class Variable(NamedTuple):
    """A number that a library gives or takes, as in a run."""

    name: str
    unit: str
    meaning: str
    start: float = 0.0
    least: float = -math.inf
    greatest: float = math.inf


LABELS: dict[str, Label] = {
    "time": Label("time", "s", symbol="t"),
    "speed": Label("rotor speed", "rad/s", symbol="w"),
    "rotor_angle": Label("rotor angle", "rad", "space", symbol="\\theta"),
    "x": Label("deflection along x", "m", "space"),
    "y": Label("deflection along y", "m", "space"),
    "deflection": Label("deflection", "m"),
    "ball_angle_in_rotor": Label("ball angle in the rotor", "rad", "rotor", symbol="\\varphi"),
    "ball_speed_in_rotor": Label("ball speed in the rotor", "rad/s", "rotor"),
    "ball_speed_in_space": Label("ball speed in space", "rad/s", "space"),
    "ball_x": Label("position of a resolved ball along x", "m", "space"),
    "ball_y": Label("position of a resolved ball along y", "m", "space"),
    "ball_gap": Label("distance of a ball from the wall of its race, negative in contact", "m"),
    "ball_spin": Label("spin of a resolved ball", "rad/s", "space"),
    "ball_at_rest": Label("whether adherence holds the ball at rest in the rotor", ""),
    "ball_floor_force": Label("force of the floor on a ball", "N"),
    "ball_normal_force": Label("normal force of the race on a ball", "N", symbol="F_N"),
    "link": Label("what turns behind a link of the drive train: on the motor's side of a coupling, or the stator", ""),
    "twist": Label("twist of a coupling, motor against rotor; of the stator its angle in its mount", "rad"),
    "link_speed": Label("speed of what turns behind a link", "rad/s", "space"),
    "link_torque": Label("torque of a coupling towards the rotor; of the stator on its mount", "N m"),
    "force_energy": Label("potential energy of the forces on balls that have one", "J"),
    "unbalance": Label("unbalance of the rotor without balls", "kg m", symbol="U"),
    "unbalance_angle_in_rotor": Label("angle of this unbalance in the rotor", "rad", "rotor"),
    "residual_unbalance": Label("resultant of unbalance and balls", "kg m"),
    "envelope_time": Label("middle of the bin", "s"),
    "envelope_end": Label("end of the bin", "s"),
    "envelope_low": Label("least deflection in the bin", "m"),
    "envelope_high": Label("greatest deflection in the bin", "m"),
    "envelope_speed": Label("rotor speed at the end of the bin", "rad/s"),
    "envelope_ball_angle_in_rotor": Label("ball angle in the rotor at the end of the bin", "rad", "rotor"),
    "envelope_ball_speed_in_rotor": Label("ball speed in the rotor at the end of the bin", "rad/s", "rotor"),
    "turn_time": Label("time, at equal steps of the rotor angle", "s"),
    "turn_rotor_angle": Label("rotor angle in the last revolutions", "rad", "space"),
    "turn_speed": Label("rotor speed in the last revolutions", "rad/s"),
    "turn_x": Label("deflection along x in the last revolutions", "m", "space"),
    "turn_y": Label("deflection along y in the last revolutions", "m", "space"),
    "station": Label("station", ""),
    "station_x": Label("deflection along x at a station", "m", "space"),
    "station_y": Label("deflection along y at a station", "m", "space"),
    "turn_station_x": Label("deflection along x at a station in the last revolutions", "m", "space"),
    "turn_station_y": Label("deflection along y at a station in the last revolutions", "m", "space"),
    "turn_ball_angle_in_rotor": Label("ball angle in the rotor in the last revolutions", "rad", "rotor"),
    "plane": Label("plane of balancers", ""),
    "ball_plane": Label("plane of the ball, counted from 1", ""),
    "plane_position": Label("place of the plane along the axis", "m"),
    "station_position": Label("place of the station along the axis", "m"),
    "couple_unbalance": Label("couple unbalance of the rotor without balls", "kg m^2", symbol="\\chi"),
    "couple_unbalance_angle_in_rotor": Label("angle of its part at greater z in the rotor", "rad", "rotor"),
    "plane_x": Label("deflection along x in a plane of balancers", "m", "space"),
    "plane_y": Label("deflection along y in a plane of balancers", "m", "space"),
    "plane_unbalance": Label("unbalance that the balls of a plane have to balance at this speed", "kg m"),
    "plane_unbalance_angle_in_rotor": Label("angle of this unbalance in the rotor", "rad", "rotor"),
    "plane_balls": Label("resultant of the balls of a plane", "kg m"),
    "plane_balls_angle_in_rotor": Label("angle of this resultant in the rotor", "rad", "rotor"),
    "place": Label("plane of balancers, station or support", ""),
    "place_kind": Label("what the place is: plane, reference, station or support", ""),
    "turn_place_x": Label("deflection along x at a place in the last revolutions", "m", "space"),
    "turn_place_y": Label("deflection along y at a place in the last revolutions", "m", "space"),
    "turn_place_vx": Label("velocity along x at a place in the last revolutions", "m/s", "space"),
    "turn_place_vy": Label("velocity along y at a place in the last revolutions", "m/s", "space"),
    "turn_plane_unbalance": Label("unbalance that the balls of a plane have to balance, last revolutions", "kg m"),
    "turn_plane_unbalance_angle_in_rotor": Label("angle of this unbalance in the rotor", "rad", "rotor"),
    "turn_plane_balls": Label("resultant of the balls of a plane, last revolutions", "kg m"),
    "turn_plane_balls_angle_in_rotor": Label("angle of this resultant in the rotor", "rad", "rotor"),
    "turn_plane_residual_x": Label("what the balls of a plane leave of its unbalance, along x of the rotor", "kg m"),
    "turn_plane_residual_y": Label("the same along y of the rotor, last revolutions", "kg m"),
    "turn_unbalance": Label("unbalance of the rotor without balls, last revolutions", "kg m"),
    "turn_residual_x": Label("resultant of unbalance and balls along x of the rotor, last revolutions", "kg m"),
    "turn_residual_y": Label("the same along y of the rotor, last revolutions", "kg m"),
    "rotor_sag": Label(
        "static deflection of the rotor without balls under its weight, from which deflections count", "m"
    ),
    "vibration_without_balls": Label("greatest vibration at the last speed with the balls spread and held", "m"),
    "force_without_balls": Label("greatest vibrating force at the last speed with the balls spread and held", "N"),
    "support": Label("support or joint between the rotor and the ground", ""),
    "support_force_x": Label("force of the rotor on a support along x, its weight included", "N", "space"),
    "support_force_y": Label("force of the rotor on a support along y, its weight included", "N", "space"),
    "turn_support_force_x": Label("force on a support along x in the last revolutions", "N", "space"),
    "turn_support_force_y": Label("force on a support along y in the last revolutions", "N", "space"),
    "impact_time": Label("time of the impact", "s"),
    "impact_speed": Label("speed at which the bodies approached", "m/s"),
    "impact_loss": Label("energy that the impact takes, by its restitution", "J"),
    "impact_impulse": Label("impulse of the impact, by its restitution", "N s"),
    "impact_ball": Label("ball that hits, counted from 1", ""),
    "impact_partner": Label("ball that is hit; 0: a partition, -1: a wall of the race", ""),
    "event_time": Label("time of the event", "s"),
    "event_name": Label("what happened", ""),
    "event_speed": Label("rotor speed at the event", "rad/s"),
    "event_deflection": Label("deflection at the event", "m"),
    "balancer": Label("balancer of the ball, counted from 1", ""),
    "balancer_name": Label("name of the balancer of the ball", ""),
    "race": Label("race of the ball in its balancer, counted from 1", ""),
    "ball": Label("ball, counted from 1", ""),
    "orbit_radius": Label("orbit radius of the ball", "m", symbol="\\varepsilon"),
    "ball_diameter": Label("diameter of the ball, 0 if not given", "m"),
    "ball_body": Label("what runs in place of balls, if any does: ball, roller or pendulum", ""),
    "ball_moment": Label("effective mass times orbit radius", "kg m", symbol="m\\,\\varepsilon"),
    "race_center_x": Label("race center in the rotor", "m", "rotor"),
    "race_center_y": Label("race center in the rotor", "m", "rotor"),
    # of deep chambers, with x along the rotor
    "axis": Label("x along the rotor, y and z across it", ""),
    "bearing": Label("bearing, the second one guides along the axis", ""),
    "ball_radius": Label("radius of the ball", "m"),
    "ball_mass": Label("mass of the ball", "kg"),
    "ball_length": Label("length of the cylinder along the rotor, in runs of cylinders", "m"),
    "chamber": Label("chamber of the ball, counted from 1", ""),
    "body_position": Label("displacement of the middle of the rotor", "m", "space"),
    "body_rotation": Label("rotation of the body", "rad", "space"),
    "ball_position": Label("position of the ball from the middle of its chamber", "m", "body"),
    "ball_velocity": Label("velocity of the ball", "m/s", "space"),
    "bearing_force": Label("force of a bearing on the rotor, mean since the last sample", "N", "space"),
    "constraint_force": Label("force that holds locked coordinates, mean since the last sample", "N", "space"),
    "constraint_moment": Label("moment that holds locked coordinates, mean since the last sample", "N m", "space"),
    "motor_torque": Label("torque of the drive on the rotor", "N m"),
    "energy_kinetic": Label("kinetic energy", "J"),
    "energy_potential": Label("energy of supports and weight", "J"),
    "energy_contact": Label("recoverable energy stored in contacts", "J"),
    "work_motor": Label("work of the drive", "J"),
    "loss_contact": Label("energy lost in collisions", "J"),
    "loss_friction": Label("energy lost in sliding", "J"),
    "loss_rolling": Label("energy lost in rolling", "J"),
    "loss_supports": Label("energy lost in supports", "J"),
    "loss_bearings": Label("energy lost in bearings", "J"),
    "loss_drag": Label("energy lost in the fluid", "J"),
    "energy_error": Label("error of the energy balance: energy minus work plus losses, minus energy at time 0", "J"),
    "contacts_ball": Label("contacts of two balls begun since the last sample", ""),
    "contacts_wall": Label("contacts with walls begun since the last sample", ""),
    "tilting": Label(
        "greatest moment that would tilt a cylinder over what its contacts could bear, since the last sample", ""
    ),
    "greatest_contact_force": Label("greatest normal force since the last sample", "N"),
    "impact_speeds": Label("sum of the speeds at which contacts began since the last sample", "m/s"),
    "impact_energies": Label("sum of the energies of approach with which contacts began since the last sample", "J"),
}


def label(dataset: xr.Dataset) -> xr.Dataset:
    """Attach long name, unit, frame and symbol to every variable of ``dataset``; returns it."""
    for name, variable in dataset.variables.items():  # not dataset[name], which makes an array of each anew
        entry = LABELS[str(name)]
        variable.attrs.update(long_name=entry.long_name, units=entry.units)
        more = {"frame": entry.frame, "symbol": entry.symbol}
        variable.attrs.update({key: text for key, text in more.items() if text})
    return dataset


def labeled(
    data: Mapping[str, tuple[Any, ...]],
    coordinates: Mapping[str, tuple[Any, ...]] | None = None,
    attributes: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """A dataset of variables and coordinates that say what they are: dimensions, values, long name and, if it has one, unit."""

    def variables(entries: Mapping[str, tuple[Any, ...]]) -> dict[str, tuple[Any, ...]]:
        return {
            name: (dims, values, dict(zip(("long_name", "units"), about, strict=False)))
            for name, (dims, values, *about) in entries.items()
        }

    return xr.Dataset(variables(data), variables(coordinates or {}), attributes)
