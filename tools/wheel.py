"""A wheel that carries its kernels, compiled for a level of processors; and the proof that nothing compiles from it.

``python -m tools.wheel build``
    The source distribution, and from it a wheel for this Python, both in ``dist``. Kernels are compiled by two processes, which
    then run all commands of :func:`questions` for every sample machine: what they call for is in the wheel, whatever it is.
``python -m tools.wheel prove``
    Installs the wheel into an empty environment that cannot be written, and runs the same commands there, by a user without a
    home and without a compiler. It ends with an error if anything is compiled.

What a processor must have is passed to Numba in the environment of these processes; nobody else's Numba is changed.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import os
import pickle
import platform
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import time
from collections.abc import Callable, Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
BUILD, DIST = ROOT / "build" / "wheel", ROOT / "dist"
LEVEL = "x86-64-v3"  # processors since 2013 (Intel Haswell) and 2015 (AMD Excavator)
FEATURES = "avx avx2 bmi bmi2 cx16 f16c fma lzcnt movbe popcnt sahf sse3 sse4.1 sse4.2 ssse3 xsave"
KERNELS = f"{sys.implementation.cache_tag}-{LEVEL}"  # where the next build finds what has not changed
LARGEST = 60e6  # bytes of a wheel
PROCESSES = 2
CHAMBERS = ("chamber_cylinders", "deep_chamber", "deep_chamber_fitted", "released_body", "single_layer")
WITHOUT_DAMPING = ("disk_like_rotor", "rigid_rotor", "rubber", "two_plane_rotor")  # their supports or rubber have it
RACES = ("borders", "map", "basin", "ensemble", "stepped-response")
REFUSED = {  # what a command must answer where it knows no answer; it must give one to all other questions
    **{(name, command): "for balls in races" for name in CHAMBERS for command in RACES},
    **{("liquid_ring", command): "does not know liquid with a free surface" for command in ("simulate", *RACES)},
    ("liquid_ring", "basin"): "the machine has no balls",
    ("equilibrium_angle", "basin"): "the rotor has no unbalance",
}


def questions(name: str) -> Iterator[list[str]]:
    """Commands for one sample machine, short where their length does not matter; those of ``REFUSED`` are refused."""
    file = f"{name}.toml"
    yield ["example", name]
    yield ["check", file]
    yield ["simulate", file, "--out", f"{name}.nc"]
    if (name, "simulate") not in REFUSED:
        yield ["run-measures", f"{name}.nc"]
    yield ["borders", file]
    second = "rotor.mass=4 kg:5 kg:3" if name in WITHOUT_DAMPING else "damping=50 N*s/m:100 N*s/m:3"
    yield ["map", file, "--x", "speed=40 rad/s:80 rad/s:3", "--y", second]
    yield ["basin", file, "--speed", "900 rpm", "--random", "2", "--hold", "1 s"]
    yield ["ensemble", file, "--seeds", "2", "--duration", "0.5 s", "--out", f"{name}_ensemble.nc"]
    speeds = ["--speeds", "300 rpm:600 rpm:2", "--dwell", "0.5 s", "--window", "0.2 s"]
    yield ["stepped-response", file, *speeds, "--out", f"{name}_stepped.nc"]


def build() -> Path:
    """The wheel of the sources, and beside it their source distribution."""
    if platform.machine() not in {"x86_64", "AMD64"}:
        sys.exit(
            f"kernels are compiled for {LEVEL}; this processor is {platform.machine()}: pip wheel makes a wheel without"
        )
    shutil.rmtree(BUILD / "source", ignore_errors=True)
    subprocess.run([sys.executable, "-m", "build", "--sdist", "--outdir", BUILD / "source"], cwd=ROOT, check=True)
    (archive,) = (BUILD / "source").glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        packed.extraction_filter = getattr(tarfile, "data_filter", None)  # Python 3.11 has it from 3.11.4 on
        packed.extractall(BUILD / "source")
    source = archive.with_name(archive.name.removesuffix(".tar.gz"))
    shutil.rmtree(BUILD / "notes", ignore_errors=True)
    (BUILD / "notes").mkdir()
    shares = [_in_build(source, "compile", str(share), str(BUILD / "notes")) for share in range(PROCESSES)]
    if {share.wait() for share in shares} != {0} or _in_build(source, "ship", str(BUILD / KERNELS)).wait():
        sys.exit("the kernels were not compiled")
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    # no file is linked against the system, so any Linux on which Numba can be installed will do
    where = sysconfig.get_platform().replace("linux", "manylinux_2_17").replace("-", "_").replace(".", "_")
    (source / "setup.cfg").write_text(f"[bdist_wheel]\npython_tag = {tag}\nplat_name = {where}\n", encoding="utf-8")
    subprocess.run([sys.executable, "-m", "build", "--wheel", "--outdir", BUILD / "source"], cwd=source, check=True)
    (wheel,) = (BUILD / "source").glob("*.whl")
    if wheel.stat().st_size > LARGEST:
        sys.exit(f"{wheel.name} has {wheel.stat().st_size / 1e6:.1f} MB, at most {LARGEST / 1e6:g} MB are allowed")
    DIST.mkdir(exist_ok=True)
    for made in (archive, wheel):
        shutil.copy(made, DIST)
        print(f"dist/{made.name}: {made.stat().st_size / 1e6:.1f} MB")
    return DIST / wheel.name


def prove(wheel: Path) -> None:
    """Ask all questions from the wheel alone; ends with an error if a kernel is compiled or one is not answered as it must be."""
    with TemporaryDirectory(prefix="autobalancer-wheel-") as place:
        folder = Path(place)
        folder.chmod(0o755)
        subprocess.run([sys.executable, "-m", "venv", folder / "empty"], check=True)
        python = folder / "empty" / ("Scripts" if os.name == "nt" else "bin") / "python"
        # by itself: what PYTHONPATH holds would pass for installed
        quiet = ["-I", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--only-binary", ":all:"]
        subprocess.run([python, *quiet, wheel], check=True)
        for path in [folder / "empty", *(folder / "empty").rglob("*")]:
            if not path.is_symlink():
                path.chmod(path.stat().st_mode & ~0o222)
        try:
            _ask_all(python, folder)
        finally:
            for path in [folder / "empty", *(folder / "empty").rglob("*/")]:
                path.chmod(0o755)


def _ask_all(python: Path, folder: Path) -> None:
    shutil.copy(__file__, folder / "wheel.py")
    (folder / "work").mkdir()
    nowhere = str(folder / "empty" / "home")
    told = {"PATH": str(python.parent), "HOME": nowhere, "TMPDIR": str(folder / "work"), "OPENBLAS_NUM_THREADS": "1"}
    alone: dict[str, Any] = {"cwd": folder / "work", "env": told, "preexec_fn": _as_anybody}
    ask = [str(python), "-I", str(folder / "wheel.py"), "ask"]
    shares = [subprocess.Popen([*ask, str(share)], **alone) for share in range(PROCESSES)]
    if {share.wait() for share in shares} != {0}:
        sys.exit("a command compiled, failed, or refused what it must not: see above")
    start = time.perf_counter()
    question = ["simulate", "stall_and_release.toml", "--out", "again.nc"]
    subprocess.run([python.with_name("autobalancer"), *question], check=True, stdout=subprocess.DEVNULL, **alone)
    print(f"nothing was compiled; a simulate takes {time.perf_counter() - start:.1f} s")


def _as_anybody() -> None:
    """Root may write what is read-only; a process that gives this right up may not."""
    libc = ctypes.CDLL(None)
    for right in range(64):
        libc.prctl(24, right, 0, 0, 0)  # PR_CAPBSET_DROP: what it starts has none


def ask(share: int) -> None:
    """Ask the questions of every second machine in the working folder; ends with 1 if one compiles, fails or refuses wrongly."""
    from numba.core import event

    import autobalancer as ab
    from autobalancer.__main__ import main

    compiled: list[str] = []

    class Listener(event.Listener):
        def on_start(self, event: event.Event) -> None:
            kernel = event.data["dispatcher"].py_func
            compiled.append(f"{kernel.__module__}.{kernel.__qualname__}")

        def on_end(self, event: event.Event) -> None:
            pass

    event.register("numba:compile", Listener())  # type: ignore[no-untyped-call]
    wrong = 0
    for name in ab.catalog.examples()[share::PROCESSES]:
        for question in questions(name):
            before, start = len(compiled), time.process_time()
            code, said = _answer(main, question)
            refusal = REFUSED.get((name, question[0]), "")
            as_it_must = (code, refusal in said) == (2 if refusal else 0, True)
            wrong += not as_it_must
            new = f"; compiled {' '.join(compiled[before:])}" if compiled[before:] else ""
            told = (
                f"exit {code}{'' if as_it_must else ', WHICH IS WRONG'}, {time.process_time() - start:.1f} s{said}{new}"
            )
            print(f"{name} {question[0]}: {told}", file=sys.stderr, flush=True)
    sys.exit(bool(compiled or wrong))


def compile_share(share: int, notes: Path) -> None:
    """In a build process: compile kernels in turns with the other one, then what samples call for beyond them."""
    import_module("tests.references.compiled").compile_in_turns(notes)
    with TemporaryDirectory() as work, chdir(work), suppress(SystemExit):
        ask(share)


def ship(kernels: Path) -> None:
    """In a build process: put the kernels that fit the sources into the package."""
    from autobalancer.kernels.compiler import cache

    stamps = {cache.stamp_of(path) for path in cache.HERE.parent.rglob("*.py")}
    print(f"{gather(kernels, cache.SHIPPED, stamps)} files with kernels for {LEVEL}", flush=True)


def gather(kernels: Path, folder: Path, stamps: set[str]) -> int:
    """Copy kernels of sources with these stamps into a folder, with what they are made for; the number of their files."""
    import numba
    from numba.core.registry import cpu_target

    from autobalancer.kernels.compiler import cache

    folder.mkdir()
    hashes: dict[str, str] = {}
    for index in sorted(kernels.rglob("*.nbi")):
        with index.open("rb") as file:
            version, (stamp, files) = pickle.load(file), pickle.load(file)
        if version != numba.__version__ or stamp not in stamps:
            continue
        for name in {index.name, *files.values()}:
            if name in hashes:
                sys.exit(f"two kernels have the name {name}; give one of them another name")
            content = index.with_name(name).read_bytes()
            hashes[name] = hashlib.sha256(content).hexdigest()
            (folder / name).write_bytes(content)
    processor = cpu_target.target_context.codegen().magic_tuple()
    told = {"processor": processor, "made with": cache.compiler_versions(), "sha256": hashes}
    (folder / cache.LIST).write_text(json.dumps(told, indent=0), encoding="utf-8")
    return len(hashes)


def _in_build(source: Path, *command: str) -> subprocess.Popen[bytes]:
    """A process for which a processor of the level is this one."""
    told = {
        "PYTHONPATH": os.pathsep.join([str(source / "src"), str(source)]),
        "NUMBA_CPU_NAME": LEVEL,
        "NUMBA_CPU_FEATURES": ",".join(f"+{name}" for name in FEATURES.split()),
        "NUMBA_DISABLE_INTEL_SVML": "1",
        "NUMBA_CACHE_DIR": str(BUILD / KERNELS),
        "MPLBACKEND": "Agg",
        "OPENBLAS_NUM_THREADS": "1",
    }
    return subprocess.Popen([sys.executable, "-m", "tools.wheel", *command], cwd=source, env=os.environ | told)


def _answer(main: Callable[[], None], question: list[str]) -> tuple[Any, str]:
    """The exit code of a command, and what it says if that is not 0."""
    sys.argv = ["autobalancer", *question]
    code: Any = 0
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere), redirect_stderr(StringIO()) as told:
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
    return code, f": {' '.join(told.getvalue().split())}" if code else ""


if __name__ == "__main__":
    task, *given = sys.argv[1:] or ["build"]
    if task == "build":
        prove(build())
    elif task == "prove":
        prove(Path(given[0]) if given else next(DIST.glob("*-none-*.whl")))
    elif task == "ask":
        ask(int(given[0]))
    elif task == "compile":
        compile_share(int(given[0]), Path(given[1]))
    elif task == "ship":
        ship(Path(given[0]))
