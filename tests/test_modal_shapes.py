"""A rotor by its modes with shapes at stations: the shaft that has these modes, a rigid rotor, and files of modes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from scipy.linalg import eigh

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.errors import MachineError, MachineFileError
from autobalancer.files.machine_file import machine_text, parse_race_machine
from autobalancer.machine import Machine
from autobalancer.rotordynamics.receptances import pole_model
from autobalancer.simulation.remarks import input_notes
from autobalancer.sketch import layout_of

REST = """
name = "light shaft with two discs"
axis = "vertical"
stations = [{ name = "disc", position = "100 mm" }, { name = "race", position = "300 mm" }]
unbalances = [{ moment = "300 g*mm", station = "disc" }]
drive = { kind = "speed", profile = { kind = "constant", speed = "250 rad/s" } }
run = { duration = "0.1 s" }

[[balancers]]
station = "race"

[[balancers.races]]
orbit_radius = "70 mm"
drag = { law = "viscous", damping = "1e-4 N*m*s" }
balls = [{ count = 2, mass = "4.4 g", diameter = "10.3 mm", start_angles = ["40 deg", "250 deg"] }]
"""
SPRINGS = [{"position": "0 mm", "stiffness": "200 N/mm"}, {"position": "250 mm", "stiffness": "300 N/mm"}]
SHAFT = {
    "kind": "shaft",
    "modes": 3,
    "stiffness_proportional_damping": "1e-4 s",
    "material": {"density": "1 kg/m^3", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    "segments": [{"length": "300 mm", "diameter": "20 mm", "elements": 3}],
    "disks": [
        {"position": p, "mass": m, "transverse_inertia": "0.004 kg*m^2", "polar_inertia": "0.006 kg*m^2"}
        for p, m in (("100 mm", "3 kg"), ("300 mm", "2 kg"))
    ],
    "supports": SPRINGS,
}


def machine_of(rotor: dict[str, Any], folder: Path = Path(), rest: str = REST) -> Machine:
    machine = ab.parse_machine(rest + tomli_w.dumps({"rotor": rotor}), folder=folder)
    assert isinstance(machine, Machine)
    return machine


SHAFT_MACHINE = machine_of(SHAFT)
MODEL = lateral_model(SHAFT_MACHINE)
PLACES = [0.0, 0.1, 0.25, 0.3]


def modes_of_shaft(count: int, stiffness: Any = None) -> tuple[Any, Any, Any]:
    """Frequencies, shapes and slopes (modes, places) of the shaft, normalised to its mass matrix."""
    n = MODEL.pairs
    rows = [MODEL.axis.rows(z, None) for z in PLACES]
    squares, modes = eigh(MODEL.stiffness[0, :n, :n] if stiffness is None else stiffness, MODEL.mass[:n, :n])
    shapes, slopes = (np.array([getattr(row, name) for row in rows]) @ modes for name in ("deflection", "slope"))
    return np.sqrt(np.maximum(squares[:count], 0.0)), shapes.T[:count], slopes.T[:count]


def modal_rotor(count: int) -> dict[str, Any]:
    frequencies, shapes, slopes = modes_of_shaft(count)
    return {
        "kind": "modal",
        "positions": PLACES,
        "polar_inertias": [0.0, 0.006, 0.0, 0.006],
        "total_mass": "5 kg",
        "resonances": [
            {"frequency": float(w), "damping_ratio": float(0.5e-4 * w), "shape": x.tolist(), "slope": s.tolist()}
            for w, x, s in zip(frequencies, shapes, slopes, strict=True)
        ],
    }


def test_the_modes_of_a_shaft_run_as_the_shaft_that_keeps_them() -> None:
    machine = machine_of(modal_rotor(3))
    assert lateral_model(machine).isotropic
    edges = [
        block.start for block in layout_of(machine).blocks
    ]  # a sketch shows its nodes, and how far the axis reaches
    assert edges[1:] == pytest.approx(PLACES)
    assert parse_race_machine(machine_text(machine)) == machine
    ours, theirs = (ab.simulate(m) for m in (machine, SHAFT_MACHINE))
    for name in ("ball_angle_in_rotor", "station_x", "plane_y"):
        size = float(abs(theirs[name]).max())
        assert float(abs(ours[name] - theirs[name]).max()) < 1e-5 * size, name  # the shaft has a mass of 0.1 mg


def test_all_modes_have_the_critical_speeds_of_the_shaft_and_few_those_they_reach() -> None:
    wanted = ab.rotor.critical_speeds(SHAFT_MACHINE)["critical_speed"].values[:2]
    for count, close in ((4, 1e-6), (3, 1e-2)):  # without the mass of the shaft there are four modes
        ours = ab.rotor.critical_speeds(machine_of(modal_rotor(count)))["critical_speed"].values[:2]
        assert ours == pytest.approx(wanted, rel=close)


def test_free_modes_on_supports_are_the_rigid_rotor_and_the_shaft_on_these() -> None:
    rigid = {"kind": "rigid", "mass": "5 kg", "transverse_inertia": 0.05, "polar_inertia": 0.03, "supports": SPRINGS}
    free = [
        {"frequency": 0, "damping_ratio": 0, "mass": m, "shape": x, "slope": s, "participation": p}
        for m, x, s, p in (("5 kg", [1, 1, 1, 1], [0] * 4, 1), ("0.05 kg", PLACES, [1] * 4, 0))
    ]
    polar = [0.03, 0.0, 0.0, 0.0]
    modal = {"kind": "modal", "positions": PLACES, "polar_inertias": polar, "supports": SPRINGS, "resonances": free}
    ours, theirs = machine_of(modal), machine_of(rigid)
    assert lateral_model(ours).total_mass == pytest.approx(5.0)
    speeds = [ab.rotor.critical_speeds(m)["critical_speed"].values for m in (ours, theirs)]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-9)
    runs = [ab.simulate(m, duration=0.05) for m in (ours, theirs)]
    for name in ("ball_angle_in_rotor", "station_x", "support_force_x"):
        assert float(abs(runs[0][name] - runs[1][name]).max()) < 1e-9 * float(abs(runs[1][name]).max()), name
    lying = REST.replace('"vertical"', '"horizontal"')  # participations say how the weight bends it
    sinks = [ab.simulate(machine_of(r, rest=lying), duration=0.05)["support_force_y"].values for r in (modal, rigid)]
    assert sinks[0] == pytest.approx(sinks[1], rel=1e-9, abs=1e-9)


def test_modes_that_differ_along_x_and_y_are_the_shaft_on_supports_that_do(tmp_path: Path) -> None:
    springs = [SPRINGS[0], {"position": "250 mm", "stiffness": ["300 N/mm", "500 N/mm"]}]
    shaft = machine_of({**SHAFT, "supports": springs, "modes": 8})
    n, model = MODEL.pairs, lateral_model(shaft)
    places = ["100 mm", "300 mm"]
    rows = np.array([model.axis.rows(z, None).deflection for z in (0.1, 0.3)])
    resonances = []
    for part, keys in ((slice(0, n), ("shape", "shape_y")), (slice(n, 2 * n), ("shape_y", "shape"))):
        squares, modes = eigh(model.stiffness[0, part, part], model.mass[part, part])
        for square, shape in list(zip(squares, (rows @ modes).T, strict=True))[:4]:
            w = float(np.sqrt(square))
            one = {"frequency": w, "damping_ratio": 0.5e-4 * w, keys[0]: shape.tolist(), keys[1]: [0.0, 0.0]}
            resonances.append(one)
    modal = machine_of({"kind": "modal", "positions": places, "total_mass": "5 kg", "resonances": resonances})
    still = machine_of({**SHAFT, "supports": springs, "disks": [{**d, "polar_inertia": 0} for d in SHAFT["disks"]]})  # type: ignore[attr-defined]
    speeds = [np.sort(ab.rotor.critical_speeds(m)["critical_speed"].values)[:4] for m in (modal, still)]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-4)
    with pytest.raises(MachineError, match=r"rotor\.positions: 3 modes .* cannot move 4 deflections"):
        lateral_model(machine_of({**modal_keys(modal), "resonances": resonances[:3]}))


def modal_keys(machine: Machine) -> dict[str, Any]:
    return {"kind": "modal", "positions": [float(z) for z in machine.rotor.positions], "total_mass": 5.0}  # type: ignore[union-attr]


def write_table(path: Path, count: int = 4) -> None:
    columns = [f"x at {1e3 * z:g} mm" for z in PLACES] + [f"slope at {1e3 * z:g} mm [1/mm]" for z in PLACES]
    lines = ["frequency [Hz], damping ratio [%], mass [g], " + ", ".join(columns)]
    for w, x, s in zip(*modes_of_shaft(count), strict=True):
        cells = [w / (2.0 * np.pi), 100.0 * 0.5e-4 * w, 1e3, *x, *(1e-3 * s)]
        lines.append(", ".join(f"{float(cell)!r}" for cell in cells))
    path.write_text("\n".join(lines))


def write_universal(path: Path, complex_modes: bool, count: int = 4) -> None:
    """Each mode twice, along two lines that are turned by 30 degrees, in mm, t and s."""
    pyuff = pytest.importorskip("pyuff")
    sets = [
        {"type": 164, "units_code": 5, "length": 1e3, "force": 1.0, "temp": 1.0, "temp_offset": 0.0}
        | {"units_description": "mm", "temp_mode": 1},
        {"type": 15, "node_nums": [1, 2, 3, 4], "def_cs": [0] * 4, "disp_cs": [0] * 4, "color": [0] * 4}
        | {"x": [0.0] * 4, "y": [0.0] * 4, "z": [1e3 * z for z in PLACES]},
    ]
    turned = ((np.cos(0.5), np.sin(0.5)), (-np.sin(0.5), np.cos(0.5)))
    for number, (w, x, s) in enumerate(zip(*modes_of_shaft(count), strict=True)):
        for a, b in turned:
            ratio, mass = 0.5e-4 * w, 2.0e-3  # t
            one: dict[str, Any] = {"type": 55, "analysis_type": 3 if complex_modes else 2, "data_ch": 2, "load_case": 1}
            one |= {"spec_data_type": 8, "mode_n": number + 1, "node_nums": [1, 2, 3, 4]}
            size = np.sqrt(2.0) * (np.exp(0.3j) if complex_modes else 1.0)
            one |= {"r1": a * size * x, "r2": b * size * x, "r3": 0.0 * size * x}
            if complex_modes:
                pole = w * complex(-ratio, np.sqrt(1.0 - ratio**2))
                one |= {"eig": pole, "modal_a": 2j * pole.imag * mass * np.exp(0.6j), "modal_b": 0j}
            else:
                slope = 1e-3 * size * s
                one |= {"freq": w / (2.0 * np.pi), "modal_m": mass, "modal_damp_vis": ratio, "modal_damp_his": 0.0}
                one |= {"r4": -b * slope, "r5": a * slope, "r6": 0.0 * slope}
            sets.append(one)
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")


@pytest.mark.parametrize("name", ["modes.csv", "normal.uff", "complex.uff"])
def test_files_of_modes_give_the_same_rotor(name: str, tmp_path: Path) -> None:
    if name == "modes.csv":
        write_table(tmp_path / name)
    else:
        write_universal(tmp_path / name, name == "complex.uff")
    rotor: dict[str, Any] = {"kind": "modal", "total_mass": "5 kg", "files": {"file": name}}
    if name != "complex.uff":  # which has no rotations
        rotor["polar_inertias"] = [0.0, 0.006, 0.0, 0.006]
    model, wanted = (
        lateral_model(machine_of(one, tmp_path))
        for one in (rotor, modal_rotor(4) | {} if name != "complex.uff" else modal_rotor(4) | {"polar_inertias": []})
    )
    rows = [np.array([m.axis.rows(z, None).deflection for z in PLACES]) for m in (model, wanted)]
    for frequency in (150.0, 700.0):
        ours, theirs = (m.receptance(1j * frequency, 200.0, r) for m, r in zip((model, wanted), rows, strict=True))
        assert np.abs(ours - theirs).max() < 1e-3 * np.abs(theirs).max()  # five digits in universal files


def test_kept_stations_and_fewer_modes_of_a_file_are_taken_and_said(tmp_path: Path) -> None:
    write_table(tmp_path / "modes.csv")
    files = {"file": "modes.csv", "keep": ["100 mm", "300 mm"], "modes": 2}
    machine = machine_of({"kind": "modal", "total_mass": "5 kg", "files": files}, tmp_path)
    rotor = machine.rotor
    assert [float(z) for z in rotor.positions] == pytest.approx([0.1, 0.3])  # type: ignore[union-attr]
    assert rotor.source == "modes.csv: 2 of 4 modes"  # type: ignore[union-attr]
    faster = ab.with_parameter(machine, "drive.profile.speed", 600.0)
    said = " ".join(input_notes(faster, None))
    assert "should be at twice that or above" in said
    assert "% of the static deflection under a force at" in said


def scaled(shape: float, slope: float) -> dict[str, Any]:
    return {
        "resonances": [
            mode | {name: [by * one for one in mode[name]] for name, by in (("shape", shape), ("slope", slope))}
            for mode in modal_rotor(2)["resonances"]
        ]
    }


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (scaled(1e3, 1e3), r"rotor\.resonances: shapes out of scale: a mode moves as .*e-0. kg .* the rotor has 5 kg"),
        (scaled(1e3**-0.5, 1e3**-0.5), r"rotor\.resonances: shapes out of scale"),
        (scaled(1.0, 1e-3), r"rotor\.resonances: slopes are 0\.00\d* times as steep"),
        (scaled(1.0, -1.0), r"rotor\.resonances: slopes fall where deflections rise"),
        (
            {"resonances": [mode | {"shape": [0.2, 0.5, 1.0, -0.1]} for mode in modal_rotor(2)["resonances"]]},
            "is one, so",
        ),
        ({"total_mass": None}, r"rotor\.total_mass: missing; shapes do not say it"),
        ({"positions": [0.1, 0.0, 0.25, 0.3]}, r"rotor\.positions: must ascend"),
        ({"positions": []}, r"rotor\.polar_inertias: needs 'positions'"),
        ({"polar_inertias": [0.006]}, r"rotor\.polar_inertias: has 1 values for 4 positions"),
        ({"resonances": [{"frequency": 9.0, "damping_ratio": 0.0, "shape": [1.0]}]}, r"shape: has 1 values for 4 pos"),
        ({"resonances": []}, r"rotor: resonances: missing"),
        ({"files": {"file": "no.uff"}, "resonances": None, "positions": None}, r"rotor\.files\.file: .*no\.uff"),
        ({"files": {"file": "modes.csv"}}, r"rotor\.files: positions: is read from the files"),
    ],
)
def test_modes_that_are_no_rotor_are_refused_with_their_key(change: dict[str, Any], said: str, tmp_path: Path) -> None:
    rotor = {name: value for name, value in (modal_rotor(2) | change).items() if value is not None}
    with pytest.raises(MachineFileError, match=said):
        machine_of(rotor, tmp_path)


def test_without_participations_weight_across_the_axis_is_refused_by_name() -> None:
    with pytest.raises(MachineFileError, match=r"axis: without the 'participation' of each mode its shapes"):
        machine_of(modal_rotor(2), rest=REST.replace('"vertical"', '"horizontal"'))


def test_sections_of_a_shaft_in_a_table_are_those_given_by_keys(tmp_path: Path) -> None:
    (tmp_path / "shaft.csv").write_text(
        "length [mm], diameter [mm], inner_diameter [mm], elements, density [kg/m^3], youngs_modulus [GPa], poisson_ratio\n"
        "120.5, 20, , 3, , ,\n80, 25, 5, , 2700, 70, 0.33\n99.5, 20, , , , ,\n"
    )
    (tmp_path / "bearings.csv").write_text("position [mm]; stiffness [N/mm]\n0; 200\n250; 300\n")
    material = {"density": "2700 kg/m^3", "youngs_modulus": "70 GPa", "poisson_ratio": 0.33}
    segments = [
        {"length": "120.5 mm", "diameter": "20 mm", "elements": 3},
        {"length": "80 mm", "diameter": "25 mm", "inner_diameter": "5 mm", "material": material},
        {"length": "99.5 mm", "diameter": "20 mm"},
    ]
    files = {"segments": {"file": "shaft.csv"}, "supports": {"file": "bearings.csv"}}
    assert machine_of({**SHAFT, **files}, tmp_path) == machine_of({**SHAFT, "segments": segments})
    for head, said in (
        ("length, diameter [mm]", r"rotor\.segments\.file: .*column 'length' has no unit; write it so: length \[m\]"),
        ("length [mm], diametre [mm]", r"rotor\.segments\.file: .*did you mean 'diameter'"),
    ):
        (tmp_path / "shaft.csv").write_text(f"{head}\n100, 20\n200, 20\n")
        with pytest.raises(MachineFileError, match=said):
            machine_of({**SHAFT, **files}, tmp_path)


KNOWN = {  # a rotor that moves and tilts on supports that differ along x and y, 1/sqrt(kg)
    "kind": "modal",
    "positions": ["100 mm", "300 mm"],
    "total_mass": "5 kg",
    "resonances": [
        {"frequency": w, "damping_ratio": d, "shape": x, "shape_y": y}
        for w, d, x, y in (
            ("40 Hz", 0.02, [0.5, 0.4], [0.05, 0.04]),
            ("46 Hz", 0.03, [-0.05, -0.04], [0.5, 0.4]),
            ("80 Hz", 0.02, [-0.3, 0.6], [0.0, 0.0]),
            ("95 Hz", 0.02, [0.0, 0.0], [-0.3, 0.6]),
        )
    ],
}
PLACED = {"disc": "100 mm", "race": "300 mm"}


def receptances(machine: Machine, frequencies: Any, noise: float) -> dict[tuple[str, str], Any]:
    """Receptances between two places along x and y, with a relative noise."""
    model, random = lateral_model(machine), np.random.default_rng(3)
    rows = np.array([model.axis.rows(z, None).deflection for z in (0.1, 0.3)])
    whole = np.array([model.receptance(1j * w, 0.0, rows) for w in frequencies])
    names = ["disc", "race", "disc y", "race y"]
    blurred = whole * (1.0 + noise * (random.standard_normal(whole.shape) + 1j * random.standard_normal(whole.shape)))
    return {(a, b): blurred[:, i, j] for i, a in enumerate(names) for j, b in enumerate(names) if i >= j}


def test_measured_receptances_of_two_places_along_x_and_y_are_the_rotor_that_made_them(tmp_path: Path) -> None:
    known, frequencies = machine_of(KNOWN), 2.0 * np.pi * np.linspace(20.0, 130.0, 111)
    lines = ["frequency [rad/s], response, force, real [m/N], imag [m/N]"]
    for (response, force), values in receptances(known, frequencies, 1e-3).items():
        cells = zip(frequencies.tolist(), values.tolist(), strict=True)
        lines += [f"{w!r}, {response}, {force}, {h.real!r}, {h.imag!r}" for w, h in cells]
    (tmp_path / "hammer.csv").write_text("\n".join(lines))
    fit = ab.measure.receptance(ab.measure.load_receptance(tmp_path / "hammer.csv"), modes=4)
    assert fit.attrs["fit_error"] == pytest.approx(1e-3 * np.sqrt(2.0), rel=0.2)  # the noise of both parts
    rotor = ab.measure.receptance_rotor(fit, positions=PLACED, total_mass="5 kg")
    found = known.model_copy(update={"rotor": rotor})
    speeds = [ab.rotor.critical_speeds(m)["critical_speed"].values for m in (found, known)]
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-3)
    runs = [ab.simulate(m, duration=0.02)["station_x"] for m in (found, known)]
    assert float(abs(runs[0] - runs[1]).max()) < 0.01 * float(abs(runs[1]).max())
    with pytest.raises(ab.errors.QuestionError, match="receptance_rotor makes a rotor of them"):
        pole_model(fit)
    with pytest.raises(ab.errors.AutobalancerError, match="positions race: "):
        ab.measure.receptance_rotor(fit, positions={"disc": "100 mm"}, total_mass="5 kg")


def test_a_roving_hammer_of_a_universal_file_gives_the_shapes_along_one_direction(tmp_path: Path) -> None:
    pyuff = pytest.importorskip("pyuff")
    known = machine_of(modal_rotor(2) | {"polar_inertias": []})
    frequencies = 2.0 * np.pi * np.linspace(20.0, 90.0, 141)
    sets = [
        pyuff.prepare_58(
            func_type=4, rsp_node=2, rsp_dir=1, ref_node=1 + (force == "race"), ref_dir=-1, data=-values,
            x=frequencies / (2.0 * np.pi), abscissa_spec_data_type=18, ordinate_spec_data_type=8,
            ordinate_axis_units_lab="m", orddenom_spec_data_type=13, orddenom_axis_units_lab="N",
        )
        for (response, force), values in receptances(known, frequencies, 1e-3).items()
        if response == "race" and force in ("disc", "race")
    ]  # fmt: skip
    pyuff.UFF(str(tmp_path / "hammer.uff")).write_sets(sets)
    measured = ab.measure.load_receptance(tmp_path / "hammer.uff", function="all")
    fit = ab.measure.receptance(measured, modes=2)
    rotor = ab.measure.receptance_rotor(fit, positions={"1": 0.1, "2": 0.3}, total_mass="5 kg")
    for ours, theirs in zip(rotor.resonances, known.rotor.resonances, strict=True):  # type: ignore[union-attr]
        assert float(ours.frequency) == pytest.approx(float(theirs.frequency), rel=1e-3)
        assert np.abs(ours.shape) == pytest.approx(np.abs(np.array(theirs.shape)[[1, 3]]), rel=0.02)
    with pytest.raises(ab.errors.QuestionError, match="measure a driving point"):
        ab.measure.receptance(measured.isel(pair=[0]), modes=2)
