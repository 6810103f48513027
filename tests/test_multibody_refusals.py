"""Rigs that cannot be: refused with the place and the bodies named."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import pytest
import tomli_w

from autobalancer.assembly.rotors import lateral_model, rows_at
from autobalancer.errors import MachineError, MachineFileError
from autobalancer.files.examples import example_text
from autobalancer.files.machine_file import parse_machine

DISCOIDAL = tomllib.loads(example_text("discoidal_rig"))
BUSHING = 5
LOCK = {"kind": "lock", "between": ["lid", "winding"]}


def rig(**more: Any) -> dict[str, Any]:
    """A copy of the discoidal rig; ``more`` goes into its rotor."""
    data = copy.deepcopy(DISCOIDAL)
    data["rotor"].update(more)
    return data


def with_joint(number: int, **more: Any) -> dict[str, Any]:
    data = rig()
    data["rotor"]["joints"][number].update(more)
    return data


def with_body(number: int, **more: Any) -> dict[str, Any]:
    data = rig()
    data["rotor"]["bodies"][number].update(more)
    return data


def plus(kind: str, entry: dict[str, Any], *gone: int) -> dict[str, Any]:
    """With one more body or joint, and without some joints."""
    data = rig()
    data["rotor"]["joints"] = [joint for i, joint in enumerate(data["rotor"]["joints"]) if i not in gone]
    data["rotor"][kind].append(entry)
    return data


def point(*between: str, **more: Any) -> dict[str, Any]:
    return {"kind": "spring", "between": list(between), "position": 0.0, "stiffness": 1e4, **more}


BODY = {"name": "box", "mass": 1.0, "position": 0.1, "transverse_inertia": 0.01, "polar_inertia": 0.01}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (with_joint(4, stiffness="-1 N/m"), "rotor.joints[5].stiffness: given '-1 N/m'; must be greater than zero"),
        (with_joint(BUSHING, axial_stiffness=-1.0), "rotor.joints[6].axial_stiffness: given -1.0; must not be negative"),
        (with_joint(BUSHING, kind="glue"), "rotor.joints[6].kind: given 'glue'; must be one of"),
        (with_joint(BUSHING, between=["base", "floor"]), "rotor.joints[6].between: no body is named 'floor'; there is 'disc'"),
        (with_joint(BUSHING, between=["base", "base"]), "rotor.joints[6]: between: given 'base' twice"),
        (with_joint(BUSHING, between=["disc", "ground"]), "rotor.joints[6].between: a bushing connects non-rotating bodies"),
        (with_joint(BUSHING, radius=0.0), "rotor.joints[6]: radius: missing; 3 bushings sit on a circle"),
        (with_joint(BUSHING, direction=[0, 0, 0]), "rotor.joints[6]: direction: given 0, 0, 0"),
        (with_joint(4, between=["disc", "shaft"]), "rotor.joints[5].between: a bearing connects a rotating body"),
        (with_joint(0, between=["disc", "ground"]), "rotor.joints[1].between: a body cannot be locked to the 'ground'"),
        (plus("joints", LOCK), "rotor.joints[7]: 'lid' and 'winding' are locked to each other"),
        (plus("joints", {**LOCK, "between": ["lid", "base"]}), "rotor.joints[7]: 'lid' and 'base' are locked to each other"),
        (plus("joints", point("lid", "base")), "rotor.joints[7]: 'lid' and 'base' are locked to each other; it has no effect"),
        (plus("joints", point("disc", "ground", offset=[0.1, 0.0])), "rotor.joints[7].offset: a joint on a rotating body"),
        (plus("joints", point("disc", "base", torsional_stiffness=1.0)), "rotor.joints[7].torsional_stiffness: a body"),
        (plus("joints", point("disc", "shaft", damping=1.0), 0), "rotor.joints[6].damping: damping between two rotating"),
        (plus("joints", point("disc", "shaft", stiffness=[1e4, 2e4]), 0), "rotor.joints[6].stiffness: between two rotating"),
        (with_body(1, name="disc"), "rotor.bodies[2].name: 'disc' is given twice"),
        (with_body(1, name="ground"), "rotor.bodies[2]: name: given 'ground'; give a non-empty name other than"),
        (with_body(1, mass=0.0), "rotor.bodies[2].mass: given 0.0; must be greater than zero"),
        (with_body(1, polar_inertia=0.1), "rotor.bodies[2]: inertia: given 0.002, 0.002 and 0.1 kg m^2"),
        (with_body(1, offset=[0.01, 0.0]), "rotor.bodies[2]: rotating: a rotating body needs"),
        (with_body(1, inertia=[1, 1, 1]), "rotor.bodies[2]: give either 'transverse_inertia' and 'polar_inertia'"),
        (rig(modes=0), "rotor.modes: given 0"),
    ],
)  # fmt: skip
def test_an_impossible_rig_is_refused_where_it_is_wrong(data: dict[str, Any], words: str) -> None:
    with pytest.raises(MachineFileError) as caught:
        parse_machine(tomli_w.dumps(data), "rig.toml")
    assert words in str(caught.value)


def test_a_rig_in_which_nothing_turns_is_refused() -> None:
    data = rig()
    for part in data["rotor"]["bodies"]:
        part.pop("rotating", None)
    data["rotor"]["joints"] = data["rotor"]["joints"][1:3] + data["rotor"]["joints"][5:]
    with pytest.raises(MachineFileError, match="none of them rotates"):
        parse_machine(tomli_w.dumps(data))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (plus("joints", point("disc", "base"), BUSHING),
         "'disc + shaft' and 'lid + winding + base' can "),
        (plus("bodies", BODY), "'box' can "),
        (plus("joints", point("disc", "base", axial_stiffness=1e4), 3, 4), "'disc + shaft' can tilt towards"),
        (plus("joints", {"kind": "dashpot", "between": ["base", "ground"], "position": 0.0, "damping": 9.0}, BUSHING),
         "'disc + shaft' and 'lid + winding + base' can "),
        (with_joint(BUSHING, count=2), "'disc + shaft' and 'lid + winding + base' can tilt towards"),
    ],
)  # fmt: skip
def test_bodies_that_nothing_holds_are_named_with_their_free_motion(data: dict[str, Any], words: str) -> None:
    with pytest.raises(MachineError) as caught:
        lateral_model(parse_machine(tomli_w.dumps(data)))
    assert f"rotor.joints: {words}" in str(caught.value)


def test_how_stiff_a_joint_is_does_not_make_another_body_free() -> None:
    data = with_joint(3, stiffness=1e16, axial_stiffness=1e16)
    assert lateral_model(parse_machine(tomli_w.dumps(data))).pairs == 4


def test_a_point_mass_that_is_not_locked_has_a_singular_mass_matrix() -> None:
    speck = {**BODY, "transverse_inertia": 0.0, "polar_inertia": 0.0}
    data = plus("bodies", speck)
    data["rotor"]["joints"].append(
        point("box", "ground", axial_stiffness=1e4, tilt_stiffness=1.0, torsional_stiffness=1.0)
    )
    with pytest.raises(MachineError, match=r"rotor.bodies\[6\].inertia: 'box' has no inertia about some axis"):
        lateral_model(parse_machine(tomli_w.dumps(data)))


def test_a_rig_too_soft_for_its_weight_falls_over() -> None:
    data = rig(up="+z")
    data["rotor"]["joints"][BUSHING]["axial_stiffness"] = 100.0
    with pytest.raises(MachineError, match=r"rotor.up: the bodies fall over under their weight"):
        lateral_model(parse_machine(tomli_w.dumps(data)))
    data["rotor"]["up"] = "-z"
    assert lateral_model(parse_machine(tomli_w.dumps(data))).isotropic
    data["axis"] = "horizontal"
    with pytest.raises(MachineError, match=r"rotor.up: on a horizontal axis the weight does not change the stiffness"):
        lateral_model(parse_machine(tomli_w.dumps(data)))


def test_a_place_on_an_unknown_or_an_unnamed_body_is_refused() -> None:
    machine = parse_machine(tomli_w.dumps(rig()))
    model = lateral_model(machine)
    assert rows_at(machine, model, 0.14).deflection == pytest.approx(rows_at(machine, model, "race").deflection)
    data = rig()
    data["stations"][0]["body"] = "plate"
    with pytest.raises(MachineError, match=r"stations\[1\]: no body is named 'plate'; there is 'disc', 'shaft', 'lid'"):
        rows_at(parse_machine(tomli_w.dumps(data)), model, "race")
    clutch = point("disc", "shaft", axial_stiffness=1e6, tilt_stiffness=1e3)
    two = parse_machine(tomli_w.dumps(plus("joints", clutch, 0)))
    with pytest.raises(
        MachineError, match=r"several bodies rotate, 'disc', 'shaft'; choose one by a station with 'body'"
    ):
        rows_at(two, lateral_model(two), 0.14, "unbalances", 0, "station")
