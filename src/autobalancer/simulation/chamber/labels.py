"""Names, units and frames of the variables of a chamber run."""

from __future__ import annotations

import xarray as xr

from autobalancer.results.labels import Label

LABELS: dict[str, Label] = {
    "time": Label("time", "s"),
    "ball": Label("ball, counted from 1", ""),
    "axis": Label("x along the rotor, y and z across it", ""),
    "bearing": Label("bearing, the second one guides along the axis", ""),
    "ball_radius": Label("radius of the ball", "m"),
    "ball_mass": Label("mass of the ball", "kg"),
    "chamber": Label("chamber of the ball, counted from 1", ""),
    "rotor_angle": Label("rotor angle", "rad", "space"),
    "speed": Label("rotor speed", "rad/s"),
    "body_position": Label("displacement of the middle of the rotor", "m", "space"),
    "body_rotation": Label("rotation of the body", "rad", "space"),
    "ball_position": Label("place of the ball from the middle of its chamber", "m", "body"),
    "ball_velocity": Label("velocity of the ball", "m/s", "space"),
    "ball_spin": Label("spin of the ball", "rad/s", "space"),
    "bearing_force": Label("force of a bearing on the rotor, mean since the last sample", "N", "space"),
    "constraint_force": Label("force that holds locked coordinates, mean since the last sample", "N", "space"),
    "constraint_moment": Label("moment that holds locked coordinates, mean since the last sample", "N m", "space"),
    "motor_torque": Label("torque of the drive on the rotor", "N m"),
    "energy_kinetic": Label("kinetic energy", "J"),
    "energy_potential": Label("energy of supports and weight", "J"),
    "energy_contact": Label("energy stored in contacts that comes back", "J"),
    "work_motor": Label("work of the drive", "J"),
    "loss_contact": Label("energy lost in collisions", "J"),
    "loss_friction": Label("energy lost in sliding", "J"),
    "loss_rolling": Label("energy lost in rolling", "J"),
    "loss_supports": Label("energy lost in supports", "J"),
    "loss_bearings": Label("energy lost in bearings", "J"),
    "loss_drag": Label("energy lost in the fluid", "J"),
    "energy_error": Label("energy less work and plus losses, less energy at time 0", "J"),
    "contacts_ball": Label("contacts of two balls begun since the last sample", ""),
    "contacts_wall": Label("contacts with walls begun since the last sample", ""),
    "greatest_contact_force": Label("greatest normal force since the last sample", "N"),
}


def label_chamber(dataset: xr.Dataset) -> xr.Dataset:
    """Attach unit, long name and frame to every variable of ``dataset``; returns it."""
    for name in dataset.variables:
        entry = LABELS[str(name)]
        dataset[name].attrs.update(long_name=entry.long_name, units=entry.units)
        if entry.frame:
            dataset[name].attrs["frame"] = entry.frame
    return dataset
