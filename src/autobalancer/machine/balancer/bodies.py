"""Which keys fit which body of a race: balls, rollers, pendulums."""

from __future__ import annotations

from typing import Any

ROLLER = "a roller needs its 'diameter', and 'mass' or two of 'mass', 'length' and 'density' (or 'material')"
PENDULUM = (
    "a pendulum needs its 'mass' and 'inertia', the moment of inertia about its own center of mass (0 for a point mass)"
)
ONLY = {
    "motion": ("ball",),
    "density": ("ball", "roller"),
    "material": ("ball", "roller"),
    "length": ("roller",),
    "inner_diameter": ("roller",),
    "inertia": ("pendulum",),
    "bearing_radius": ("pendulum",),
}
"""The bodies to which a key of a group belongs; keys that are not here belong to all."""


def refuse_keys(group: Any) -> None:
    """Refuse keys of another body.

    Raises
    ------
    ValueError
        With the key, what it is for, and what to do.
    """
    for name, bodies in ONLY.items():
        if name in group.model_fields_set and getattr(group, name) is not None and group.body not in bodies:
            owners = " and ".join(f"{body}s" for body in bodies)
            raise ValueError(
                f"{name}: a key of {owners}, but this is a group of {group.body}s; leave it out, or change 'body'"
            )


def check_roller(group: Any) -> None:
    """Refuse a roller whose size or mass is not determined, or is so twice."""
    stuff = group.density is not None or group.material is not None
    given = (group.mass is not None) + (group.length is not None) + stuff
    if group.diameter is None or (given < 2 and group.mass is None):
        raise ValueError(ROLLER)
    if given == 3:
        raise ValueError("mass, length and density (or material) are all given; leave one out")
    if group.inner_diameter is not None and group.inner_diameter >= group.diameter:
        raise ValueError(
            f"inner_diameter: given {1e3 * group.inner_diameter:.4g} mm; must be smaller than the diameter, "
            f"{1e3 * group.diameter:.4g} mm"
        )


def check_pendulum(group: Any) -> None:
    """Refuse a pendulum without mass or inertia."""
    if group.mass is None or group.inertia is None:
        raise ValueError(PENDULUM)


def refuse_bodies(race: Any) -> None:
    """Refuse rollers and pendulums in a race that does not fit them.

    Raises
    ------
    ValueError
        With the key, the reason, and what to do.
    """
    bodies = {group.body for group in race.balls}
    if bodies == {"ball"}:
        return
    others = " and ".join(f"{body}s" for body in ("roller", "pendulum") if body in bodies)
    if race.drag.law != "beta":
        raise ValueError(
            f"drag: the law {race.drag.law!r} is that of spheres; for {others} give the drag torque itself, with the law 'beta'"
        )
    if race.slipstream:
        raise ValueError(f"slipstream: known of balls only, and this race has {others}; leave it out")
    if race.bearing is not None:
        raise ValueError(f"bearing: its groove is made for balls, and this race has {others}; give 'orbit_radius'")
    if "roller" in bodies:
        _refuse_rollers(race)
    if "pendulum" in bodies:
        if len(bodies) > 1:
            raise ValueError("balls: pendulums share no race with others; give them a race of their own")
        _refuse_pendulums(race)


def _refuse_rollers(race: Any) -> None:
    if race.fluid is not None:
        if "virtual_mass" not in race.fluid.model_fields_set:
            raise ValueError("fluid.virtual_mass: missing; its default, 2, is that of balls, and this race has rollers")
        for group in race.balls:
            if group.body == "roller" and group.inner_diameter is not None:
                raise ValueError("fluid: how it moves with a hollow roller is not known; leave 'inner_diameter' out")
            if group.body == "roller" and group.length is None and group.density is None and group.material is None:
                raise ValueError("fluid: it carries part of a roller whose size is known; give its 'length'")
    if race.resolved is not None and race.resolved.reduced_modulus is not None:
        raise ValueError(
            "resolved.reduced_modulus: the contact of spheres (Hertz), and this race has rollers; give 'stiffness'"
        )


def _refuse_pendulums(race: Any) -> None:
    reasons = {
        "race_radius": "a pendulum runs on no wall; give 'orbit_radius', from the pivot to its center of mass",
        "resolved": "a pendulum is guided by its bearing; leave it out",
        "harmonics": "the path of a pendulum is a circle; leave it out",
        "roundness": "the path of a pendulum is a circle; leave it out",
        "fluid": "a pendulum does not know what it displaces; leave it out and give the drag by the law 'beta'",
    }
    for name, reason in reasons.items():
        if getattr(race, name):
            raise ValueError(f"{name}: {reason}")
    if race.friction is not None and any(group.bearing_radius is None for group in race.balls):
        raise ValueError("balls.bearing_radius: missing; the friction of a pendulum acts at the radius of its bearing")
    for group in race.balls:
        if None not in (group.bearing_radius, race.orbit_radius) and group.bearing_radius >= race.orbit_radius:
            raise ValueError(
                f"balls.bearing_radius: given {1e3 * group.bearing_radius:.4g} mm; must be smaller than the orbit radius, "
                f"{1e3 * race.orbit_radius:.4g} mm"
            )
