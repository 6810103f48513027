"""What the keys of rigid rotors, supports, stations and excitations mean."""

WITHIN = "of the rotor, which is the frequency of its unbalance; must increase and cover all speeds that are used"
PACE = "of a steady vibration, as turns of its own: 10 Hz is 62.83 rad/s; this or `order`"
ORDER = "cycles per turn of the rotor, any number above zero: 1 is synchronous; in place of a frequency"
PHASE = "at time zero; with an `order`, at rotor angle zero"
DIRECTION = "in space, from the x axis"
RECORD = "must increase; no excitation before the first and after the last time"
PUSHED = "where the force acts: a position, or the name of a station; not needed on a planar rotor"

EXCITATIONS = {
    "BaseMotion": {
        "acceleration": "amplitude; this or `displacement`",
        "displacement": "amplitude; requires a `frequency`",
        "frequency": PACE,
        "order": ORDER,
        "phase": PHASE,
        "direction": DIRECTION,
    },
    "RecordedBaseMotion": {
        "time": RECORD,
        "acceleration": "as many as times; a smooth curve goes through them",
        "direction": DIRECTION,
    },
    "HarmonicForce": {
        "station": PUSHED,
        "force": "amplitude",
        "frequency": PACE,
        "order": ORDER,
        "phase": PHASE,
        "direction": DIRECTION,
    },
    "RecordedForce": {
        "station": PUSHED,
        "time": RECORD,
        "force": "as many as times; a smooth curve goes through them",
        "direction": DIRECTION,
    },
}

ROTOR_MEANINGS = {
    "RigidRotor.mass": "without balls, with all attached parts, and races full of fluid",
    "RigidRotor.transverse_inertia": "about a diameter through the mass center, without balls",
    "RigidRotor.polar_inertia": "about the axis, without balls; at most twice the transverse one",
    "RigidRotor.supports": "springs at two positions, or one with `tilt_stiffness`",
    "RigidRotor.stiffness_proportional_damping": "factor t in C = t K, added to the damping of the supports",
    "Support.position": "along the axis, counted as for stations",
    "Support.stiffness": "across the axis; this or a `table`, or neither for a pure damper",
    "Support.damping": "across the axis; not with a `table`, which contains it",
    "Support.table": "stiffness and damping over the speed, in place of two constants",
    "Support.cross_stiffness": "$k_{xy}$ and $k_{yx}$ of a fluid film, of any sign",
    "Support.tilt_stiffness": "against the slope of the axis",
    "Support.tilt_damping": "against the rate of the slope",
    "SpeedTable.speed": WITHIN,
    "SpeedTable.stiffness": "as many as speeds, linear in between",
    "SpeedTable.damping": "as many as speeds, linear in between",
    "Station.name": "given once; balancers, unbalances, forces and results refer to it",
    "Station.position": "along the axis, from the mass center of a rigid rotor, the left end of a shaft, the origin of a rig",
    "Station.body": "name of a body of a rig or of a disk on a shaft, if the position alone is ambiguous",
    **{f"{kind}.{key}": text for kind, keys in EXCITATIONS.items() for key, text in keys.items()},
}
