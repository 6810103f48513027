"""Rotors of ROSS (Timbó et al. 2020) as shaft rotors.

ROSS is imported only to read one of its files; a rotor that is handed over is read off its attributes.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Disk, ShaftMaterial, ShaftRotor, ShaftSegment, Support

Floats = NDArray[np.float64]

KNOWN = "2.3."  # how the versions begin whose attributes are read here
INSTALL = "install it with: pip install 'autobalancer[ross]'"


def from_ross(rotor: Any) -> ShaftRotor:
    """Convert a rotor of ROSS to a shaft rotor with the same nodes; axial and torsional parts are left out.

    Parameters
    ----------
    rotor
        A ``ross.Rotor``, or the path of a file that ``Rotor.save`` wrote.

    Returns
    -------
    ShaftRotor
        Nodes, element matrices and bearing coefficients are those of ROSS. Between the speeds of a table coefficients
        are interpolated linearly, and constant below the first; ROSS uses splines.

    Raises
    ------
    MachineError
        If the rotor has something that a shaft rotor cannot have: cones, layers, axial force or torque, elements without
        shear, rotary inertia or gyroscopic effect, damped elements, damping across (c_xy), stiffness across (k_xy) that
        depends on the speed, masses in bearings, supports between them and the ground. The message names it.
    QuestionError
        If ROSS is missing, cannot be imported, has an unknown version, or ``rotor`` is not one of its rotors.
    """
    if isinstance(rotor, (str, Path)):
        rotor = _ross().Rotor.load(rotor)
    kind = type(rotor)
    if kind.__name__ != "Rotor" or kind.__module__.split(".")[0] != "ross":
        raise QuestionError(f"from_ross: given {kind.__module__}.{kind.__name__}; must be a ross.Rotor, or its file")
    _check_version()
    segments = [_segment(element, number) for number, element in enumerate(rotor.shaft_elements)]
    places = np.concatenate([[0.0], np.cumsum([segment.length for segment in segments])])
    disks = [_disk(element, places) for element in (*rotor.disk_elements, *rotor.point_mass_elements)]
    supports = [_support(element, places) for element in rotor.bearing_elements]
    return ShaftRotor(segments=tuple(segments), disks=tuple(disks), supports=tuple(supports))


def _ross() -> Any:
    _check_version()
    try:
        return import_module("ross")
    except Exception as reason:  # what is wrong with its dependencies shows up as any kind of error
        raise QuestionError(
            f"from_ross: ROSS cannot be imported: {str(reason).strip().splitlines()[0]}; "
            f"its 2.3 needs plotly below 7; {INSTALL}"
        ) from reason


def _check_version() -> None:
    try:
        result = version("ross-rotordynamics")
    except PackageNotFoundError:
        raise QuestionError(f"from_ross: ROSS is not installed; {INSTALL}") from None
    if not result.startswith(KNOWN):
        raise QuestionError(
            f"from_ross: ROSS {result} is installed, but its rotors are known from version {KNOWN}x only"
        )


def _refuse(element: Any, what: str) -> None:
    tag = f" {element.tag!r}" if getattr(element, "tag", None) else ""
    raise MachineError(f"from_ross: {type(element).__name__}{tag} at node {element.n}: {what}")


def _segment(element: Any, number: int) -> ShaftSegment:
    if type(element).__name__ != "ShaftElement":
        _refuse(element, "only plain shaft elements can be read")
    if element.n_l != number:
        _refuse(element, "layers of elements between the same nodes cannot be read; give one section instead")
    if element.idl != element.idr or element.odl != element.odr:
        _refuse(element, "cones cannot be read; give cylinders in steps")
    for name in ("axial_force", "torque", "alpha", "beta"):
        if getattr(element, name):
            _refuse(element, f"{name} = {getattr(element, name)} cannot be read; set it to 0")
    for name in ("shear_effects", "rotary_inertia", "gyroscopic"):
        if not getattr(element, name):
            _refuse(element, f"{name} = False cannot be read; a Timoshenko element has it")
    stuff = element.material
    return ShaftSegment(
        length=float(element.L),
        diameter=float(element.odl),
        inner_diameter=float(element.idl),
        elements=1,
        shear_coefficient=float(element.kappa),
        material=ShaftMaterial(density=float(stuff.rho), youngs_modulus=float(stuff.E), shear_modulus=float(stuff.G_s)),
    )


def _place(element: Any, places: Floats) -> float:
    if not 0 <= element.n < len(places):
        _refuse(element, f"it is at none of the nodes of the shaft, which are 0 to {len(places) - 1}")
    return float(places[element.n])


def _disk(element: Any, places: Floats) -> Disk:
    if type(element).__name__ != "DiskElement":
        _refuse(element, "only plain disks can be read; a point mass is a disk without inertias")
    return Disk(
        position=_place(element, places),
        mass=float(element.m),
        transverse_inertia=float(element.Id),
        polar_inertia=float(element.Ip),
    )


def _support(element: Any, places: Floats) -> Support:
    if getattr(element, "n_link", None) is not None:
        _refuse(element, f"it is connected to node {element.n_link}, not on the ground, which cannot be read")
    for name in ("mxx", "myy", "mxy", "myx", "cxy", "cyx"):
        if np.any(np.asarray(getattr(element, name, 0.0), np.float64)):
            _refuse(element, f"{name} is not 0, which cannot be read")
    values = {name: np.asarray(getattr(element, name), np.float64).ravel() for name in ("kxx", "kyy", "cxx", "cyy")}
    support: dict[str, Any] = {"position": _place(element, places)}
    if max(entry.size for entry in values.values()) == 1:
        single = {name: float(entry[0]) for name, entry in values.items()}
        if single["kxx"] or single["kyy"]:
            support["stiffness"] = (single["kxx"], single["kyy"])
        support["damping"] = (single["cxx"], single["cyy"])
    else:
        speed = np.asarray(element.frequency, np.float64)
        columns = {name: np.broadcast_to(entry, speed.shape).tolist() for name, entry in values.items()}
        support["table"] = {
            "speed": speed.tolist(),
            "stiffness": list(zip(columns["kxx"], columns["kyy"], strict=True)),
            "damping": list(zip(columns["cxx"], columns["cyy"], strict=True)),
        }
    across = [np.asarray(getattr(element, name), np.float64).ravel() for name in ("kxy", "kyx")]
    for name, entry in zip(("kxy", "kyx"), across, strict=True):
        if np.ptp(entry) != 0.0:
            _refuse(element, f"{name} depends on the speed, which cannot be read")
    if any(entry[0] for entry in across):
        support["cross_stiffness"] = (float(across[0][0]), float(across[1][0]))
    return Support(**support)
