"""Run AUTO-07p on ``balls.f90`` and print its special points, the targets of :mod:`reproductions.auto07p.continuation`.

    AUTO_DIR=/usr/lib/auto-07p FC=gfortran python -m reproductions.auto07p._run

AUTO-07p 0.9.2 is in Debian as ``auto-07p``; besides it a Fortran compiler and libgfortran are needed. The package itself needs
neither of them, nor does ``make reproduce``, which compares with the printed numbers.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from autobalancer.files.machine_file import load_race_machine
from autobalancer.stability.stalled_orbits import stalled_orbits
from autobalancer.stability.steady_curves import Family, Range

HERE = Path(__file__).resolve().parent
STALL = HERE.parents[1] / "examples" / "machines" / "stall_and_release.toml"
NAMES = {
    2: "fold",
    3: "Hopf",
    5: "fold",
    7: "period doubling",
    8: "torus",
    9: "end",
    39: "end",
    -32: "Bautin",
    -34: "user",
    32: "Bautin",
}
COMMON = """
NTST={mesh}, NCOL=4, IAD=3, ISP=2, IPLT=0, NMX=4000, NPR=20000, MXBF=0, IID=2, ITMX=12, ITNW=9, NWTN=5, JAC=0, ILP=1
IADS=1, NPAR=12, THU={{}}, EPSL={fine}, EPSU={fine}, EPSS={search}
"""
HOPF = "NDIM=8, IPS=1, IRS=0, ISW=1, ICP=[1], NBC=0, NINT=0, DS=-0.05, DSMIN=1e-5, DSMAX=0.5, RL0=260, RL1=310, STOP=['HB1']"
SWING = (
    "NDIM=8, IPS=2, IRS=2, ISW=1, ICP=[1,11], NBC=0, NINT=0, DS=0.02, DSMIN=1e-5, DSMAX=0.05, THL={11:0}, RL0=260, RL1=310, "
    "STOP=['LP4']"
)
CURVE = (
    "NDIM=8, IPS=1, IRS=2, ISW=2, ICP=[1,3], NBC=0, NINT=0, DS=%s, DSMIN=1e-6, DSMAX=0.1, RL0=255, RL1=290, "
    "UZR={3:[5e-5,2e-4,5e-4]}"
)
STALLED = (
    "dat='stall.dat', NDIM=6, IPS=4, IRS=0, ISW=1, ICP=[1,11], PAR={11:%.10f}, NBC=6, NINT=1, DS=%s, DSMIN=1e-5, DSMAX=0.5, "
    "RL0=240, RL1=500, STOP=['LP4']"
)


def main() -> int:
    """Compile, run all and print."""
    auto, compiler = Path(os.environ.get("AUTO_DIR", "/usr/lib/auto-07p")), os.environ.get("FC", "gfortran")
    if not (auto / "lib" / "main.o").is_file():
        print(f"no AUTO-07p in {auto}; set AUTO_DIR to its folder")
        return 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        objects = sorted(str(path) for path in (auto / "lib").glob("*.o"))
        build = [
            compiler,
            "-O2",
            "-fopenmp",
            "-J",
            name,
            str(HERE / "balls.f90"),
            *objects,
            "-o",
            str(folder / "balls"),
        ]
        subprocess.run(build, check=True)
        run(folder, "Hopf point of the balanced state", HOPF, "")
        hopf = (folder / "fort.8").read_text()
        run(folder, "balls that swing", SWING, hopf, mesh=60, fine=1e-10, search=1e-8)
        for way in ("-0.01", "0.01"):
            run(folder, "Hopf points over the drag", CURVE % way, hopf)
        run(
            folder,
            "the same, loosely, for the Bautin point",
            CURVE % "-0.01",
            hopf,
            fine=1e-9,
            search=1e-5,
        )
        period = stalled_start(folder / "stall.dat")
        for way in ("0.05", "-0.05"):
            start = (folder / "stall.dat").read_text()
            run(folder, "stalled balls", STALLED % (period, way), start, mesh=120, fine=1e-9, search=1e-7)
    return 0


def run(
    folder: Path, title: str, constants: str, restart: str, mesh: int = 40, fine: float = 1e-11, search: float = 1e-9
) -> None:
    """One run: type, PAR(1) and the last printed column (period in 1/w_c, or the drag) of every special point."""
    text = constants + COMMON.format(mesh=mesh, fine=fine, search=search)
    (folder / "fort.2").write_text(text)
    (folder / "fort.3").write_text(restart)
    subprocess.run([str(folder / "balls")], cwd=folder, check=True, capture_output=True)
    print(title)
    for line in (folder / "fort.7").read_text().splitlines():
        cells = line.split()
        if cells[0] != "0" and int(cells[2]) != 0:
            print(f"  {NAMES.get(int(cells[2]), cells[2]):16} {cells[4]:>18} {cells[-1]:>18}")


def stalled_start(path: Path) -> float:
    """One turn of the stalled balls at 300 rad/s as a first guess; returns the period in 1/w_c."""
    problem, u = next(
        stalled_orbits(Range(Family(load_race_machine(STALL), ["speed"]), 300.0, 301.0), ((0, 1),), 0.0, 60)
    )
    period = problem.period(u)
    turn = problem.mesh.interpolated(problem.states(u) * problem.scale, np.linspace(0.0, 1.0, 2001))
    turn[:, 4] -= 2.0 * np.pi * np.round(turn[0, 4] / (2.0 * np.pi))
    scaled = turn / np.array([1e-3, 1e-3, 0.25, 0.25, 1.0, 250.0])
    np.savetxt(path, np.column_stack([np.linspace(0.0, 1.0, 2001), scaled]), fmt="%.15e")
    return 250.0 * period


if __name__ == "__main__":
    sys.exit(main())
