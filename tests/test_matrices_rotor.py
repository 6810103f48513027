"""A rotor that is given by matrices of another program: the same machine as the shaft from which they were taken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import io, sparse
from scipy.linalg import eigh

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.grounds import sag
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.errors import MachineFileError
from autobalancer.files.examples import example_text
from autobalancer.files.machine_file import machine_text, parse_race_machine
from autobalancer.machine import Machine
from autobalancer.simulation.remarks import input_notes

TEXT = example_text("cfrp_rig").replace(
    'position = "275.72 mm"', 'position = "180 mm"'
)  # the station is a node of the shaft
SHAFT = parse_race_machine(TEXT)
MODEL = lateral_model(SHAFT)
FILES = {"file": "rotor.npz", "nodes": "nodes.csv", "length_unit": "mm", "mass_unit": "t"}
KEPT = ["0 mm", "165.5 mm", "180 mm"]
Matrices = dict[str, Any]


def exported(folder: Path, model: LateralModel = MODEL) -> Matrices:
    """Matrices of the shaft in t, mm and s, node by node with ux, uy, rx, ry; writes the table of nodes."""
    nodes = 1e3 * model.axis.mesh.nodes  # type: ignore[attr-defined]
    row = {
        (n, way): 2 * n + (way[0] == "r") + model.pairs * (way in ("uy", "rx"))
        for n in range(nodes.size)
        for way in WAYS
    }
    labels = [(n, way) for n in range(nodes.size) for way in WAYS]
    order = [row[label] for label in labels]
    factor = np.array([{"u": 1.0, "r": 1e3}[way[0]] * (-1.0 if way == "rx" else 1.0) for _, way in labels])
    lines = [f"{n + 1}, {way}, {nodes[n]:.12g}" for n, way in labels]
    (folder / "nodes.csv").write_text("node, direction, position [mm]\n" + "\n".join(lines) + "\n")
    whole = {"M": model.mass, "K": model.stiffness[0], "C": model.damping[0], "G": model.gyroscopic}
    return {name: 1e-3 * factor[:, None] * matrix[np.ix_(order, order)] * factor for name, matrix in whole.items()}


WAYS = ("ux", "uy", "rx", "ry")


def machine_of(folder: Path, files: Matrices = FILES, **rotor: Any) -> Machine:
    """The machine of the shaft with its rotor from files."""
    import tomli_w

    begin, end = TEXT.index("[rotor]"), TEXT.index("[[stations]]")
    table = tomli_w.dumps({"rotor": {"kind": "matrices", "files": files, **rotor}})
    machine = ab.parse_machine(TEXT[:begin] + table + TEXT[end:], folder=folder)
    assert isinstance(machine, Machine)
    return machine


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("matrices")
    np.savez(place / "rotor.npz", **exported(place))
    return place


def test_all_rows_of_exported_matrices_are_the_model_of_the_shaft(folder: Path) -> None:
    machine = machine_of(folder)
    model = lateral_model(machine)
    for name in ("mass", "gyroscopic", "stiffness", "damping"):
        ours, theirs = getattr(model, name), getattr(MODEL, name)
        assert ours == pytest.approx(theirs, abs=1e-12 * np.abs(theirs).max()), name
    assert machine.rotor.inertia == pytest.approx(SHAFT.rotor.inertia, rel=1e-9)
    assert model.total_mass == pytest.approx(MODEL.total_mass, rel=1e-9)
    assert model.isotropic
    assert parse_race_machine(machine_text(machine)) == machine  # a result needs no other file


def test_few_coordinates_of_them_have_its_borders_modes_and_weight(folder: Path) -> None:
    machine = machine_of(folder, {**FILES, "keep": KEPT, "modes": 3})
    model = lateral_model(machine)
    assert model.size == 2 * (6 + 3)
    assert "Craig-Bampton, 88 to 18 coordinates" in machine.rotor.source  # type: ignore[union-attr]
    assert model.isotropic
    ours, theirs = (ab.rotor.critical_speeds(m)["critical_speed"].values[:3] for m in (machine, SHAFT))
    assert ours == pytest.approx(theirs, rel=1e-5)
    border = [next(b.speed for b in ab.stability.borders(m) if b.name == "exact border") for m in (machine, SHAFT)]
    assert border[0] == pytest.approx(border[1], rel=1e-5)  # three modes; with all rows it is the same model
    for number in (0, 1, 2):  # static answers of kept nodes are exact
        places = [
            m.axis.rows(float(z), None) for m, z in zip((model, MODEL), [(0.0, 0.1655, 0.18)[number]] * 2, strict=True)
        ]
        sinks = [
            m.both(place.deflection[None])[1] @ sag(m, 9.81) for m, place in zip((model, MODEL), places, strict=True)
        ]
        assert sinks[0] == pytest.approx(sinks[1], rel=1e-9, abs=1e-12)


def test_a_rotor_whose_planes_are_coupled_keeps_modes_that_are_in_none_of_them(folder: Path, tmp_path: Path) -> None:
    matrices = exported(tmp_path)
    matrices["K"][20, 21] += 5.0  # t/s^2, between x and y of a node
    matrices["K"][21, 20] += 5.0
    np.savez(tmp_path / "rotor.npz", **matrices)
    whole, few = (machine_of(tmp_path, {**FILES, **more}) for more in ({}, {"keep": KEPT, "modes": 6}))
    assert any(coordinate.direction == "modal" for coordinate in few.rotor.coordinates)  # type: ignore[union-attr]
    assert not lateral_model(few).isotropic
    ours, theirs = (ab.rotor.critical_speeds(m)["critical_speed"].values[:3] for m in (few, whole))
    assert ours == pytest.approx(theirs, rel=1e-5)


def test_a_run_says_what_the_modes_that_it_leaves_out_change(folder: Path) -> None:
    few, all_of_them = (machine_of(folder, {**FILES, "keep": KEPT, "modes": 3}, modes=modes) for modes in (1, 9))
    said = [ab.simulate(machine, duration=0.01, progress=False).attrs for machine in (few, all_of_them)]
    assert said[0]["reduction_error"] > 0.01
    assert any(
        line.startswith("1 of 9 modes of the rotor were kept; without the others") for line in said[0]["remarks"]
    )
    assert said[1]["reduction_error"] == 0.0
    assert not any("modes of the rotor were kept" in line for line in said[1]["remarks"])


def test_matrices_in_memory_are_a_rotor_too_and_rows_without_mass_have_no_mode(folder: Path) -> None:
    matrices = exported(folder)
    ways, positions = [*WAYS] * (matrices["K"].shape[0] // 4), np.repeat(MODEL.axis.mesh.nodes, 4)  # type: ignore[attr-defined]
    to_si = 1e3 * np.outer(*[np.array([1e-3 if way[0] == "r" else 1.0 for way in ways])] * 2)
    m, k, c, g = (sparse.csc_array(to_si * matrices[name]) for name in "MKCG")
    rotor = ab.rotor.from_matrices(m, k, ways, positions, damping=c, gyroscopic=g, keep=[0.0, 0.1655, 0.18], modes=3)
    theirs = machine_of(folder, {**FILES, "keep": KEPT, "modes": 3}).rotor
    assert np.array(rotor.stiffness_matrix) == pytest.approx(np.array(theirs.stiffness_matrix), rel=1e-6, abs=1e-3)  # type: ignore[union-attr]
    lumped = sparse.diags_array(np.where([way[0] == "u" for way in ways], m.diagonal(), 0.0)).tocsc()
    for modes, close in ((4, 2e-3), (200, 1e-7)):  # stiffnesses of the clamp are 1e7 times those of the shaft
        few = ab.rotor.from_matrices(lumped, k, ways, positions, keep=[0.0, 0.18], modes=modes)
        ours = np.sqrt(eigh(np.array(few.stiffness_matrix), np.array(few.mass_matrix), eigvals_only=True)[:4])
        shares = eigh(lumped.toarray(), k.toarray(), eigvals_only=True)[::-1][:4]
        assert ours == pytest.approx(1.0 / np.sqrt(shares), rel=close)
    with pytest.raises(ab.errors.MachineError, match="keep: missing; row 3, rx of node 1, has no mass"):
        ab.rotor.from_matrices(lumped, k, ways, positions)
    assert len(few.coordinates) == 4 + 2 * (len(ways) // 4 - 2)  # one mode for each deflection inside
    with pytest.raises(ab.errors.MachineError, match="positions: has 3 rows for 88 directions"):
        ab.rotor.from_matrices(m, k, ways, [0.0, 0.1, 0.2])


def test_supports_stand_beside_what_the_matrices_contain(folder: Path) -> None:
    held = {"position": "165.5 mm", "stiffness": "2 N/mm", "damping": "3 N*s/m"}
    text = TEXT.replace('damping = "57 N*s/m"', 'stiffness = "2 N/mm"\ndamping = "60 N*s/m"')
    ours = lateral_model(machine_of(folder, supports=[held]))
    theirs = lateral_model(parse_race_machine(text))
    assert ours.stiffness == pytest.approx(theirs.stiffness, abs=1e-9 * np.abs(theirs.stiffness).max())


def _market(path: Path, matrix: Any) -> None:
    with path.open("wb") as file:
        io.mmwrite(file, sparse.coo_array(matrix), precision=17)


def _triplets(path: Path, matrix: Any) -> None:
    half = sparse.coo_array(np.tril(matrix))
    path.write_text(
        "# row, column, value\n"
        + "\n".join(f"{i + 1}, {j + 1}, {v!r}" for i, j, v in zip(*half.coords, half.data.tolist(), strict=True))
    )


def _nodal(path: Path, matrix: Any) -> None:
    whole = sparse.coo_array(matrix)
    ends = [[(1 + k // 4, {"ux": 1, "uy": 2, "rx": 4, "ry": 5}[WAYS[k % 4]]) for k in side] for side in whole.coords]
    lines = [f"{a[0]},{a[1]}, {b[0]},{b[1]}, {v!r}" for a, b, v in zip(*ends, whole.data.tolist(), strict=True)]
    path.write_text("** matrix of stiffness\n" + "\n".join(lines))


def _harwell(path: Path, matrix: Any) -> None:
    io.hb_write(path, sparse.csc_matrix(matrix))


def _op4(path: Path, matrix: Any) -> None:
    pytest.importorskip("pyyeti.nastran.op4").write(str(path), {"KAA": matrix})


def _punched(path: Path, matrix: Any) -> None:
    """DMIG of a symmetric matrix, large fields, as Nastran punches it: columns of the upper half."""
    pytest.importorskip("pyyeti")
    lines = [f"DMIG    KAAX    {0:8d}{6:8d}{2:8d}{0:8d}{'':24}{len(matrix):8d}"]
    ends = [(1 + k // 4, {"ux": 1, "uy": 2, "rx": 4, "ry": 5}[WAYS[k % 4]]) for k in range(len(matrix))]
    for j, (node, way) in enumerate(ends):
        lines.append(f"DMIG*   KAAX            {node:16d}{way:16d}")
        lines += [
            f"*       {ends[i][0]:16d}{ends[i][1]:16d}{matrix[i, j]:16.9E}"[:72].replace("E", "D")
            for i in range(j, len(matrix))
            if matrix[i, j]
        ]
    path.write_text("\n".join(lines) + "\n")


WRITERS: dict[str, Callable[[Path, Any], None]] = {
    "K.mtx": _market,
    "K.txt": _triplets,
    "K.csv": _nodal,
    "K.dat": np.savetxt,  # row by row
    "K.npz": lambda path, matrix: sparse.save_npz(path, sparse.csr_array(matrix)),
    "K.mat": lambda path, matrix: io.savemat(path, {"K": matrix}),
    "K.hb": _harwell,
    "K_STIF1.mtx": _nodal,  # as Abaqus writes it, FORMAT=MATRIX INPUT
    "K.mmf": _market,  # as Ansys does by *EXPORT
    "K.op4": _op4,
    "K.pch": _punched,
}


@pytest.mark.parametrize("name", WRITERS)
def test_each_format_gives_the_same_matrix(name: str, folder: Path, tmp_path: Path) -> None:
    matrices = exported(tmp_path)
    WRITERS[name](tmp_path / name, matrices["K"])
    np.savez(tmp_path / "others.npz", M=matrices["M"], C=matrices["C"], G=matrices["G"])
    files = {**FILES, "file": "others.npz", "stiffness": name}
    ours = lateral_model(machine_of(tmp_path, files)).stiffness
    assert ours == pytest.approx(MODEL.stiffness, abs=1e-7 * np.abs(MODEL.stiffness).max())  # some write few digits


def test_a_mapping_of_ansys_says_what_the_rows_are_in_any_order(tmp_path: Path) -> None:
    matrices, order = exported(tmp_path), np.random.default_rng(1).permutation(88)
    np.savez(tmp_path / "rotor.npz", **{name: matrix[np.ix_(order, order)] for name, matrix in matrices.items()})
    names = {"ux": "UX", "uy": "UY", "rx": "ROTX", "ry": "ROTY"}
    lines = [f"{k + 1:12d}{1 + row // 4:12d}    {names[WAYS[row % 4]]}" for k, row in enumerate(order)]
    (tmp_path / "K.mapping").write_text("\n".join(["  Matrix Eqn      Node     DOF", *lines[::-1]]))
    nodes = [f"{n + 1}, {1e3 * z!r}" for n, z in enumerate(MODEL.axis.mesh.nodes.tolist())]  # type: ignore[attr-defined]
    (tmp_path / "nodes.csv").write_text("\n".join(["node, position [mm]", *nodes]))
    ours = lateral_model(machine_of(tmp_path, {**FILES, "rows": "K.mapping"}))
    assert ours.stiffness == pytest.approx(MODEL.stiffness, abs=1e-12 * np.abs(MODEL.stiffness).max())
    (tmp_path / "nodes.csv").write_text("\n".join(["node, position [mm]", *nodes[1:]]))
    with pytest.raises(MachineFileError, match=r"rotor\.files\.rows: K\.mapping: node of the line '\d+ 1 "):
        machine_of(tmp_path, {**FILES, "rows": "K.mapping"})


def _changed(name: str, change: Callable[[Any], None]) -> Callable[[Path], Matrices]:
    def write(folder: Path) -> Matrices:
        matrices = exported(folder)
        change(matrices[name])
        np.savez(folder / "rotor.npz", **matrices)
        return FILES

    return write


def _set(row: int, column: int, value: float) -> Callable[[Any], None]:
    def change(matrix: Any) -> None:
        matrix[row, column] = value

    return change


def _times(matrix: Any) -> None:
    matrix *= 314.0


def _turned(matrix: Any) -> None:
    matrix *= -1.0


def _with(**more: Any) -> Callable[[Path], Matrices]:
    def write(folder: Path) -> Matrices:
        np.savez(folder / "rotor.npz", **exported(folder))
        return {key: value for key, value in {**FILES, **more}.items() if value is not None}

    return write


def _both(row: int, column: int, value: float) -> Callable[[Any], None]:
    def change(matrix: Any) -> None:
        matrix[row, column] = matrix[column, row] = value

    return change


def _filled(value: float) -> Callable[[Any], None]:
    return lambda matrix: matrix.fill(value)


def _scaled_rotations(factor: float) -> Callable[[Path], Matrices]:
    def write(folder: Path) -> Matrices:
        scale = np.array([1.0 if way[0] == "u" else factor for way in WAYS] * 22)
        np.savez(folder / "rotor.npz", **{name: np.outer(scale, scale) * of for name, of in exported(folder).items()})
        return FILES

    return write


def _exchanged(folder: Path) -> Matrices:
    matrices = exported(folder)
    np.savez(folder / "rotor.npz", M=matrices["K"], K=matrices["M"])
    return FILES


def _lines(change: Callable[[str], str]) -> Callable[[Path], Matrices]:
    def write(folder: Path) -> Matrices:
        np.savez(folder / "rotor.npz", **exported(folder))
        (folder / "nodes.csv").write_text(change((folder / "nodes.csv").read_text()))
        return FILES

    return write


def _text(name: str, text: str) -> Callable[[Path], Matrices]:
    def write(folder: Path) -> Matrices:
        (folder / name).write_text(text)
        return _with(stiffness=name)(folder)

    return write


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (_changed("K", _set(4, 8, 1.0)), r"rotor\.files\.stiffness: is not symmetric: entries 5, 9 and 9, 5 differ"),
        (_changed("M", _set(4, 4, -1.0)), r"rotor\.files\.mass: is negative in row 5, ux of node 2"),
        (_changed("K", _set(0, 0, np.nan)), r"entries that are no finite numbers"),
        (_changed("G", _turned), r"rotor\.files\.gyroscopic: turns the wrong way"),
        (
            _changed("G", _times),
            r"rotor\.files\.gyroscopic: its polar inertia is 26\.\d+ kg m\^2, and no body has more than twice",
        ),
        (_changed("M", _set(8, 12, 5.0)), r"rotor\.files\.mass: is not symmetric"),
        (_changed("M", _both(8, 12, 5.0)), r"rotor\.files\.mass: entry 9, 13 is 5000, more than the entries"),
        (_changed("M", _filled(0.0)), r"rotor\.files\.mass: is zero"),
        (_changed("C", _turned), r"rotor\.files\.damping: is negative in row 1.* would feed energy"),
        (
            _scaled_rotations(np.pi / 180.0),
            r"rotor\.files\.stiffness: bends most nodes.*57\.3 rad\. Its rotations are in deg",
        ),
        (
            _scaled_rotations(-1.0),
            r"rotor\.files\.stiffness: bends .*none with -1 rad\. Its rotations have the other sign",
        ),
        (_scaled_rotations(1e-3), r"rotor\.files\.stiffness: bends .*none with 1000 rad\. Look at length_unit"),
        (_with(length_unit="m"), r"rotor\.files\.stiffness: bends .*none with 0\.001 rad\. Look at length_unit"),
        (_exchanged, r"rotor\.files\.mass: has no inertia at most nodes .* exchange M and K"),
        (
            _lines(lambda line: line.replace("ux", "uz")),
            r"rotor\.files\.nodes: no row is ux; positions count along the axis",
        ),
        (
            _lines(lambda line: line.replace("2, ux", "1, ux")),
            r"rotor\.files\.nodes: nodes\.csv: ux of node 1 stands twice",
        ),
        (
            _lines(lambda line: line.replace("22, ry", "# 22")),
            r"rotor\.files\.file: rotor\.npz: mass is 88 by 88, .* 87 rows",
        ),
        (_text("K.npz", ""), r"rotor\.files\.stiffness: .*K\.npz: is empty"),
        (_text("K.npz", "1 1 5"), r"rotor\.files\.stiffness: .*it is no NPZ file"),
        (_text("K.txt", "0 0 5"), r"rotor\.files\.stiffness: .*rows and columns count from 1 to 88"),
        (
            _text("K.mtx", "%%MatrixMarket matrix coordinate complex general\n88 88 1\n1 1 1 2"),
            r"rotor\.files\.stiffness: .*stiffness is complex; give its real part",
        ),
        (_with(mass_unit=None), r"rotor\.files\.mass_unit: missing"),
        (_with(length_unit="ft"), r"rotor\.files\.length_unit: "),
        (_with(file="nodes.csv", nodes="nodes.csv"), r"rotor\.files\.file: .*each line must be"),
        (_with(mass="nodes.op2"), r"rotor\.files\.mass: .*let Nastran write OP4"),
        (_with(keep=["33 mm"]), r"rotor\.files\.keep\[1\]: no node is at 0\.033 m; the nearest is at 0\.0"),
        (_with(nodes="other.csv"), r"rotor\.files\.nodes: .*other\.csv"),
    ],
)
def test_impossible_files_are_refused_with_their_key(
    write: Callable[[Path], Matrices], said: str, tmp_path: Path
) -> None:
    with pytest.raises(MachineFileError, match=said):
        machine_of(tmp_path, write(tmp_path))


def test_what_is_odd_about_matrices_is_said(folder: Path, tmp_path: Path) -> None:
    machine = machine_of(folder, {**FILES, "keep": KEPT, "modes": 3, "mass_unit": "kg"})
    notes = input_notes(ab.with_parameter(machine, "drive.profile.speed", [0.0, 15000.0]), None)
    assert any("few coordinates stand for all rows of the matrices up to" in note for note in notes)
    assert any("the balls are 129 % of the mass of the rotor, 0.006815 kg" in note for note in notes)
    matrices = exported(tmp_path)
    bare = mesh_stiffness(matrices["K"])
    np.savez(tmp_path / "rotor.npz", **{**matrices, "K": bare})
    with pytest.raises(ab.errors.MachineError, match="nothing holds the rotor across its axis; give it supports"):
        lateral_model(machine_of(tmp_path))
    for name, value in (("total_mass", "5 kg"), ("inertia", "1 kg*m^2")):
        with pytest.raises(MachineFileError, match=rf"its {name} is .*, and rotor\.{name} says {value[0]}"):
            machine_of(tmp_path, **{name: value})
    np.savez(tmp_path / "rotor.npz", **{**matrices, "K": matrices["K"] - 1.1 * matrices["K"].max() * np.eye(88)})
    with pytest.raises(ab.errors.MachineError, match="is negative for some motion, so it does not rest"):
        lateral_model(machine_of(tmp_path))
    np.savez(tmp_path / "rotor.npz", **{name: 1e3 * matrices[name] for name in "MK"})
    heavy = input_notes(machine_of(tmp_path), None)
    assert any("6815 kg; beside it the balls can move the center of mass by 0.083 um at most" in note for note in heavy)


def mesh_stiffness(stiffness: Any) -> Any:
    """Without what the clamp at the first node adds."""
    bare = stiffness.copy()
    for row, value in zip(range(4), (250e6, 250e6, 1e4 * 1e6, 1e4 * 1e6), strict=True):
        bare[row, row] -= 1e-3 * value
    return bare


def test_a_station_beside_all_nodes_is_refused_with_the_nearest(folder: Path) -> None:
    machine = machine_of(folder, {**FILES, "keep": KEPT[:2], "modes": 3})
    with pytest.raises(ab.errors.MachineError, match=r"position 0\.18 m: no node is there.*add it to 'keep'"):
        ab.rotor.critical_speeds(machine)
