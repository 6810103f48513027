"""Matrices and modes of a rotor in files of other programs, and fewer coordinates of them.

The motions of kept nodes, and the modes of the rotor with these nodes held, are the new coordinates (Craig and Bampton, 1968):
the static answer of the rotor to forces at the kept nodes stays exact, and the error at greater frequencies is measured here.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZipFile, is_zipfile

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Matrix
from autobalancer.errors import MachineError, MachineFileError, ResultError, UnitError
from autobalancer.files.text_files import TABLE, read_table, read_text
from autobalancer.machine.rotors.modal import MatricesRotor, MatrixFiles, ModeFiles
from autobalancer.results.signals import UNIVERSAL, is_universal, read_universal_modes
from autobalancer.safe_file import not_to_read
from autobalancer.units import to_si

NAMES = {"M": "mass", "K": "stiffness", "C": "damping", "G": "gyroscopic"}
LENGTHS = {"m": 1.0, "mm": 1e-3, "in": 0.0254}
NASTRAN = {
    letter + ends: ours for letter, ours in zip("MKB", "MKC", strict=True) for ends in ("AA", "AAX", "XX", "GG", "HH")
}
OTHERS = {  # what to do with files that only their program reads
    **dict.fromkeys((".op2", ".f06"), "let Nastran write OP4 (OUTPUT4) or punch DMIG (EXTSEOUT(DMIGPCH))"),
    **dict.fromkeys((".full", ".rst", ".db"), "let Ansys write it: *SMAT and *EXPORT,,MMF, or HBMAT with mapping"),
    **dict.fromkeys((".sim", ".odb"), "let Abaqus write it: *MATRIX OUTPUT, STIFFNESS, MASS, FORMAT=MATRIX INPUT"),
}
POUND = 0.45359237
MASSES = {"kg": 1.0, "t": 1e3, "g": 1e-3, "lb": POUND, "lbf*s^2/in": POUND * 9.80665 / 0.0254}
DIRECTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
SPELLINGS = {
    **{spelled: way for number, way in enumerate(DIRECTIONS, 1) for spelled in (way, str(number), f"{way[0]}{number}")},
    **{f"t{number}": way for number, way in enumerate(DIRECTIONS[:3], 1)},
    **{f"rot{way[1]}": way for way in DIRECTIONS[3:]},
}
NUMBERS = ("coordinates", "mass_matrix", "stiffness_matrix", "damping_matrix", "gyroscopic_matrix")
LARGEST = 240  # coordinates that are taken as they are
LOOSE = 1e-9  # a coupling below this, of the greatest entry, is none
SYMMETRIC = 1e-6
ROUNDING = 1e-9  # of the greatest entry
UNPACKED = 2_000_000_000  # bytes of the matrices of a file
FREE = 1e-3  # of the sizes of the parts of a force: what is left where they cancel, in files with few digits
STRAINED = 0.1
SKEW = {
    "symmetric": "what is not, such as oil films and seals, stands in `supports` or tables of them",
    "antisymmetric": "add what is symmetric to the damping",
}
ENERGY = {
    "mass": "such a body would have a negative energy",
    "damping": "it would feed energy into the rotor; with it on the left of M q'' + C q' + K q = f it takes some",
}
TURNED = (  # by which angle a rotor of matrices turns as if by one radian, and why
    (50.0, 65.0, "Its rotations are in degrees. "),
    (-1.1, -0.9, "Its rotations have the other sign: dx/dz = ry, dy/dz = -rx. "),
)
FREQUENCIES = 12  # at which the receptance of the kept nodes is compared, up to half of the first that is left out
GOOD = 0.01  # relative error of it
LOSS = 0.02  # loss factor for that comparison, so that a resonance has a size

Sparse = Any  # a matrix of scipy.sparse, (N, N)


class Given(NamedTuple):
    """What the files say, in SI: matrices over N rows, and what the rows are."""

    matrices: dict[str, Sparse]
    nodes: list[str]
    ways: NDArray[np.str_]  # (N,)
    positions: NDArray[np.float64]  # (N,) m


def rotor_from_files(entry: dict[str, Any], rotor: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The keys of a rotor of the kind "matrices" or "modal", with numbers in place of its ``files``, ``entry``.

    Raises
    ------
    MachineError
        If a file cannot be read, its matrix does not fit, or nothing holds the rotor; with the path of the key.
    """
    modal = rotor.get("kind") == "modal"
    if both := [key for key in (("positions", "resonances") if modal else NUMBERS) if key in rotor]:
        raise MachineFileError(f"{both[0]}: is read from the files; leave it out")
    if modal:
        return _modal_keys(ModeFiles(**entry), folder) | rotor
    files = MatrixFiles(**entry)
    keys = _keys(_read(files, folder), files.keep, files.modes, f"{files.file or files.mass}: ")
    for name, unit, matrix in (("total_mass", "kg", "mass"), ("inertia", "kg*m^2", "gyroscopic")):
        with contextlib.suppress(UnitError, TypeError):  # which the machine says
            declared, own = (float(to_si(of[name], unit)) if name in of else 0.0 for of in (rotor, keys))
            if declared and own and not 0.5 * declared < own < 1.01 * declared:
                text = f"its {name} is {own:.4g} {unit}, and rotor.{name} says {declared:.4g} {unit}; look at the units"
                raise MachineError(text, (matrix,))
    return keys | rotor


def from_matrices(
    mass: Any,
    stiffness: Any,
    directions: Sequence[str],
    positions: ArrayLike,
    *,
    damping: Any = None,
    gyroscopic: Any = None,
    keep: Sequence[float] | None = None,
    modes: int = 20,
) -> MatricesRotor:
    """A rotor from matrices in memory, as programs of finite elements and of rotordynamics have them.

    Parameters
    ----------
    mass, stiffness, damping, gyroscopic
        Over N rows, (N, N), SI, arrays or sparse matrices; the gyroscopic one at 1 rad/s, for a rotor that turns from x to y.
    directions
        What each row is, (N,): ``ux uy uz rx ry rz`` or 1 to 6; the axis of the rotor is z.
    positions
        Of the node of each row along the axis, (N,) m.
    keep
        Positions of nodes whose motion is kept, m: supports and stations. Without it all rows are, up to 240.
    modes
        Of the rotor with these nodes held, kept beside them (Craig and Bampton 1968).

    Returns
    -------
    MatricesRotor
        For ``Machine(rotor=...)``; its ``source`` says up to which frequency it stands for all rows.

    Raises
    ------
    MachineError
        If sizes do not fit, a matrix is impossible, or the rotor can move while the kept nodes are held.
    """
    from scipy import sparse

    parts = {"mass": mass, "stiffness": stiffness, "damping": damping, "gyroscopic": gyroscopic}
    matrices = {name: sparse.csr_array(part, dtype=np.float64) for name, part in parts.items() if part is not None}
    ways = [SPELLINGS.get(str(way).strip().lower(), str(way)) for way in directions]
    place = np.asarray(positions, np.float64)
    for name, size in (*((name, matrix.shape[0]) for name, matrix in matrices.items()), ("positions", place.size)):
        if size != len(ways):
            raise MachineError(f"{name}: has {size} rows for {len(ways)} directions; give one for each")
    if odd := [way for way in ways if way not in DIRECTIONS]:
        raise MachineError(f"directions: given {odd[0]!r}; must be one of {', '.join(DIRECTIONS)}")
    numbers = {z: str(i) for i, z in enumerate(np.unique(place), 1)}
    given = Given(matrices, [numbers[z] for z in place], np.array(ways), place)
    return MatricesRotor(**_keys(given, keep, modes, ""))


def _keys(given: Given, keep: Sequence[float] | None, modes: int, source: str) -> dict[str, Any]:
    """The keys of a rotor of the kind "matrices" in few coordinates."""
    _refuse_impossible(given)
    if keep is None:
        if given.ways.size > LARGEST:
            raise MachineError(
                f"missing; {given.ways.size} rows are too many to be taken as they are, {LARGEST} at most; name the "
                "positions of supports and stations",
                ("keep",),
            )
        for row in np.flatnonzero(given.matrices["mass"].diagonal() == 0.0):
            raise MachineError(
                f"missing; row {row + 1}, {given.ways[row]} of node {given.nodes[row]}, has no mass; name the positions of "
                "supports and stations, then rows without mass follow the others",
                ("keep",),
            )
        basis, ways, positions = np.eye(given.ways.size), list(given.ways), list(given.positions)
        note, valid = f"{given.ways.size} coordinates", np.inf
    else:
        basis, ways, positions, note, valid = _craig_bampton(given, _kept(keep, given), modes)
    small = {name: np.asarray(basis.T @ (matrix @ basis)) for name, matrix in given.matrices.items()}
    for name, matrix in small.items():
        small[name] = 0.5 * (matrix - matrix.T if name == "gyroscopic" else matrix + matrix.T)
    # the rigid motion in these coordinates, by which weight and a moving base act; of kept nodes it is one, but for rounding
    whole = np.column_stack([given.ways == "ux", given.ways == "uy"]).astype(np.float64)
    moved = np.linalg.lstsq(small["mass"], basis.T @ (given.matrices["mass"] @ whole))[0]
    moved = np.where(np.abs(moved - np.round(moved)) < 1e-9, np.round(moved), moved)
    keys: dict[str, Any] = {
        "coordinates": [
            {"direction": str(way)}
            | ({} if np.isnan(z) else {"position": float(z)})
            | ({} if tuple(shares) == (way == "ux", way == "uy") else {"translation": shares.tolist()})
            for way, z, shares in zip(ways, positions, moved, strict=True)
        ],
        **{f"{name}_matrix": matrix.tolist() for name, matrix in small.items()},
        "total_mass": f"{float(whole[:, 0] @ (given.matrices['mass'] @ whole[:, 0]))!r} kg",
        "source": f"{source}{note}",
    }
    if (inertia := _polar_inertia(given)) > 0.0:
        keys["inertia"] = f"{inertia!r} kg*m^2"
    if 0.0 < valid < np.inf:
        keys["valid_to"] = f"{valid:.6g} rad/s"
    return keys


def _read(files: MatrixFiles, folder: Path) -> Given:
    """All matrices in SI, and what their rows are."""
    try:
        table = read_table(folder / files.nodes, "node, direction, position [mm]", error=MachineFileError)
        nodes, positions = table.texts("node"), table.numbers("position", "m")
        ways = table.texts("direction") if files.rows is None else []
    except MachineFileError as error:
        raise error.within("nodes") from None
    if files.rows is not None:
        text = read_text(folder / files.rows, TABLE, MachineFileError)
        lines = [parts for line in text.splitlines() if (parts := line.split())[:1] and parts[0].isdigit()]
        places = dict(zip(nodes, positions, strict=True))
        lost = next((line for line in lines if len(line) != 3 or line[1] not in places), None)
        if not lines or lost is not None:
            what = (
                f"node of the line {' '.join(lost)!r} is not in {files.nodes}"
                if lost
                else "no line 'number node direction'"
            )
            raise MachineFileError(f"{files.rows}: {what}", ("rows",))
        _, nodes, ways = map(list, zip(*sorted(lines, key=lambda line: int(line[0])), strict=True))
        positions = np.array([places[node] for node in nodes])
    ways = [SPELLINGS.get(text.strip().lower(), text) for text in ways]
    for line, way in enumerate(ways, 1):
        if way not in DIRECTIONS:
            raise MachineFileError(
                f"{files.nodes}, row {line}: direction {way!r}; must be one of {', '.join(DIRECTIONS)}", ("nodes",)
            )
    labels = list(zip(nodes, ways, strict=True))
    if len(number := {label: line for line, label in enumerate(labels)}) < len(labels):
        node, way = next(label for line, label in enumerate(labels) if number[label] != line)
        raise MachineFileError(f"{files.nodes}: {way} of node {node} stands twice", ("nodes",))
    matrices: dict[str, Any] = {}
    for key, place in _places(files):
        matrices |= _matrices_in(folder / place, key, labels)
    for name in ("mass", "stiffness"):
        if name not in matrices:
            raise MachineFileError(f"missing; give a file of the {name} matrix, or one 'file' that has it", (name,))
    length = LENGTHS[files.length_unit]
    scale = np.where(
        np.char.startswith(ways, "u"), 1.0, length
    )  # q of the file = q in SI over the unit of length, or an angle
    scaled = {name: _scaled(matrix, scale, MASSES[files.mass_unit]) for name, matrix in matrices.items()}
    return Given(scaled, nodes, np.array(ways), positions)


def _places(files: MatrixFiles) -> Iterator[tuple[str, str]]:
    """The keys that name a file, and the file."""
    for key in ("file", *NAMES.values()):
        if (place := getattr(files, key)) is not None:
            yield key, place


def _scaled(matrix: Sparse, scale: NDArray[np.float64], unit: float) -> Sparse:
    """A matrix in SI; its entries are energies over two coordinates."""
    from scipy import sparse

    ways = sparse.diags_array(scale)
    return (ways @ matrix @ ways).tocsr() * unit


# Formats: each gives the matrices of a file by the names of the keys.


def _matrices_in(path: Path, key: str, labels: list[tuple[str, str]]) -> dict[str, Sparse]:
    from scipy import sparse

    reader = FORMATS.get(path.suffix.lower())
    if reader is None:
        advice = OTHERS.get(path.suffix.lower(), "write it with scipy.io.mmwrite")
        text = f"{path}: is of no known format; {advice}. Known are {', '.join(sorted(FORMATS))}"
        raise MachineFileError(text, (key,))
    if reason := not_to_read(path) or ("" if path.stat().st_size else "is empty"):
        raise MachineFileError(f"{path}: {reason}", (key,))
    try:
        held = reader(path, labels)
    except MachineFileError as error:
        raise error.within(key) from None
    except Exception as fault:  # whatever a reader says of a damaged file
        raise MachineFileError(f"{path}: cannot be read: {fault}", (key,)) from None
    if key == "file":
        found, held = held, {NAMES[name]: matrix for name, matrix in held.items() if name in NAMES}
        if not held:
            names = f"; it has {', '.join(found)}" if any(found) else ""
            raise MachineFileError(f"{path}: has no matrix named {', '.join(NAMES)}{names}", (key,))
    elif len(held) != 1:
        raise MachineFileError(
            f"{path}: has {len(held)} matrices; give one a file, or name them M, K, C, G and use 'file'", (key,)
        )
    else:
        held = {key: next(iter(held.values()))}
    for name, matrix in held.items():
        if np.shape(matrix) != (len(labels), len(labels)):
            size = " by ".join(map(str, np.shape(matrix))) or "no matrix"
            raise MachineFileError(f"{path.name}: {name} is {size}, but 'nodes' has {len(labels)} rows", (key,))
        if np.iscomplexobj(matrix):
            text = (
                f"{path}: {name} is complex; give its real part, and 'damping', imag(K)/w at the speed w that matters"
            )
            raise MachineFileError(text, (key,))
        held[name] = sparse.csr_array(matrix, dtype=np.float64)
        if not np.isfinite(held[name].data).all():
            raise MachineFileError(f"{path}: {name} has entries that are no finite numbers", (key,))
    return held


def _nastran(path: Path, labels: list[tuple[str, str]]) -> dict[str, Sparse]:
    """OP4, whose rows are those of the table of nodes, and punched DMIG, which names node and direction itself."""
    try:
        from pyyeti.nastran import bulk, op4
    except ImportError:
        raise MachineFileError(
            f"{path}: is read by pyyeti, pip install 'autobalancer[nastran]'; or write it with scipy.io.mmwrite"
        ) from None
    if path.suffix.lower() == ".op4":
        return {NASTRAN.get(name.upper(), name.upper()): matrix for name, matrix in op4.read(path, sparse=None).items()}
    held, number = {}, {label: i for i, label in enumerate(labels)}
    for name, frame in bulk.rddmig(str(path)).items():
        rows, columns = (
            [_row((str(node), SPELLINGS.get(str(way), "")), number) for node, way in ends]
            for ends in (frame.index, frame.columns)
        )
        held[NASTRAN.get(name.upper(), name.upper())] = matrix = np.zeros((len(labels), len(labels)))
        matrix[np.ix_(rows, columns)] = frame.to_numpy()
    return held


def _row(label: tuple[str, str], number: dict[tuple[str, str], int]) -> int:
    if label not in number:
        raise ValueError(f"node {label[0]} has no row of direction {label[1]!r} in the table of nodes")
    return number[label]


def _harwell_boeing(path: Path, labels: object) -> dict[str, Sparse]:
    from scipy.io import hb_read

    matrix = hb_read(path)
    with path.open() as file:
        kind = file.readlines(400)[2][:3].lower()
    if kind[1:2] == "s":  # one half is written
        matrix = matrix + matrix.T - np.diag(matrix.diagonal())
    return {"": matrix}


def _npz(path: Path, labels: object) -> dict[str, Sparse]:
    from scipy import sparse

    if not is_zipfile(path):
        raise ValueError("it is no NPZ file; numpy.savez writes one")
    with ZipFile(path) as packed:
        _refuse_endless(sum(part.file_size for part in packed.infolist()))
    with np.load(path, allow_pickle=False) as held:
        if "format" in held:
            return {"": sparse.load_npz(path)}
        return {name: held[name] for name in held}


def _refuse_endless(size: int) -> None:
    """Refuse a packed file that would take all memory."""
    if size > UNPACKED:
        raise ValueError(
            f"it has {size / 1e9:.3g} GB, at most {UNPACKED / 1e9:.3g} GB are taken; write sparse matrices"
        )


def _mat(path: Path, labels: object) -> dict[str, Sparse]:
    from scipy.io import loadmat, whosmat

    _refuse_endless(sum(8 * math.prod(shape) for _, shape, kind in whosmat(path) if kind != "sparse"))
    held = loadmat(path)
    return {name: matrix for name, matrix in held.items() if not name.startswith("__") and np.ndim(matrix) == 2}


def _triplets(path: Path, labels: list[tuple[str, str]]) -> dict[str, Sparse]:
    """Lines ``row, column, value``, or ``node, direction, node, direction, value``; half of a symmetric one; or Matrix Market."""
    from scipy import sparse
    from scipy.io import mmread

    with path.open("rb") as file:
        if file.read(14).lower() == b"%%matrixmarket":
            return {"": mmread(path)}
    lines = [line.replace(",", " ").split() for line in path.read_text().splitlines()]
    lines = [line for line in lines if line and line[0][0] not in "#*!%$"]
    if len(labels) not in (3, 5) and {len(lines), *map(len, lines)} == {len(labels)}:  # row by row
        return {"": np.array(lines, np.float64)}
    if not lines or any(len(line) != len(lines[0]) for line in lines) or len(lines[0]) not in (3, 5):
        raise ValueError(
            "each line must be 'row column value', 'node direction node direction value', or a row of the matrix"
        )
    if len(lines[0]) == 3:
        rows, columns = (np.array([int(line[k]) - 1 for line in lines]) for k in (0, 1))
        if min(rows.min(), columns.min()) < 0 or max(rows.max(), columns.max()) >= len(labels):
            raise ValueError(f"rows and columns count from 1 to {len(labels)}, as the lines of the table of nodes do")
    else:
        number = {label: i for i, label in enumerate(labels)}
        rows, columns = (
            np.array([_row((line[k], SPELLINGS.get(line[k + 1].lower(), "")), number) for line in lines])
            for k in (0, 2)
        )
    values = np.array([float(line[-1].replace("D", "E").replace("d", "e")) for line in lines])
    matrix = sparse.coo_array((values, (rows, columns)), shape=(len(labels), len(labels))).tocsr()
    upper, lower = sparse.triu(matrix, 1), sparse.tril(matrix, -1)
    if not (upper.nnz and lower.nnz):
        matrix = matrix + (upper + lower).T
    return {"": matrix}


FORMATS: dict[str, Callable[[Path, list[tuple[str, str]]], dict[str, Sparse]]] = {
    **dict.fromkeys((".op4", ".pch", ".dmig"), _nastran),
    **dict.fromkeys((".hb", ".rb", ".rsa", ".rua", ".matrix"), _harwell_boeing),
    ".npz": _npz,
    ".mat": _mat,
    **dict.fromkeys((".mtx", ".mmf", ".txt", ".csv", ".dat"), _triplets),
}


def _refuse_impossible(given: Given) -> None:
    """Matrices that no rotor has."""
    for way in ("ux", "uy"):
        if way not in given.ways:
            text = f"no row is {way}; positions count along the axis of the rotor, z, and across it are x and y"
            raise MachineError(text, ("nodes",))
    for name, matrix in given.matrices.items():
        sign, word = (1.0, "antisymmetric") if name == "gyroscopic" else (-1.0, "symmetric")
        apart = abs(matrix + sign * matrix.T).tocoo()
        if apart.nnz and apart.max() > SYMMETRIC * abs(matrix).max():
            row, column = (int(side[apart.data.argmax()]) for side in apart.coords)
            raise MachineError(
                f"is not {word}: entries {row + 1}, {column + 1} and {column + 1}, {row + 1} differ by {apart.max():.3g}, "
                f"its greatest is {abs(matrix).max():.3g}; {SKEW[word]}",
                (name,),
            )
    mass, stiffness = given.matrices["mass"].diagonal(), given.matrices["stiffness"].diagonal()
    if not mass.any():
        raise MachineError("is zero", ("mass",))
    for name in {"mass", "damping"} & set(given.matrices):
        own, matrix = given.matrices[name].diagonal(), given.matrices[name].tocoo()
        for wrong in np.flatnonzero(own < 0.0):
            raise MachineError(f"is negative in row {_row_text(given, wrong)}; {ENERGY[name]}", (name,))
        # of motions of two rows together: m_ij^2 <= m_ii m_jj
        limit = np.sqrt(own[matrix.coords[0]] * own[matrix.coords[1]])
        for wrong in np.flatnonzero(np.abs(matrix.data) > limit * (1.0 + SYMMETRIC) + ROUNDING * own.max()):
            row, column = (int(side[wrong]) for side in matrix.coords)
            raise MachineError(
                f"entry {row + 1}, {column + 1} is {matrix.data[wrong]:.4g}, more than the entries {own[row]:.4g} and "
                f"{own[column]:.4g} of its rows on the diagonal allow; {ENERGY[name]}",
                (name,),
            )
    for wrong in np.flatnonzero((stiffness == 0.0) & (mass == 0.0)):
        raise MachineError(f"row {_row_text(given, wrong)}, has neither mass nor stiffness; leave it out", ("mass",))
    _refuse_strained(given)


def _row_text(given: Given, row: Any) -> str:
    return f"{row + 1}, {given.ways[row]} of node {given.nodes[row]}"


def _refuse_strained(given: Given) -> None:
    """Rows that do not fit each other: a motion of the whole has inertia, and strains nothing but what holds the rotor.

    Of each row the force is compared with the sum of the sizes of its parts: it is as great where all act along one
    direction, and zero where they cancel, as on a free node. Nodes that are held are few, so the median over the rows tells.
    """

    def share(forces: Matrix, sizes: Matrix) -> float:
        return float(np.median(np.abs(forces[sizes > 0.0]) / sizes[sizes > 0.0])) if sizes.any() else 0.0

    mass, stiffness = given.matrices["mass"], given.matrices["stiffness"].tocoo()
    rows, columns = stiffness.coords
    for u, r, sign in (("ux", "ry", 1.0), ("uy", "rx", -1.0)):
        across, turning = given.ways == u, given.ways == r
        if share((mass @ across)[across], (abs(mass) @ across)[across]) < FREE:
            text = f"has no inertia at most nodes as the whole moves along {u[1]}, which is so of a stiffness; exchange M and K"
            raise MachineError(text, ("mass",))
        nodes = [sorted(np.array(given.nodes)[chosen]) for chosen in (across, turning)]
        moved = (stiffness @ across)[across], (abs(stiffness) @ across)[across]
        if nodes[0] != nodes[1] or share(*moved) > FREE:
            continue  # nodes without rotations, or held almost everywhere
        arms = (given.positions[columns] - given.positions[rows]) * across[columns]
        moments, angles = (
            np.bincount(rows, stiffness.data * motion, given.ways.size)[turning]
            for motion in (arms, sign * turning[columns])
        )
        if share(moments + angles, np.abs(moments) + np.abs(angles)) > STRAINED:
            times = float(np.median(-moments[angles != 0.0] / angles[angles != 0.0]))
            hint = next((text for low, high, text in TURNED if low < times < high), "")
            raise MachineError(
                f"bends most nodes as the whole turns, {r} = 1 rad, where a free body has no strain; it has none with "
                f"{times:.4g} rad. {hint}Look at length_unit, and at the unit and the order of the lines of 'nodes'",
                ("stiffness",),
            )


def _polar_inertia(given: Given) -> float:
    """Of the whole, from the gyroscopic moment of a rotation about y on one about x."""
    if "gyroscopic" not in given.matrices:
        return 0.0
    mass, along = given.matrices["mass"], (given.ways == "ux").astype(np.float64)
    middle = float(along @ (mass @ (along * given.positions)) / (along @ (mass @ along)))  # the mass center
    height = given.positions - middle
    about_x = np.where(given.ways == "rx", 1.0, np.where(given.ways == "uy", -height, 0.0))
    about_y = np.where(given.ways == "ry", 1.0, np.where(given.ways == "ux", height, 0.0))
    inertia, across = float(about_x @ (given.matrices["gyroscopic"] @ about_y)), float(about_y @ (mass @ about_y))
    if inertia < 0.0:
        raise MachineError(
            "turns the wrong way: its polar inertia is negative, so it is for a rotor that turns about -z, or 'nodes' has "
            "the rows in another order; change its sign",
            ("gyroscopic",),
        )
    if inertia > 2.0 * across * (1.0 + 1e-6):
        raise MachineError(
            f"its polar inertia is {inertia:.4g} kg m^2, and no body has more than twice its transverse inertia, "
            f"{2.0 * across:.4g} here; it must be the matrix at 1 rad/s, not times a speed",
            ("gyroscopic",),
        )
    return inertia


# Fewer coordinates.


def _kept(keep: Sequence[float], given: Given) -> NDArray[np.bool_]:
    """Rows of the nodes that are kept, of motions across the axis that have mass."""
    kept = np.zeros(given.ways.size, np.bool_)
    for number, place in enumerate(keep):
        near = given.positions[_nearest(given.positions, float(place), ("keep", number))]
        kept |= np.abs(given.positions - near) <= 1e-6 * np.ptp(given.positions)
    heavy = np.asarray(given.matrices["mass"].diagonal() > 0.0, np.bool_)
    return kept & heavy & np.isin(given.ways, ("ux", "uy", "rx", "ry"))


def _craig_bampton(
    given: Given, kept: NDArray[np.bool_], modes: int
) -> tuple[Matrix, list[str], list[float], str, float]:
    """The basis (N, R), what its columns are, where, what is said of it, and up to which frequency it is right, rad/s."""
    planes = [np.flatnonzero(np.isin(given.ways, ways)) for ways in (("ux", "ry"), ("uy", "rx"))]
    across = np.concatenate(planes)
    rest = np.setdiff1d(np.arange(given.ways.size), across)
    apart = all(
        _coupling(matrix, *pair) <= LOOSE
        for name, matrix in given.matrices.items()
        for pair in ((planes[0], planes[1]), (across, rest))
        if name != "gyroscopic" or pair[1] is rest
    )
    groups = [(planes[0], "modal x"), (planes[1], "modal y")] if apart else [(np.arange(given.ways.size), "modal")]
    bases, ways, positions, top = [], [], [], np.inf
    for group, word in groups:
        basis, frequency = _fixed_interface(given, group[kept[group]], group[~kept[group]], modes)
        bases.append(basis)
        top = min(top, frequency)
        ways += [*given.ways[group[kept[group]]], *[word] * (basis.shape[1] - int(kept[group].sum()))]
        positions += [*given.positions[group[kept[group]]], *[np.nan] * (basis.shape[1] - int(kept[group].sum()))]
    basis = np.hstack(bases)
    end = _valid_to(given, basis, np.flatnonzero(kept & np.isin(given.ways, ("ux", "uy"))), top / 2.0)
    sizes = f"{given.ways.size} to {basis.shape[1]} coordinates"
    said = f"receptance of the kept nodes within 1 % up to {end / (2.0 * np.pi):.4g} Hz" if end else "too few modes"
    note = f"Craig-Bampton, {sizes}; {said}" if np.isfinite(end) else f"all {given.ways.size} coordinates"
    return basis, ways, positions, note, end


def _coupling(matrix: Sparse, one: NDArray[np.int64], other: NDArray[np.int64]) -> float:
    """Greatest entry between two groups of rows, over the greatest of all."""
    return float(abs(matrix[one][:, other]).max() / max(abs(matrix).max(), 1e-300)) if one.size and other.size else 0.0


def _fixed_interface(
    given: Given, outside: NDArray[np.int64], inside: NDArray[np.int64], modes: int
) -> tuple[Matrix, float]:
    """Static shapes of the kept rows and modes of the others with these held, (N, r), and the next frequency, rad/s."""
    from scipy.sparse.linalg import LinearOperator, eigsh, splu

    mass, stiffness = given.matrices["mass"], given.matrices["stiffness"]
    count = min(modes, int(np.count_nonzero(mass.diagonal()[inside])))
    basis = np.zeros((given.ways.size, outside.size + count))
    basis[outside, np.arange(outside.size)] = 1.0
    if not inside.size:
        return basis, np.inf
    held = stiffness[inside][:, inside].tocsc()
    try:
        factor = splu(held)
        soft = np.abs(factor.U.diagonal()).min() < 1e-13 * np.abs(factor.U.diagonal()).max()
    except RuntimeError:
        soft = True
    if soft:
        raise MachineError(
            "the rotor can move while these nodes are held; keep more nodes, or hold its rotation about z in its program",
            ("keep",),
        )
    basis[np.ix_(inside, np.arange(outside.size))] = -factor.solve(stiffness[inside][:, outside].toarray())
    # of the greatest shares 1/w^2 of M over K; rows without mass have none
    heavy, inner = int(np.count_nonzero(mass.diagonal()[inside])), mass[inside][:, inside].tocsc()
    if count + 1 >= heavy or 2 * count >= inside.size:
        from scipy.linalg import eigh

        shares, shapes = eigh(inner.toarray(), held.toarray())
    else:
        start = np.random.default_rng(0).standard_normal(inside.size)  # no symmetry, and the same at each reading
        shares, shapes = eigsh(inner, count + 1, held, Minv=LinearOperator(held.shape, matvec=factor.solve), v0=start)
    order = np.argsort(shares)[::-1][: min(count + 1, heavy)]
    squares, shapes = 1.0 / shares[order], shapes[:, order] / np.sqrt(shares[order])  # of mass one
    basis[np.ix_(inside, np.arange(outside.size, outside.size + count))] = shapes[:, :count]
    return basis, float(np.sqrt(squares[count])) if count < squares.size else np.inf


def _valid_to(given: Given, basis: Matrix, places: NDArray[np.int64], top: float) -> float:
    """Frequency, rad/s, up to which the receptances of kept deflections are right within 1 %, looked at up to ``top``."""
    from scipy.sparse.linalg import splu

    mass, stiffness = given.matrices["mass"].tocsc(), given.matrices["stiffness"].tocsc() * (1.0 + 1j * LOSS)
    small_mass, small_stiffness = basis.T @ (mass @ basis), basis.T @ (stiffness @ basis)
    valid = 0.0 if np.isfinite(top) else top
    forces = np.zeros((given.ways.size, places.size), np.complex128)
    forces[places, np.arange(places.size)] = 1.0
    for frequency in np.linspace(0.0, top, FREQUENCIES + 1)[1:] if np.isfinite(top) else ():
        whole = splu((stiffness - frequency**2 * mass).tocsc()).solve(forces)[places]
        reduced = basis[places] @ np.linalg.solve(small_stiffness - frequency**2 * small_mass, basis[places].T)
        if np.abs(whole - reduced).max() > GOOD * np.abs(whole).max():
            break
        valid = float(frequency)
    return valid


# Modes with their shapes, from a table with a line for each or from a universal file: columns by keys of a resonance.


MODES = "frequency [Hz], damping ratio [%], mass [kg], x at 0 mm, x at 180 mm"
ALIKE = 1e-3  # difference of two shapes, of their size, below which they are one
DOUBLE = 1e-4  # of two frequencies
UNITS = {"frequency": "rad/s", "mass": "kg"}
SHAPES = {"x": "shape", "y": "shape_y", "slope": "slope", "slope of x": "slope", "slope of y": "slope_y"}


def _modal_keys(files: ModeFiles, folder: Path) -> dict[str, Any]:
    """Positions and resonances of a rotor of the kind "modal"."""
    path = folder / files.file
    if reason := not_to_read(path):
        raise MachineFileError(f"{path}: {reason}", ("file",))
    try:
        with path.open("rb") as file:
            universal = is_universal(file.read(1024)) or path.suffix.lower() in UNIVERSAL
        places, columns = _universal_modes(path, files, folder) if universal else _table_of_modes(path)
    except (MachineFileError, ResultError, UnitError) as error:
        raise MachineFileError.of("", [(at or ("file",), text) for at, text in error.problems]) from None
    kept = np.arange(places.size)
    if files.keep is not None:
        kept = np.unique([_nearest(places, float(z), ("keep", number)) for number, z in enumerate(files.keep)])
    columns = {name: of[:, kept] if name in SHAPES.values() else of for name, of in columns.items()}
    order = np.argsort(columns["frequency"], kind="stable")[: files.modes]
    return {
        "positions": places[kept].tolist(),
        "resonances": [
            {
                name: f"{float(of[k])!r} {UNITS[name]}" if name in UNITS else of[k].tolist()
                for name, of in columns.items()
            }
            for k in order
        ],
        "source": f"{files.file}: {order.size} of {columns['frequency'].size} modes",
    }


def _nearest(places: Matrix, place: float, key: tuple[str | int, ...]) -> int:
    """Which of the places of nodes is there."""
    number = int(np.abs(places - place).argmin())
    if abs(places[number] - place) > 1e-6 * max(float(np.ptp(places)), 1e-9):
        raise MachineError(
            f"no node is at {place:.6g} m; the nearest is at {places[number]:.6g} m, and all are from {places.min():.6g} to "
            f"{places.max():.6g} m",
            key,
        )
    return number


def _table_of_modes(path: Path) -> tuple[Matrix, dict[str, Matrix]]:
    """A line for each mode; columns such as `x at 12 mm`, `slope at 12 mm [1/m]`, `y at ...`, `slope of y at ...`."""
    table = read_table(path, MODES, error=MachineFileError)
    ratio = "damping_ratio" if "damping_ratio" in table.heads else "damping ratio"
    columns = {"frequency": table.numbers("frequency", "rad/s"), "damping_ratio": table.numbers(ratio, "")}
    if "mass" in table.heads:
        columns["mass"] = table.numbers("mass", "kg")
    shapes: dict[str, dict[float, Matrix]] = {"shape": {}}
    for name in table.heads:
        what, at, place = name.partition(" at ")
        if at and what in SHAPES:
            shapes.setdefault(SHAPES[what], {})[to_si(place, "m")] = table.numbers(
                name, "1/m" if "slope" in what else ""
            )
    places = sorted(shapes["shape"])
    for key, of in shapes.items():
        if not places or sorted(of) != places:
            raise MachineFileError(f"{path}: no {key} at the same places as x; name the columns such as: {MODES}")
        columns[key] = np.column_stack([of[z] for z in places])
    if parts := [table.numbers(name, "") for name in ("participation", "participation of y") if name in table.heads]:
        columns["participation"] = np.column_stack(parts)
    return np.array(places), columns


def _universal_modes(path: Path, files: ModeFiles, folder: Path) -> tuple[Matrix, dict[str, Matrix]]:
    """Modes of a universal file, at the nodes that are known."""
    found = read_universal_modes(path.read_bytes(), path.name)
    if not found.modes:
        raise MachineFileError(f"{path}: has no mode (data set 55, normal or complex)")
    length, mass = found.units or (0.0, 0.0)
    length = LENGTHS[files.length_unit] if files.length_unit else length
    mass = MASSES[files.mass_unit] if files.mass_unit else mass
    for value, key in ((length, "length_unit"), (mass, "mass_unit")):
        if not value:
            raise MachineFileError("missing; the file has no units (data set 164)", (key,))
    places = {node: length * place[2] for node, place in found.nodes.items()}
    if files.nodes is not None:
        table = read_table(folder / files.nodes, "node, position [mm]", error=MachineFileError)
        places = dict(zip(table.texts("node"), table.numbers("position", "m").tolist(), strict=True))
    common = set(places).intersection(*(mode.nodes for mode in found.modes))
    if not common:
        raise MachineFileError(f"{path}: no node of all its modes has a position; give a table of them", ("nodes",))
    nodes = sorted(common, key=lambda node: places[node])
    motions = np.array([mode.motions[[mode.nodes.index(node) for node in nodes]] for mode in found.modes])
    numbers = np.array([(mode.frequency, mode.damping_ratio, mass * mode.mass) for mode in found.modes]).T
    columns = dict(zip(("frequency", "damping_ratio", "mass"), numbers, strict=True))
    columns |= {"shape": motions[:, :, 0], "shape_y": motions[:, :, 1]}
    if motions.shape[2] == 6 and motions[:, :, 3:5].any():
        columns |= {"slope": motions[:, :, 4] / length, "slope_y": -motions[:, :, 3] / length}
    return np.array([places[node] for node in nodes]), _round_modes(columns)


def _round_modes(columns: dict[str, Matrix]) -> dict[str, Matrix]:
    """Modes along x and y alike, where they come in pairs of one shape, or were measured along one direction alone."""
    keys = [key for key in ("shape", "slope") if key in columns]
    numbers = {key: columns[key] for key in ("frequency", "damping_ratio", "mass")}
    size = [float(np.abs(columns[key]).max()) for key in ("shape", "shape_y")]
    if min(size) < ALIKE * max(size):
        return numbers | {key: columns[key + "_y" * (size[1] > size[0])] for key in keys}
    order = np.argsort(columns["frequency"], kind="stable")
    x, y = (
        np.hstack([columns[key + end] for key in keys])[order] * numbers["mass"][order, None] ** -0.5
        for end in ("", "_y")
    )  # of mass one
    frequency, first = columns["frequency"][order], order[::2]
    if order.size % 2 or np.ptp(frequency.reshape(-1, 2), axis=1).max() > DOUBLE * frequency[-1]:
        return columns
    _, sizes, right = np.linalg.svd(np.stack([x[::2], x[1::2], y[::2], y[1::2]], axis=1))
    if (sizes[:, 1] > ALIKE * sizes[:, 0]).any():
        return columns
    shapes = np.split(right[:, 0] * sizes[:, :1] / np.sqrt(2.0), len(keys), axis=1)
    return (
        {key: of[first] for key, of in numbers.items()}
        | {"mass": np.ones(first.size)}
        | dict(zip(keys, shapes, strict=True))
    )
