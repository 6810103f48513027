"""What a shaft may be, and what is refused with its place named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tests.references.shafts import STEEL, machine, model_of, part, shaft

from autobalancer.files.machine_file import load_race_machine, save_machine

PINS = [{"position": 0.0, "stiffness": 1e6}, {"position": 1.0, "stiffness": 1e6}]
DISK = {"position": 0.5, "mass": 1.0, "transverse_inertia": 0.01, "polar_inertia": 0.02}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"disks": [{**DISK, "position": 1.2}]},
            r"rotor.disks\[1\].position: given 1.2 m; the shaft reaches from 0 to 1 m",
        ),
        ({"disks": [{**DISK, "polar_inertia": 0.03}]}, r"rotor.disks\[1\]: polar_inertia: given 0.03 kg m\^2; no body"),
        ({"disks": [{**DISK, "extent": [0.2, 0.1]}]}, r"rotor.disks\[1\]: extent: given 0.2 m to 0.1 m"),
        ({"disks": [{**DISK, "name": "a"}, {**DISK, "name": "a"}]}, r"rotor.disks\[2\].name: 'a' is given twice"),
        ({"supports": [PINS[0], {**PINS[1], "position": -0.1}]}, r"rotor.supports\[2\].position: given -0.1 m"),
        ({"supports": PINS[:1]}, "rotor.supports: the shaft is not supported; give springs at two positions"),
        ({"supports": [{"position": 0.0, "damping": 3.0}]}, "rotor.supports: the shaft is not supported"),
        ({"material": None}, r"rotor.segments\[1\].material: missing; give it here, or one for all segments"),
        (
            {"material": {**STEEL, "poisson_ratio": 0.6}},
            "rotor.material.poisson_ratio: given 0.6; must be between 0 and 0.5",
        ),
        ({"material": {**STEEL, "shear_modulus": 8e10}}, "give either 'shear_modulus' or 'poisson_ratio'"),
        ({"material": {**STEEL, "youngs_modulus": "-2 GPa"}}, "rotor.material.youngs_modulus: given '-2 GPa'; must be"),
        ({"up": "-z"}, "rotor.thrust_bearing: missing; weight requires it in addition to 'up', or leave both out"),
        ({"thrust_bearing": 0.2}, "rotor.up: missing; weight requires it in addition to 'thrust_bearing'"),
        ({"up": "-z", "thrust_bearing": 2.0}, "rotor.thrust_bearing: given 2 m; the shaft reaches from 0 to 1 m"),
        ({"inner_diameter": 0.05}, "inner_diameter: given 0.05 m; must be smaller than the diameter, 0.05 m"),
        ({"elements": 0}, r"rotor.segments\[1\].elements: given 0"),
        ({"modes": 0}, "rotor.modes: given 0"),
    ],
)
def test_an_impossible_shaft_is_refused_with_its_place(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        machine(shaft(**{"supports": PINS, **change}))


def test_a_shear_modulus_and_its_poisson_ratio_make_the_same_shaft() -> None:
    same = {"density": 7850.0, "youngs_modulus": 2.1e11, "shear_modulus": 2.1e11 / 2.6}
    one, other = model_of(shaft(supports=PINS)), model_of(shaft(supports=PINS, material=same))
    assert one.stiffness == pytest.approx(other.stiffness, rel=1e-12)


def test_a_segment_may_have_its_own_material() -> None:
    light = {**STEEL, "density": 2700.0}
    rotor = shaft(supports=PINS)
    rotor["segments"] = [{"length": 0.5, "diameter": 0.05}, {"length": 0.5, "diameter": 0.05, "material": light}]
    volume = part(rotor).segments[0].volume
    assert part(rotor).mass == pytest.approx(volume * (7850.0 + 2700.0), rel=1e-12)


def test_a_shaft_survives_its_machine_file(tmp_path: Path) -> None:
    rotor = shaft(
        length="1 m", diameter="50 mm", supports=PINS, disks=[{**DISK, "name": "drum", "extent": ["-10 mm", "20 mm"]}],
        up="-z", thrust_bearing="0.2 m", modes=3,
    )  # fmt: skip
    rotor["material"] = {"density": "7.85 g/cm^3", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
    given = machine(rotor)
    again = load_race_machine(save_machine(given, tmp_path / "shaft.toml"))
    assert again == given
    assert "210 GPa" in (tmp_path / "shaft.toml").read_text(encoding="utf-8")


def test_the_middle_of_a_shaft_is_its_only_disk_and_unclear_with_two() -> None:
    two = model_of(shaft(supports=PINS, disks=[DISK, {**DISK, "position": 0.7}]))
    with pytest.raises(ValueError, match="the shaft carries 2 disks, so say where"):
        two.axis.rows(None, None)
    bare = model_of(shaft(supports=PINS))
    assert bare.axis.rows(None, None).deflection == pytest.approx(bare.axis.rows(0.5, None).deflection)
