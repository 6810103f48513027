"""The shaft against ROSS, where it is installed, and what is said where it is not."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigvals
from tests.references.shafts import machine

from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.errors import MachineError, QuestionError
from autobalancer.rotordynamics import equivalent_planar as module
from autobalancer.rotordynamics.equivalent_planar import from_ross
from autobalancer.units import to_si

SPEEDS = [0.0, 200.0, 500.0, 900.0]


@pytest.fixture(scope="module")
def ross() -> Any:
    return pytest.importorskip(
        "ross",
        reason="needs ROSS, which `make test` leaves out for its size: pip install .[ross]",
        exc_type=ImportError,
    )


def rotor(ross: Any, bearings: list[Any] | None = None, **element: Any) -> Any:
    """Stepped and hollow, with two disks, on anisotropic bearings."""
    steel = ross.Material(name="steel", rho=7810.0, E=211e9, G_s=81.2e9)
    sizes = [(0.25, 0.0, 0.05), (0.1, 0.01, 0.05), (0.3, 0.02, 0.07), (0.2, 0.0, 0.06), (0.25, 0.0, 0.04)]
    shaft = [ross.ShaftElement(length, i, o, material=steel, **element) for length, i, o in sizes]
    disks = [ross.DiskElement(n=2, m=32.6, Id=0.178, Ip=0.33), ross.DiskElement(n=5, m=12.0, Id=0.1, Ip=0.19)]
    if bearings is None:
        tables = {"kxx": [9e6, 1.1e7, 1.2e7, 2e7], "kyy": [1e7, 1e7, 1.1e7, 1.1e7], "cxx": [9.0, 8.0, 7.0, 6.0]}
        tables |= {"cyy": [5.0] * 4, "frequency": SPEEDS}
        bearings = [
            ross.BearingElement(n=0, kxx=1e7, kyy=2e7, cxx=600.0, cyy=300.0, kxy=1e5, kyx=-2e5),
            ross.BearingElement(n=4, **tables),
        ]
    return ross.Rotor(shaft, disks, bearings)


def model_of(given: Any) -> LateralModel:
    return lateral_model(machine(from_ross(given), "horizontal"))


def lateral(given: Any, matrix: np.ndarray) -> np.ndarray:
    """A matrix of ROSS over (x, y, z, alpha, beta, theta) at each node in our order, where slopes are beta and -alpha."""
    nodes = len(given.nodes)
    pick = [6 * i + c for coordinates in ((0, 4), (1, 3)) for i in range(nodes) for c in coordinates]
    sign = np.array([-1.0 if p % 6 == 3 else 1.0 for p in pick])
    return sign[:, None] * matrix[np.ix_(pick, pick)] * sign


def test_the_matrices_are_those_of_ross(ross: Any) -> None:
    given = rotor(ross)
    model = model_of(given)
    pairs = [(model.mass, given.M()), (model.gyroscopic, given.G())]
    for speed in SPEEDS:
        pairs += [(model.damping_at(speed), given.C(speed)), (model.stiffness_at(speed), given.K(speed))]
    for ours, theirs in pairs:
        theirs = lateral(given, theirs)
        scale = np.sqrt(np.abs(np.outer(np.diag(theirs), np.diag(theirs)))) + 1e-12 * np.abs(theirs).max()
        assert np.abs(ours).max() > 0.0
        assert np.abs(ours - theirs).max() < 1e-11 * np.abs(theirs).max()
        if np.diag(theirs).any():
            assert (np.abs(ours - theirs) / scale).max() < 1e-7


def first_order(model: LateralModel, speed: float) -> np.ndarray:
    size = model.size
    zero, one = np.zeros((size, size)), np.eye(size)
    turning = model.damping_at(speed) + speed * model.gyroscopic
    return eigvals(
        np.block([[zero, one], [-model.stiffness_at(speed), -turning]]), np.block([[one, zero], [zero, model.mass]])
    )


@pytest.mark.parametrize("speed", SPEEDS)
def test_eigenvalues_over_the_speed_are_those_of_ross(ross: Any, speed: float) -> None:
    given = rotor(ross)
    found = first_order(model_of(given), speed)
    modes = given.run_modal(speed)
    theirs = modes.evalues[np.abs(modes.evalues.imag) > 1.0]
    bending = [value for value in theirs if np.abs(found - value).min() < 0.02 * abs(value)]
    assert len(bending) >= 12
    assert max(np.abs(found - value).min() / abs(value) for value in bending) < 1e-8


def test_the_unbalance_response_is_that_of_ross(ross: Any) -> None:
    given = rotor(ross)
    model = model_of(given)
    theirs = given.run_unbalance_response(2, 3e-4, 0.4, frequency=SPEEDS[1:]).forced_resp
    rows = model.axis.rows(0.35, None).deflection
    for i, speed in enumerate(SPEEDS[1:]):
        force = np.zeros(model.size, complex)
        force[: model.pairs], force[model.pairs :] = rows, -1j * rows
        force *= 3e-4 * speed**2 * np.exp(0.4j)
        turning = model.damping_at(speed) + speed * model.gyroscopic
        motion = np.linalg.solve(model.stiffness_at(speed) + 1j * speed * turning - speed**2 * model.mass, force)
        nodes = 6 * np.arange(len(given.nodes))
        assert motion[: model.pairs : 2] == pytest.approx(theirs[nodes, i], rel=1e-7)
        assert motion[model.pairs :: 2] == pytest.approx(theirs[nodes + 1, i], rel=1e-7)


def test_a_rotor_saved_by_ross_is_read_from_its_file(ross: Any, tmp_path: Path) -> None:
    given = rotor(ross, [ross.BearingElement(n=n, kxx=1e7, cxx=10.0) for n in (0, 5)])
    given.save(tmp_path / "rotor.toml")
    assert from_ross(tmp_path / "rotor.toml") == from_ross(given)


def test_units_are_read_as_before_after_ross_was_imported(ross: Any) -> None:
    assert to_si("1200 rpm", "rad/s") == pytest.approx(40.0 * np.pi, rel=1e-14)
    assert to_si("10 Hz", "rad/s") == pytest.approx(20.0 * np.pi, rel=1e-14)


@pytest.mark.parametrize(
    ("bearing", "element", "message"),
    [
        ({"cxy": 3.0}, {}, "BearingElement .* at node 0: cxy is not 0"),
        ({"mxx": 2.0}, {}, "BearingElement .* at node 0: mxx is not 0"),
        (
            {"kxy": [1.0, 2.0], "kxx": [1e6, 1e6], "cxx": [1.0, 1.0], "frequency": [0.0, 9.0]},
            {},
            "node 0: kxy depends on",
        ),
        ({}, {"shear_effects": False}, "ShaftElement .* at node 0: shear_effects = False cannot be read"),
        ({}, {"axial_force": 5.0}, "ShaftElement .* at node 0: axial_force = 5.0 cannot be read"),
        ({}, {"beta": 1e-6}, "ShaftElement .* at node 0: beta = 1e-06 cannot be read"),
        ({}, {"odr": 0.2}, "ShaftElement .* at node 0: cones cannot be read"),
    ],
)
def test_what_a_shaft_cannot_have_is_refused_by_name(ross: Any, bearing: Any, element: Any, message: str) -> None:
    first = ross.BearingElement(**{"n": 0, "kxx": 1e7, "cxx": 10.0, **bearing})
    if "odr" in element:
        element = {"idr": 0.0, **element}
    given = rotor(ross, [first, ross.BearingElement(n=5, kxx=1e7, cxx=10.0)], **element)
    with pytest.raises(MachineError, match=message):
        from_ross(given)


def test_what_version_three_of_ross_names_otherwise_is_read_or_refused(ross: Any) -> None:
    """Its tables are over ``speed``, and its rotors may have damping of the whole."""
    given, expected = rotor(ross), from_ross(rotor(ross))
    given.bearing_elements[1].speed, given.bearing_elements[1].frequency = SPEEDS, None
    assert from_ross(given) == expected
    given.bearing_elements[1].frequency = SPEEDS
    with pytest.raises(MachineError, match="a table over speed and frequency cannot be read"):
        from_ross(given)
    given = rotor(ross)
    given.alpha = 0.1
    with pytest.raises(MachineError, match=r"alpha = 0\.1 of the rotor cannot be read"):
        from_ross(given)


def test_something_else_than_a_rotor_of_ross_is_refused() -> None:
    with pytest.raises(QuestionError, match=r"given types\.SimpleNamespace; must be a ross\.Rotor, or its file"):
        from_ross(SimpleNamespace())


def test_a_missing_or_unknown_ross_is_said_clearly(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(module, "version", missing)
    with pytest.raises(
        QuestionError, match=r"ROSS is not installed; install it with: pip install 'autobalancer\[ross\]'"
    ):
        from_ross("rotor.toml")
    monkeypatch.setattr(module, "version", lambda name: "1.4.0")
    with pytest.raises(
        QuestionError, match=r"ROSS 1\.4\.0 is installed, but its rotors are known from versions 2\.3 and 3 only"
    ):
        from_ross("rotor.toml")


def test_a_ross_that_does_not_import_is_said_clearly(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(name: str) -> Any:
        raise ValueError("Invalid property 'scattermapbox'\nand more")

    monkeypatch.setattr(module, "version", lambda name: "2.3.0")
    monkeypatch.setattr(module, "import_module", broken)
    with pytest.raises(QuestionError, match=r"ROSS cannot be imported: Invalid property 'scattermapbox'; its 2\.3"):
        from_ross("rotor.toml")
