"""Rotors made of a measured receptance: they are those that were measured, and a design for them is that for the true one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.errors import AutobalancerError, MachineError, QuestionError
from autobalancer.machine import Machine, ModalRotor, PlanarRotor, Resonance
from autobalancer.measurement.loop import balls_of
from autobalancer.reporting.report import design_pages
from autobalancer.reporting.report_pages import Drawing, Paragraph
from autobalancer.rotordynamics.receptances import receptance_dataset
from autobalancer.stability.maps.exact import borders
from autobalancer.studies.design.design_file import read_spec

TWO = ModalRotor(
    resonances=(
        Resonance(mass="12 kg", frequency="9.6 Hz", damping_ratio="4.6 %"),
        Resonance(mass="30 kg", frequency="25.2 Hz", damping_ratio="3 %"),
    )
)
FREQUENCIES = 2.0 * np.pi * np.linspace(2.0, 60.0, 300)
SPEC: dict[str, Any] = {
    "machine": ab.example("discoidal"),
    "rotor": {"receptance": ab.catalog.example_path("discoidal_hammer")},
    "operation": {"speed": "1200 rpm", "run_up": "40 s", "hold": "15 s"},
    "unbalance": "594 g*mm",
    "limits": {"peak_deflection": "1.5 mm", "share": 0.8},
    "candidates": {"count": [2], "fluids": ["silicone oil 5", "silicone oil 20", "silicone oil 50"]},
    "search": {"members": 20},
}


def exact_border(machine: Machine) -> float:
    return next(one.speed for one in borders(machine, only=("exact border",)))


def hammered(rotor: ModalRotor, mass: float = 0.0) -> Any:
    """The receptance of a rotor without noise, with a mass fixed to it."""
    model = lateral_model(ab.example("discoidal").model_copy(update={"rotor": rotor}))
    at = [model.receptance(1j * w, 0.0, np.ones((1, len(rotor.resonances))))[0, 0] for w in FREQUENCIES]
    return receptance_dataset(
        FREQUENCIES, 1.0 / (1.0 / np.array(at) - mass * FREQUENCIES**2), "receptance", title="two"
    )


def test_a_rotor_of_one_resonance_moves_like_the_planar_rotor() -> None:
    planar = ab.example("discoidal")
    assert isinstance(planar.rotor, PlanarRotor)
    mass, (k, _), (b, _) = float(planar.rotor.mass), planar.rotor.stiffness_xy, planar.rotor.damping_xy
    one = Resonance(mass=mass, frequency=(k / mass) ** 0.5, damping_ratio=0.5 * b / (k * mass) ** 0.5)
    modal = planar.model_copy(update={"rotor": ModalRotor(resonances=(one,))})
    assert exact_border(modal) == pytest.approx(exact_border(planar), rel=1e-9)
    runs = [ab.simulate(machine, duration=40.0) for machine in (planar, modal)]
    first, second = (ab.run_measures(run)["peak_deflection"].values for run in runs)
    assert second == pytest.approx(first, rel=1e-6)


def test_two_resonances_are_found_again_and_their_border_is_that_of_the_receptance() -> None:
    fit = ab.measure.receptance(hammered(TWO))
    rotor = ab.measure.receptance_rotor(fit)
    assert isinstance(rotor, ModalRotor)
    for found, true in zip(rotor.resonances, TWO.resonances, strict=True):
        for name in ("mass", "frequency", "damping_ratio"):
            assert getattr(found, name) == pytest.approx(getattr(true, name), rel=1e-6)
    machine = ab.example("discoidal").model_copy(update={"rotor": rotor})
    known = ab.measure.receptance_border(
        fit, balls_of(machine), balls_on_rotor=False, unbalance=594e-6, searched=(150.0, 200.0)
    )
    assert exact_border(machine) == pytest.approx(known.attrs["exact_border"], rel=1e-6)


def test_a_mass_that_was_fixed_to_the_rotor_in_the_test_is_taken_off(tmp_path: Path) -> None:
    heavy, path = hammered(TWO, 0.4), tmp_path / "heavy.csv"
    rows = zip(FREQUENCIES, heavy["receptance_real"].values, heavy["receptance_imag"].values, strict=True)
    lines = ["frequency [rad/s], real [m/N], imag [m/N]", *(f"{w:.15g}, {x:.15g}, {y:.15g}" for w, x, y in rows)]
    path.write_text("\n".join(lines))
    rotor = ab.measure.receptance_rotor(ab.measure.receptance(ab.measure.load_receptance(path, mass_added="400 g")))
    assert rotor.mass == pytest.approx(TWO.mass, rel=1e-6)


def test_the_design_for_a_measured_rotor_is_that_for_the_true_one_and_its_report_shows_both() -> None:
    found = ab.design(SPEC)
    true = ab.design({key: value for key, value in SPEC.items() if key != "rotor"})
    assert [str(one) for one in found.best()["label"].values] == [str(one) for one in true.best()["label"].values]
    np.testing.assert_allclose(found.best()["peak_deflection"], true.best()["peak_deflection"], rtol=0.02)
    machine = ab.designed_machine(found)
    assert "discoidal_hammer.csv" in machine.description
    page = next(one for one in design_pages(found, machine, "found.nc") if one.title == "Measured rotor")
    assert any(isinstance(block, Drawing) for block in page.blocks)
    said = " ".join(block.text for block in page.blocks if isinstance(block, Paragraph))
    assert "known from 180 to 2400 rpm" in said


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        (
            {"operation": {"speed": "3000 rpm", "run_up": "60 s", "hold": "20 s"}},
            r"operation\.speed: contradicts rotor\.receptance",
        ),
        ({"rotor": {**SPEC["rotor"], "band": "12 Hz:40 Hz"}}, r"lowest mode, at 9\.\d+ Hz, lies below"),
        ({"rotor": {"receptance": "no_such.csv"}}, "no_such.csv: cannot be read"),
        ({"rotor": {**SPEC["rotor"], "band": "41 Hz:50 Hz"}}, "too few for a fit"),
        ({"rotor": {"file": "hammer.csv"}}, r"rotor\.file"),
        ({"rotor": {}}, r"rotor\.receptance"),
        ({"machine": ab.example("two_plane_rotor")}, "known in one plane"),
    ],
)
def test_what_was_not_measured_is_refused(tables: dict[str, Any], words: str) -> None:
    with pytest.raises(AutobalancerError, match=words):
        read_spec({**SPEC, **tables})


def test_a_rotor_known_by_its_modes_is_refused_where_more_must_be_known() -> None:
    machine = ab.example("discoidal").model_copy(update={"rotor": TWO})
    with pytest.raises(MachineError, match="its weight"):
        ab.with_parameter(machine, "axis", "horizontal")
    fit = ab.measure.receptance(hammered(TWO))
    with pytest.raises(QuestionError, match="no positive mass"):
        ab.measure.receptance_rotor(fit.assign(mode_mass=-fit["mode_mass"]))
