"""A machine for other programs: its compiled equations, steps and numbers as a library in C, or as an FMU around it.

The library has no Python in it. Its kernels are those of a run, written out by ``kernels/compiler/object_code.py``; the numbers
of the machine, with all work space, are one block of memory in which pointers are the only words to be put right
(:class:`Image`), so that one library serves any number of machines and threads, and a copy of the block is a saved state.
What a parameter of the machine file changes in these numbers is found by changing it (:func:`parameters_of`).
"""

from __future__ import annotations

import importlib.util
import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
import uuid
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from autobalancer.assembly.number_block import WORD, Image, Known, length_of, parameters_of
from autobalancer.assembly.places import Places, desk_for, gauges_of, places_of
from autobalancer.assembly.system import MASS_SPREAD, Assembly, assemble
from autobalancer.errors import QuestionError, one_of
from autobalancer.files.fmi_description import Description, write_unit
from autobalancer.files.machine_file import balls_in_races
from autobalancer.kernels.balls.element import element
from autobalancer.kernels.balls.race_events import adherence, impacts_and_adherence, rigid_contact
from autobalancer.kernels.compiler.object_code import function_at, intermediate_code, object_code
from autobalancer.kernels.integrators.integrator_state import switch_type
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.integrators.runge_kutta import advance
from autobalancer.kernels.measures.observables import observe
from autobalancer.kernels.measures.workspace import MeasureInputs, Workspace
from autobalancer.kernels.records import LINEAR
from autobalancer.kernels.system import SPEED, THETA, rhs_type
from autobalancer.machine import Machine, PrescribedSpeed, TargetTorque
from autobalancer.results.labels import LABELS, Variable
from autobalancer.safe_file import as_path, write_safely
from autobalancer.simulation import ONE_RUN, run_duration, run_options
from autobalancer.simulation.balancer_element import balancer_element
from autobalancer.simulation.fluid_lag import fluid_lags
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import Stepper, stepper_for
from autobalancer.units import shortened

LEAST_ADDRESS = 4096
CHANGING = (
    "memory.clock", "memory.counts", "memory.state", "system.drive.now", "system.guided", "system.ties", "system.rigid.bound",
    "system.free", "system.slips",
)  # fmt: skip
LAW = "ab_law_"
SOURCES = Path(__file__).parent / "catalog" / "data" / "exchange"


class _Options(NamedTuple):
    """How a machine is exported."""

    drive: str  # speed or torque, given from outside; empty: that of the machine
    seed: int
    tolerance: float
    duration: float  # s


AS_WRITTEN = _Options("", 0, 1e-8, 1.0)


class Prepared(NamedTuple):
    """A machine in numbers, with all that a run of it needs."""

    assembly: Assembly
    places: Places
    stepper: Stepper
    record: Record
    inputs: MeasureInputs
    desk: Workspace

    def image(self) -> Image:
        """As one block of memory."""
        return Image(
            system=self.assembly.system, record=self.record, pair=self.stepper.pair, memory=self.stepper.memory,
            inputs=self.inputs, desk=self.desk, ring=np.zeros((1, 1 + self.assembly.state.size)),
        )  # fmt: skip


def _prepared(machine: Machine, options: _Options) -> Prepared:
    lags = fluid_lags(
        machine, run_duration(machine, options.duration), seed=options.seed, max_steps=ONE_RUN["max_steps"]
    ).lags
    assembly = assemble(machine, seed=options.seed, lags=lags, mass_spread=MASS_SPREAD)
    system = assembly.system
    if options.drive:
        segments = system.drive.segments[:1].copy()
        if options.drive == "speed":
            segments.value = assembly.state[SPEED]
        segments.kind, segments.rate = LINEAR, 0.0
        system = system._replace(drive=system.drive._replace(segments=segments))
    assembly = replace(assembly, system=system)
    stepper = stepper_for(assembly, math.inf, options.tolerance, "dormand_prince_8")
    places = places_of(machine, assembly)
    inputs = gauges_of(assembly, places, centered=True)
    record = record_for([SampleTimes((0.0,))], (), assembly, 1.0)
    return Prepared(assembly, places, stepper, record, inputs, desk_for(inputs, 1))


def _image_of(machine: Machine, options: _Options = AS_WRITTEN) -> Image:
    return _prepared(machine, options).image()


class Output(NamedTuple):
    """Where a number of a run stands in the block: one word, the length of two, or their difference."""

    about: Variable
    first: int
    second: int = 0
    kind: str = "AB_NUMBER"


def _labeled(name: str, of: str = "", start: float = 0.0) -> Variable:
    its = LABELS[name]
    return Variable(f"{name}[{of}]" if of else name, its.units, its.long_name, start)


def _states(assembly: Assembly) -> list[Variable]:
    """Names of the state, in its order."""
    axes = "in axes that turn with the rotor" if assembly.system.rotating else "in space"
    n, start = assembly.system.ball_count, assembly.state
    names = [("x", "m", "deflection"), ("y", "m", "deflection"), ("vx", "m/s", "velocity"), ("vy", "m/s", "velocity")]
    about = [Variable(f"state.{name}", unit, f"{word} along {name[-1]}, {axes}") for name, unit, word in names]
    about += [_labeled("rotor_angle"), _labeled("speed")]
    about += [_labeled(name, str(i + 1)) for name in ("ball_angle_in_rotor", "ball_speed_in_rotor") for i in range(n)]
    further = range(len(about), start.size)
    about += [Variable(f"state[{k + 1}]", "1", "further coordinate, rate or state of a part") for k in further]
    return [each._replace(name=f"state.{each.name.removeprefix('state.')}", start=float(v))
            for each, v in zip(about, start, strict=True)]  # fmt: skip


def _outputs(ready: Prepared, image: Image) -> list[Output]:
    """All that a run says at one instant."""
    state, seen = image.data["memory.state"], "desk.seen"
    found = [Output(_labeled("speed"), state + SPEED), Output(_labeled("rotor_angle"), state + THETA)]

    def pairs(array: str, name: str, of: Sequence[str]) -> Iterator[Output]:
        first = image.data[f"{seen}.{array}"]
        for number, which in enumerate(of):
            for axis, part in (("x", 0), ("y", 1)):
                yield Output(_labeled(f"{name}{axis}", which), first + 2 * number + part)

    kinds = ready.places.kinds
    first = image.data[f"{seen}.z"] + 2 * (kinds.index("reference") if "reference" in kinds else 0)
    found += [Output(_labeled("x"), first), Output(_labeled("y"), first + 1)]
    found.append(Output(_labeled("deflection"), first, first + 1, "AB_LENGTH"))
    found += pairs("z", "turn_place_", ready.places.names)
    found += pairs("v", "turn_place_v", ready.places.names)
    found += pairs("force", "support_force_", ready.places.supports)
    for i in range(ready.assembly.system.ball_count):
        angle = image.data[f"{seen}.angles"] + i
        found.append(Output(_labeled("ball_angle_in_rotor", str(i + 1)), angle, state + THETA, "AB_LESS"))
    left, whole = image.data[f"{seen}.left"], image.data[f"{seen}.unbalance"]
    found += [Output(_labeled(f"turn_residual_{axis}"), left + part) for part, axis in enumerate("xy")]
    found.append(Output(_labeled("residual_unbalance"), left, left + 1, "AB_LENGTH"))
    found.append(Output(_labeled("unbalance"), whole, whole + 1, "AB_LENGTH"))
    plain = [each.about.name.replace("turn_", "") for each in found]
    return [
        each._replace(about=each.about._replace(name=name, meaning=each.about.meaning.replace(" in the last revolutions", "")
                                                .replace(", last revolutions", "")))
        for each, name in zip(found, plain, strict=True)
    ]  # fmt: skip


def _spans(ready: Prepared, image: Image) -> list[tuple[int, int]]:
    """Where the block changes in a step, work space aside, and the rates where it begins: first word and count."""
    found = [(image.data[name], length_of(image, name)) for name in CHANGING]
    return [*(span for span in found if span[1]), (image.data["memory.stages"], ready.assembly.state.size)]


def _indicators(ready: Prepared) -> int:
    """Number of indicators of events, as in ``race_events.py``: one of each ball that friction can hold, and of each contact."""
    system, switch = ready.assembly.system, ready.stepper.moving.switch
    if switch not in (adherence, impacts_and_adherence, rigid_contact):
        return 0
    balls, contacts = system.balls, system.contacts
    rubbing = ((balls.rolling > 0.0) | (balls.adherence > 0.0)).sum()
    if switch is not rigid_contact:
        return int(rubbing)
    return int(rubbing + (contacts.rigid == 1).sum() + 2 * (contacts.wall_rigid != 0).sum() + 1)


def _own_functions(image: Image) -> dict[int, Any]:
    """Laws that are called by their address, by the word where it stands."""
    found = {word: function_at(int(image.words[word])) for word in np.flatnonzero(image.words > LEAST_ADDRESS).tolist()}
    return {word: law for word, law in found.items() if law is not None and word not in image.floats}


class Content(NamedTuple):
    """What is exported: a machine, or its balls alone."""

    source: str  # in C
    image: Image
    states: list[Variable]
    outputs: list[Variable]
    inputs: list[Variable]
    numbers: dict[str, Any]  # names in C
    tables: list[str]  # in C
    kernels: dict[str, tuple[Any, Any]]


def _content_of_machine(machine: Machine, options: _Options) -> Content:
    ready = _prepared(machine, options)
    image = ready.image()
    data, starts, spans = image.data, image.starts, _spans(ready, image)
    segments, outputs = ready.assembly.system.drive.segments, _outputs(ready, image)
    numbers = {
        "STATE": data["memory.state"], "CLOCK": data["memory.clock"], "COUNTS": data["memory.counts"],
        "TRIAL": data["memory.trial"], "STAGES": data["memory.stages"], "ABSOLUTE": data["memory.absolute"],
        "RELATIVE": data["memory.relative"], "SYSTEM": starts["system"], "PAIR": starts["pair"], "RECORD": starts["record"],
        "MEMORY": starts["memory"], "SPAN_WORDS": sum(count for _, count in spans),
        "INPUTS": starts["inputs"], "DESK": starts["desk"], "RING": data["ring"],
        "SAMPLE_TIMES": starts["record.sample_times"], "SAMPLES": starts["record.samples"],
        "SEGMENTS": data["system.drive.segments"], "SEGMENT_WORDS": segments.itemsize // WORD,
        "SEGMENT_COUNT": segments.size, "SEGMENT_NOW": data["system.drive.now"],
        "INPUT": f'"{options.drive}"', "TOLERANCE": options.tolerance, "DURATION": options.duration,
    }  # fmt: skip
    tables = [
        "enum { AB_NUMBER, AB_LENGTH, AB_LESS };",
        "typedef struct { int kind, first, second; } ab_place;",
        "typedef struct { int word, count; } ab_span;",
        _array("ab_place ab_output_places", (f"{{{each.kind}, {each.first}, {each.second}}}" for each in outputs)),
        _array("ab_span ab_spans", (f"{{{word}, {count}}}" for word, count in spans)),
    ]
    rates, switch = ready.stepper.moving
    kernels = {
        "ab_kernel_advance": (advance, None), "ab_kernel_rates": (rates, rhs_type.signature),
        "ab_kernel_switch": (switch, switch_type.signature), "ab_kernel_observe": (observe, None),
    }  # fmt: skip
    numbers["INDICATOR_COUNT"] = _indicators(ready)
    shown, states = [each.about for each in outputs], _states(ready.assembly)
    return Content("autobalancer.c", image, states, shown, _inputs(ready, options.drive), numbers, tables, kernels)


def _inputs(ready: Prepared, drive: str) -> list[Variable]:
    """What comes from outside, with its value at the start."""
    if drive == "torque":
        start = float(ready.assembly.system.drive.segments.value[0])
        return [
            Variable("torque", "N m", "torque on the rotor, in place of one that is given, beside a motor's", start)
        ]
    speed = Variable(
        "speed_input", "rad/s", "speed at the end of a step of the host", float(ready.assembly.state[SPEED])
    )
    rate = Variable("acceleration_input", "rad/s^2", "acceleration of the rotor, for a host that integrates")
    return [speed, rate] if drive else []


def _image_of_balls(machine: Machine, options: _Options) -> Image:
    its = balancer_element(machine, seed=options.seed)
    return Image(system=its.system, state=its.state)


def _content_of_balls(machine: Machine, options: _Options) -> Content:
    its = balancer_element(machine, seed=options.seed)
    image, count, rows = _image_of_balls(machine, options), its.state.size // 2, its.rows
    number = [str(i + 1) for i in range(count)]
    states = [_labeled(name, i) for name in ("ball_angle_in_rotor", "ball_speed_in_rotor") for i in number]
    hidden = [
        each._replace(name=f"state.{each.name}", start=float(v)) for each, v in zip(states, its.state, strict=True)
    ]
    # forces of rows and rotor; units of a slope are those of an angle and a moment
    turning = [*("slope" if row.startswith("d") else "" for row in rows), "rotor"]
    every = [*rows, "rotor angle"]
    units = ["N m" if turn else "N" for turn in turning]
    outputs = [Variable(f"force[{row}]", unit, f"on the shaft: {row}") for row, unit in zip(every, units, strict=True)]
    outputs += states
    outputs += [Variable(f"force_at_rest[{row}]", unit, f"the same without accelerations: {row}")
                for row, unit in zip(every, units, strict=True)]  # fmt: skip
    power = [1 if turn else 0 for turn in turning]
    outputs += [
        Variable(f"mass[{one},{other}]", ("kg", "kg m", "kg m^2")[power[i] + power[j]], "force over acceleration")
        for i, one in enumerate(every)
        for j, other in enumerate(every)
    ]
    inputs = [
        Variable(f"{kind}[{row}]", ("rad" if turn else "m") + rate, f"{kind} of the shaft: {row}")
        for kind, rate in (("deflection", ""), ("velocity", "/s"), ("acceleration", "/s^2"))
        for row, turn in zip(rows, turning, strict=False)
    ]
    inputs += [
        _labeled("rotor_angle"),
        _labeled("speed"),
        Variable("rotor_acceleration", "rad/s^2", "rotor acceleration"),
    ]
    balls = its.system.balls
    numbers = {
        "STATE": image.data["state"], "SYSTEM": image.starts["system"], "ROWS": len(rows), "TOLERANCE": options.tolerance,
        "DECAY": float((balls.drag / balls.inertia).max(initial=0.0)), "INDICATOR_COUNT": 0,
    }  # fmt: skip
    kernels = {"ab_kernel_element": (element, None)}
    return Content("balancer.c", image, hidden, outputs, inputs, numbers, [], kernels)


def machine_data(content: Content, known: Known, laws: dict[int, Any]) -> str:
    """The head file with the numbers of what is exported."""
    image = content.image
    image.words[list(laws)] = 0
    numbers = {
        "VERSION": json.dumps(version("autobalancer")), "STATE_COUNT": len(content.states),
        "OUTPUT_COUNT": len(content.outputs), "PARAMETER_COUNT": len(known.parameters), "INPUT_COUNT": len(content.inputs),
        "IDENTITY": zlib.crc32(image.words.tobytes()), **content.numbers,
    }  # fmt: skip
    # terms of the parameters, word by word
    by_word = {
        word: [term for term in known.terms if term.word == word]
        for word in sorted({term.word for term in known.terms})
    }
    coefficients: list[float] = []
    factors: list[str] = []
    terms: list[str] = []
    changed: list[str] = []
    for word, its in by_word.items():
        begin = len(terms)
        for term in its:
            first = len(factors)
            for number, c in term.factors:
                factors.append(f"{{{number}, {len(coefficients)}, {len(coefficients) + len(c)}}}")
                coefficients += c
            terms.append(f"{{{term.amplitude!r}, {first}, {len(factors)}}}")
        changed.append(f"{{{word}, {begin}, {len(terms)}}}")
    numbers["WORD_COUNT"] = len(changed)
    return "\n".join(
        [
            "/* Written by autobalancer; not to be edited. Addresses among the words count from their begin, in bytes. */",
            "",
            *(f"#define AB_{name} {value}" for name, value in numbers.items()),
            "",
            "typedef struct { int parameter, first, last; } ab_factor;",
            "typedef struct { double amplitude; int first, last; } ab_term;",
            "typedef struct { int word, first, last; } ab_changed_word;",
            "typedef struct { int word; int32_t (*function)(void); } ab_function;",
            *(f"extern int32_t {LAW}{number}(void);" for number in range(len(laws))),
            "",
            _array("ab_variable ab_states", map(_variable, content.states)),
            _array("ab_variable ab_output_list", map(_variable, content.outputs)),
            _array("ab_variable ab_parameter_list", map(_variable, known.parameters)),
            _array("ab_variable ab_input_list", map(_variable, content.inputs)),
            _array("double ab_coefficients", map(repr, coefficients)),
            _array("ab_factor ab_factors", factors),
            _array("ab_term ab_terms", terms),
            _array("ab_changed_word ab_changed_words", changed),
            *content.tables,
            _array("int ab_addresses", map(str, image.addresses)),
            _array("ab_function ab_functions", (f"{{{word}, {LAW}{number}}}" for number, word in enumerate(laws))),
            _array(
                "int64_t ab_words", (str(word) if word > -(2**63) else "INT64_MIN" for word in image.words.tolist())
            ),
            "",
        ]
    )


def _variable(about: Variable) -> str:
    words = ", ".join(json.dumps(text) for text in (about.name, about.unit or "1", about.meaning))
    return f"{{{words}, {', '.join(map(_number, (about.start, about.least, about.greatest)))}}}"


def _number(value: float) -> str:
    return repr(value) if math.isfinite(value) else "-INFINITY" if value < 0.0 else "INFINITY"


def _array(head: str, entries: Iterable[str]) -> str:
    """A table in C, of at least one entry; lines of about 120 characters."""
    lines: list[str] = []
    line = "   "
    for entry in entries:
        if len(line) + len(entry) > 118:
            lines, line = [*lines, line], "   "
        line += f" {entry},"
    body = "\n".join([*lines, line]) if lines or line.strip() else "    {0},"
    return f"static const {head}[] = {{\n{body}\n}};\n"


# Files: a folder with the library and its sources, or an FMU.


COMMON = ("-O2", "-std=c11", "-fno-strict-aliasing", "-fPIC")
LIBRARY = {"linux": "lib{name}.so", "windows": "{name}.dll"}
TARGETS = {
    "linux": ("x86_64-linux-gnu", ("cc", "gcc", "clang")),
    "windows": ("x86_64-windows-gnu", ("x86_64-w64-mingw32-gcc",)),
}


class Exported(NamedTuple):
    """What was written."""

    path: Path
    systems: tuple[str, ...]  # for which there is a library
    parameters: tuple[Variable, ...]  # what can be changed: paths, and values with least and greatest, SI
    fixed: tuple[str, ...]  # paths of numbers that cannot be
    outputs: tuple[str, ...]
    missing: str  # why there is no library for some system; empty if there is one for each


def export(
    machine: Machine | str | Path,
    out: str | Path,
    *,
    part: Literal["machine", "balancer"] = "machine",
    drive: Literal["own", "speed", "torque"] = "own",
    fmi: Literal["2.0", "3.0"] = "2.0",
    duration: float | str | None = None,
    seed: int = 0,
    tolerance: float = 1e-8,
) -> Exported:
    """Write a machine as a library in C, or as an FMU if the name ends with ``.fmu``.

    Parameters
    ----------
    machine
        A machine or the path of a machine file.
    out
        A folder, which is made, or a file ``NAME.fmu``.
    part
        The whole machine, or its balls alone, for a shaft that the other program moves: in its motion, out forces and balls.
    drive
        Whether the drive is that of the machine, or a speed (rad/s) or torque (N m) comes from outside.
    fmi
        Version of an FMU.
    duration
        Seconds, or a text such as ``"20 s"``; by default the ``run.duration`` of the machine. Steps are those of a run of
        this duration, and a lag of the fluid is known so long.
    seed
        For the start positions of balls that have none in the machine.
    tolerance
        Local error per step, as of ``simulate``.

    Returns
    -------
    Exported
        Path, systems for which there is a library, and paths of the numbers that can be changed.

    Raises
    ------
    QuestionError
        If an argument is not possible, or no compiler of C is there.
    MachineError
        If the machine cannot be run.
    """
    machine = balls_in_races(machine)
    run_options("export", {"tolerance": tolerance}, ONE_RUN)  # refuses what is not possible
    end, place = run_duration(machine, duration), as_path(out)
    one_of("part", part, "machine", "balancer")
    one_of("drive", drive, "own", "speed", "torque")
    one_of("fmi", fmi, "2.0", "3.0")
    unit = place.suffix.lower() == ".fmu"
    if place.is_file() and not unit:
        raise QuestionError(f"out: given {str(out)!r}, which is a file; must be a folder, or NAME.fmu")
    options = _Options("" if drive == "own" else drive, seed, tolerance, end)
    if drive != "own":
        _refuse_drive(machine, drive)
    content = (_content_of_balls if part == "balancer" else _content_of_machine)(machine, options)
    image_of, within = (_image_of_balls, ("balancers", "gravity")) if part == "balancer" else (_image_of, ("",))
    known = parameters_of(machine, lambda other: image_of(other, options), within, OUTSIDE[options.drive])
    laws = _own_functions(content.image)
    data = machine_data(content, known, laws)
    code = intermediate_code(
        {**content.kernels, **{f"{LAW}{number}": (law, None) for number, law in enumerate(laws.values())}}
    )
    name = re.sub(r"\W+", "_", place.stem).strip("_") or "machine"
    name = name if name[0].isalpha() else f"m_{name}"
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        extra = "fmi.c" if unit else "example.c"
        for text in ("autobalancer.h", "block.c", content.source, *([extra] if unit or part == "machine" else [])):
            shutil.copy(SOURCES / text, folder)
        token = str(uuid.uuid5(uuid.NAMESPACE_OID, data + fmi))
        (folder / "machine_data.h").write_text(f'{data}#define AB_TOKEN "{token}"\n', "utf-8")
        (folder / "kernels.ll").write_text(code, "utf-8")
        defined = [f'-DAB_SOURCE="{content.source}"', f"-DFMI_VERSION={fmi[0]}"] if unit else []
        built, missing = _built(folder, code, name, [*defined, extra if unit else content.source])
        if unit:
            about = Description(name, machine.name, token, fmi, end, tolerance, content.numbers["INDICATOR_COUNT"])
            write_unit(place, folder, about, content.states, content.outputs, known.parameters, content.inputs, built)
        else:
            place.mkdir(parents=True, exist_ok=True)
            for source in folder.iterdir():
                write_safely(place / source.name, partial(shutil.copyfile, source))
    outputs = tuple(each.name for each in content.outputs)
    return Exported(place, tuple(built), known.parameters, known.fixed, outputs, missing)


OUTSIDE = {
    "": (),
    "speed": ("drive",),
    "torque": ("drive.torque", "drive.profile"),
}  # what comes from there has no parameters


def _refuse_drive(machine: Machine, drive: str) -> None:
    prescribed = isinstance(machine.drive, PrescribedSpeed)
    if prescribed != (drive == "speed"):
        other = "torque" if drive == "speed" else "speed"
        raise QuestionError(
            f"drive: {drive!r} needs a machine whose drive gives a {drive}; this one gives a {other}: take {other!r}, or change "
            "the part `drive` of the machine"
        )
    if isinstance(machine.drive, TargetTorque):
        raise QuestionError(
            "drive: this machine's torque follows a target speed, so a torque from outside has no place: take 'own', or give the "
            "machine a drive of the kind 'torque'"
        )
    lagging = [
        race for balancer in machine.balancers for race in balancer.races if race.fluid and race.fluid.lag != "none"
    ]
    if lagging and drive == "speed":
        raise QuestionError(
            "drive: 'speed' from outside, but the fluid of a race lags behind a speed that is not known beforehand: take 'own', "
            "or leave out `lag` of the fluid"
        )


def _built(folder: Path, code: str, name: str, own: Sequence[str]) -> tuple[dict[str, Path], str]:
    """Libraries for each system in the folder, and why one is missing."""
    built, missing = {}, []
    for system, (target, compilers) in TARGETS.items():
        compiler = _compiler(target, compilers)
        if compiler is None:
            missing.append(system)
            continue
        (folder / f"kernels_{system}.o").write_bytes(object_code(code, system))
        library = folder / LIBRARY[system].format(name=name)
        common = [option for option in COMMON if system == "linux" or option != "-fPIC"]
        link = ["-shared", "-fvisibility=hidden", f"kernels_{system}.o", "-o", library.name, "-lm"]
        _run([*compiler, *common, *own, *link], folder)
        built[system] = library
    if not built:
        raise QuestionError(
            "no compiler of C is there: install one (cc), or pip install 'autobalancer[export]', which brings one for Linux "
            "and Windows"
        )
    if not missing:
        return built, ""
    return (
        built,
        f"There is no library for {' and '.join(missing)}: pip install 'autobalancer[export]' brings a compiler for it.",
    )


def _compiler(target: str, names: Sequence[str]) -> list[str] | None:
    """Command of a compiler for a target."""
    native = "linux" not in target or sys.platform == "linux"
    found = next((path for one in names if (path := shutil.which(one))), None) if native else None
    if found:
        return [found]
    if importlib.util.find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc", "-target", target]
    return None


def _run(command: list[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise QuestionError(f"the compiler {command[0]} failed: {shortened(done.stderr or done.stdout, 600)}")
