"""What the keys of a rig of rigid bodies mean."""

PLACE = {"between": "names of two bodies, or of one and `ground`", "position": "along the axis"}
BESIDE = "along x and y, beside the axis; only if no body of the joint rotates"
TABLE = "over the speed, in place of the two constants"
ABOUT = {
    "tilt_stiffness": "against tilting",
    "tilt_damping": "against tilting",
    "torsional_stiffness": "against rotation about the axis",
    "torsional_damping": "against rotation about the axis",
}
ALONG = {"axial_stiffness": "along the axis", "axial_damping": "along the axis"}
ACROSS = {"stiffness": "across the axis", "damping": "across the axis"}
DAMPED = {key: text for key, text in (ACROSS | ALONG | ABOUT).items() if "damping" in key}

JOINTS = {
    "Lock": {"between": PLACE["between"]},
    "Dashpot": PLACE | DAMPED | {"offset": BESIDE},
    "Spring": PLACE | ACROSS | ALONG | ABOUT | {"offset": BESIDE, "table": TABLE, "axial_table": TABLE},
    "BallBearing": PLACE | ACROSS | ALONG,
    "Bushing": PLACE
    | {
        "radius": "of the circle on which the bushings sit",
        "count": "equally spaced",
        "angle": "of the first, from the x axis",
        "direction": "of the axis of a bushing: outwards, in the sense of rotation, along the axis of the rotor",
        "shear_stiffness": "of each, across its axis",
        "shear_damping": "of each, across its axis",
        "shear_table": TABLE,
        "axial_stiffness": "of each, along its axis",
        "axial_damping": "of each, along its axis",
        "axial_table": TABLE,
        "bending_stiffness": "of each, about axes across its own",
        "bending_damping": "of each, about axes across its own",
        "torsional_stiffness": "of each, about its axis",
        "torsional_damping": "of each, about its axis",
    },
}

RIG_MEANINGS = {
    "MultibodyRotor.bodies": "rotating and non-rotating",
    "MultibodyRotor.joints": "between bodies, and to the ground",
    "MultibodyRotor.modes": "pairs of modes that a simulation in time keeps; all without it",
    "MultibodyRotor.up": "on a vertical axis; without it weight has no effect",
    "Body.name": "any except `ground`",
    "Body.mass": "with all attached parts, without balls",
    "Body.position": "of the mass center along the axis, from an origin of your choice",
    "Body.offset": "of the mass center beside the axis, along x and y",
    "Body.transverse_inertia": "about x and y, through the mass center",
    "Body.polar_inertia": "about z, through the mass center",
    "Body.inertia": "about x, y and z, in place of these two",
    "Body.rotating": "whether it rotates with the rotor",
    **{f"{kind}.{key}": text for kind, keys in JOINTS.items() for key, text in keys.items()},
}
