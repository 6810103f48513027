"""The terms of the equations, and which theory knows them: here each key of a machine file is declared for its terms.

A run knows all terms. A theory knows those in ``known``; ``idle`` ones have no effect on what it says, for the reason in ``why``;
of all others, where a machine has them, its answer says that it ignores them. A key that is declared nowhere is known to none.
"""

from __future__ import annotations

import re
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from autobalancer.assembly.drive_train import is_linked
from autobalancer.assembly.guided_balls import has_forces
from autobalancer.assembly.reduced_rotor import has_hardening, has_rubber
from autobalancer.cache import remembered
from autobalancer.catalog import product_tables
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import spell
from autobalancer.machine import Balls, Fluid, Friction, Machine, PlanarRotor, Race
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.keys import TAGS, prose_of
from autobalancer.machine.part import Part, keys_noted


class Theory(Enum):
    """What answers without a run."""

    AT_REST = "balls at rest"  # equilibria, eigenvalues, exact border, windows, maps, least drag, branches
    AVERAGED = "averaged equations"
    STALLED = "stalled balls"  # release and capture speed
    HELD = "what friction holds"
    LOOP = "loop of a measured receptance"  # the rotor of the machine is not asked
    BASIN = "ends of starts at constant speed"  # runs of their own, named by the states at rest
    CAPABILITY = "capability"
    ROTOR = "rotor that carries its balls"  # modes, Campbell, critical speeds, response, equivalent planar rotor
    LIQUID = "rings of liquid"
    TORSION = "torsion of the drive"


@dataclass(frozen=True)
class Term:
    """A term of the equations, or a group of them that all theories treat alike.

    ``keys`` are of the form ``Class: key key; Class: *``; a star stands for all keys of the class, of a family of plug-ins or of
    rotor models, that are declared nowhere by name.
    """

    name: str
    keys: str
    known: frozenset[Theory]
    idle: frozenset[Theory] = frozenset()
    why: str = ""
    names: Mapping[Theory, str] = field(default_factory=dict)  # where a theory knows a part of it
    there: Callable[[Machine], bool] | None = None  # by default where one of its keys is not at its neutral value

    def owners(self) -> Iterator[tuple[str, str]]:
        """Its keys as (class, key)."""
        for group in self.keys.split(";"):
            owner, _, names = group.partition(":")
            yield from ((owner.strip(), name) for name in names.split())


REST, AVERAGED, STALLED = Theory.AT_REST, Theory.AVERAGED, Theory.STALLED
HELD, LOOP, BASIN = Theory.HELD, Theory.LOOP, Theory.BASIN
CAPABILITY, ROTOR, LIQUID, TORSION = Theory.CAPABILITY, Theory.ROTOR, Theory.LIQUID, Theory.TORSION
ALL = frozenset(Theory)
OF_BALLS = frozenset({REST, AVERAGED, STALLED, HELD, LOOP, BASIN})
ON_ROTOR = ALL - {LOOP, CAPABILITY, TORSION}
NO_BALLS = frozenset({CAPABILITY, ROTOR, LIQUID, TORSION})  # what acts on moving balls cannot matter to them
MEASURED = (
    "a measured receptance stands for the rotor; capability does not ask it, and for torsion it is one stiff piece"
)
MOVING = "acts on balls that move"
NEUTRAL = (None, 0, False, "", ())  # values of a key without a default that have no effect
ANY_PLACE = "the answer holds for a speed or a start that the caller chooses"


def _races(machine: Machine) -> Iterator[Any]:
    return (race for balancer in machine.balancers for race in balancer.races)


def _across(machine: Machine) -> bool:
    return bool(machine.axis == "horizontal" and machine.gravity > 0.0)


def _meets(machine: Machine) -> bool:
    """Whether balls of known size can meet."""
    return any(
        race.ball_count > 1 and race.collisions
        for b, balancer in enumerate(machine.balancers)
        for r, race in enumerate(balancer.races)
        if any(ball.diameter for ball in resolve(machine) if (ball.balancer, ball.race) == (b, r))
    )


def _of_keys() -> Iterator[Term]:
    """What keys of balls and their race declare themselves, as :func:`~autobalancer.machine.part.key` says."""
    for part in (Race, Balls, Friction, Fluid):
        for name, known in keys_noted(part, "known").items():
            theories = frozenset(Theory[word.upper()] for word in known.split() if word != "none")
            yield Term(name.replace("_", " "), f"{part.__name__}: {name}", theories, NO_BALLS, MOVING)


TERMS = (
    Term(
        "mass, springs and dampers of the rotor",
        "RotorModel: *; Resonance: *; ModeFiles: *; Coordinate: *; MatrixFiles: *; "
        "Support: position stiffness damping cross_stiffness tilt_stiffness tilt_damping; SpeedTable: speed stiffness damping; "
        "ShaftMaterial: density youngs_modulus shear_modulus poisson_ratio; "
        "ShaftSegment: length diameter inner_diameter elements shear_coefficient; "
        "Disk: position mass transverse_inertia polar_inertia offset extent; "
        "Body: mass position offset transverse_inertia polar_inertia inertia rotating; Joint: *; "
        "Rubber: stiffness damping; RubberRelaxation: relaxation_time stiffness; Station: position body; Balancer: station",
        ON_ROTOR,
        ALL - ON_ROTOR,
        MEASURED,
    ),
    Term(
        "weight along the axis",
        "Machine: gravity; ShaftRotor: up thrust_bearing; MultibodyRotor: up",
        ON_ROTOR,
        ALL - ON_ROTOR,
        MEASURED,
        there=lambda machine: getattr(machine.rotor, "up", None) is not None and machine.axis == "vertical",
    ),
    Term(
        "gravity in the plane",
        "Machine: axis gravity",
        frozenset({HELD, LIQUID, TORSION}),
        frozenset({CAPABILITY, ROTOR}),
        "deflections count from where the rotor rests",
        there=_across,
    ),
    Term(
        "tilt of the races",
        "Machine: tilting_races",
        frozenset({REST, BASIN}),
        NO_BALLS,
        MOVING,
        there=lambda machine: machine.tilting_races == "full" and not isinstance(machine.rotor, PlanarRotor),
    ),
    Term(
        "unbalance",
        "Unbalance: moment mass radius couple misalignment angle station; Schedule: time factor",
        ON_ROTOR | {TORSION},
        frozenset({LOOP, CAPABILITY}),
        "is an argument of its own here",
    ),
    Term(
        "balls",
        "Balls: count body diameter mass density material length inner_diameter inertia motion; "
        "Race: bearing orbit_radius race_radius; Fluid: name temperature density viscosity virtual_mass",
        ALL - {LIQUID, TORSION},
        frozenset({LIQUID, TORSION}),
        "rings of liquid stand in place of balls, and in torsion balls run freely",
    ),
    Term(
        "eccentric races",
        "Race: eccentricity eccentricity_angle",
        OF_BALLS - {LOOP},
        NO_BALLS,
        "the places of balls are not asked",
        there=lambda machine: any(race.eccentricity for race in _races(machine)),
    ),
    Term("linear drag", "Drag: *", OF_BALLS, NO_BALLS, MOVING),
    Term(
        "drag that is not linear",
        "Drag: *; ShearLaw: *",
        frozenset({STALLED, BASIN}),
        NO_BALLS,
        MOVING,
        there=lambda machine: any(ball.drag_curve is not None for ball in resolve(machine)),
    ),
    Term(
        "lag of the fluid",
        "Fluid: lag; Race: width height",
        frozenset({BASIN}),
        ALL - {BASIN},
        "at constant speed, and in a slow run-up, the fluid turns with its race",
    ),
    *_of_keys(),
    Term(
        "friction",
        "Friction: rolling_resistance; Balls: bearing_radius",
        frozenset({STALLED, HELD, BASIN}),
        NO_BALLS,
        MOVING,
        there=lambda machine: any(ball.rolling_resistance for ball in resolve(machine)),
    ),
    Term("adherence", "Friction: adherence; Balls: bearing_radius", frozenset({HELD, BASIN}), NO_BALLS, MOVING,
         there=lambda machine: any(race.friction is not None and race.friction.adherence for race in _races(machine))),
    Term("law of rolling resistance", "Friction: rolling_law; FrictionLaw: *", frozenset({BASIN}), NO_BALLS, MOVING,
         there=lambda machine: any(race.friction is not None and race.friction.rolling_law for race in _races(machine))),
    Term(
        "friction between balls",
        "Contact: friction slip_speed",
        frozenset(),
        NO_BALLS,
        MOVING,
        there=lambda machine: any(race.contact is not None and race.contact.friction > 0.0 for race in _races(machine)),
    ),
    Term(
        "contact between balls",
        "Contact: restitution stiffness; Race: collisions; "
        "Rebound: yield_speed exponent speeds factors critical_stokes",
        frozenset(),
        ALL - {BASIN},
        "rebound is of the motion; the states are those of balls that stand free, or in line where they say so",
        there=_meets,
    ),
    Term("partitions", "Partitions: count angle", frozenset({STALLED}), NO_BALLS - {CAPABILITY}, MOVING),
    Term(
        "waves of the race",
        "Harmonic: order amplitude angle; Roundness: deviations angle harmonics",
        frozenset({BASIN}),
        NO_BALLS,
        MOVING,
    ),
    Term(
        "resolved contact",
        "ResolvedContact: stiffness reduced_modulus restitution damping sliding_friction slip_speed rest_speed "
        "adherence_stiffness floor_friction floor_motion ball_friction start_gap; FrictionLaw: *",
        frozenset(),
        NO_BALLS,
        MOVING,
        there=lambda machine: any(race.resolved is not None for race in _races(machine)),
    ),
    Term("forces on the balls", "Force: *", frozenset({REST}), NO_BALLS, MOVING, there=has_forces),
    Term(
        "excitations",
        "BaseMotion: acceleration displacement frequency order phase direction; "
        "RecordedBaseMotion: time acceleration direction; HarmonicForce: station force frequency order phase direction; "
        "RecordedForce: station time force direction",
        frozenset({BASIN}),
        frozenset({LOOP, CAPABILITY, ROTOR, TORSION}),
        "the answer is what unbalance does, or how the rotor moves freely",
        there=lambda machine: bool(machine.excitations),
    ),
    Term(
        "hardening of the bearings (stiffness at rest)",
        "Hardening: cubic_stiffness clearance contact_stiffness distance force center",
        frozenset({BASIN}),
        ALL - ON_ROTOR,
        MEASURED,
        there=has_hardening,
    ),
    Term(
        "softening of the rubber (stiffness of small motions)",
        "RubberFriction: law breakaway_amplitude stiffness",
        frozenset({BASIN, ROTOR}),
        ALL - ON_ROTOR,
        MEASURED,
        {STALLED: "softening of the rubber by the unbalance"},
        there=has_rubber,
    ),
    Term(
        "torsion of the drive",
        "Coupling: stiffness damping inertia error order phase; MotorMount: inertia stiffness damping",
        frozenset({TORSION}),
        frozenset({LOOP, CAPABILITY, ROTOR}),
        "these ask how the rotor deflects",
        there=is_linked,
    ),
    Term(
        "torque of the drive (constant speed)",
        "ConstantTorque: torque damping; TargetTorque: gain damping; TorqueTable: speed torque damping; "
        "AsynchronousMotor: rated_torque overload synchronous_speed breakdown_slip; AsynchronousDrive: damping; "
        "TorqueRipple: torque order phase",
        frozenset({TORSION}),
        frozenset({LOOP, CAPABILITY, ROTOR}),
        "these ask how the rotor deflects at a speed that is given",
        there=lambda machine: machine.drive.kind != "speed",
    ),
    Term(
        "speed over time",
        "Constant: speed; Ramp: start end duration delay; Table: time speed; Dwell: speeds hold acceleration; "
        "Hill: start end half_time exponent; "
        "Reduction: start peak reduced end acceleration hold_peak hold_reduced dwell hold_dwell",
        frozenset({STALLED, HELD}),
        ALL - {STALLED, HELD},
        ANY_PLACE,
    ),
    Term(
        "starts of the balls, and how many modes a run keeps",
        "Balls: start_angles start_speeds; ShaftRotor: modes; MultibodyRotor: modes; "
        "ModalRotor: modes; MatricesRotor: modes",
        frozenset({BASIN}),
        ALL - {BASIN},
        ANY_PLACE,
    ),
    Term(
        "starts of the rotor, names, and what counts in runs under a torque only",
        "Machine: name description; Station: name; Balancer: name; Body: name; Disk: name; Coupling: name; "
        "Start: rotor_angle speed deflection velocity; RunPlan: duration; "
        "PlanarRotor: inertia; ModalRotor: inertia source total_mass; MatricesRotor: inertia source total_mass valid_to",
        frozenset(),
        ALL,
        ANY_PLACE,
    ),
    Term(
        "rings of liquid",
        "LiquidRing: name radius height width layer liquid; Fluid: name temperature density",
        frozenset({LIQUID}),
        ALL - ON_ROTOR,
        "no machine has balls and rings",
        there=lambda machine: bool(machine.liquid_rings),
    ),
)  # fmt: skip


def unknown(machine: Machine, theory: Theory) -> tuple[str, ...]:
    """What a machine has and a theory does not know, in words: terms, and keys that nobody has declared."""
    terms, undeclared = _terms_of(machine)
    left_out = [term.names.get(theory, term.name) for term in terms if theory not in term.known | term.idle]
    return (*left_out, *(f"{path} (not known to any theory)" for path in undeclared))


def ignores(machine: Machine, theory: Theory) -> str:
    """The same as a remark, ``"ignores friction, slipstream"``; empty if nothing is left out."""
    left_out = unknown(machine, theory)
    return f"ignores {', '.join(left_out)}" if left_out else ""


def weightless(machine: Machine) -> Machine:
    """The machine without the weight across a horizontal axis, with which nothing rests in the rotor; others as they are."""
    return machine.model_copy(update={"gravity": 0.0}) if _across(machine) else machine


def declared_for(part: type[Part], key: str) -> tuple[Term, ...]:
    """The terms that a key of a part makes; empty if nobody has declared it."""
    owners = [base.__name__ for base in part.__mro__]
    by_name, by_star = ([term for owner in owners for term in _declared().get((owner, at), ())] for at in (key, "*"))
    return tuple(by_name or by_star)


@cache
def _declared() -> dict[tuple[str, str], tuple[Term, ...]]:
    declared: dict[tuple[str, str], tuple[Term, ...]] = {}
    for term in TERMS:
        for owner in term.owners():
            declared[owner] = (*declared.get(owner, ()), term)
    return declared


@remembered(8)
def _terms_of(machine: Machine) -> tuple[tuple[Term, ...], tuple[str, ...]]:
    """The terms that a machine has, and the paths of keys away from their neutral value that belong to none."""
    there: set[str] = set()
    undeclared: list[str] = []
    for part, key, path in _set_keys(machine, ()):
        terms = declared_for(type(part), key)
        there.update(term.name for term in terms)
        if not terms:
            undeclared.append(spell(path))
    result = tuple(term for term in TERMS if (term.there(machine) if term.there is not None else term.name in there))
    return result, tuple(undeclared)


def _set_keys(part: Part, path: tuple[str | int, ...]) -> Iterator[tuple[Part, str, tuple[str | int, ...]]]:
    """Every key of a part and of those in it that is not at its neutral value: its default, or nothing where it has none."""
    for owner, at in _parts(part, path):
        for key, about in type(owner).model_fields.items():
            value = getattr(owner, key)
            neutral = NEUTRAL if about.is_required() else (about.get_default(call_default_factory=True),)
            if not _inner(value) and key not in TAGS and value not in neutral:
                yield owner, key, (*at, key)


def _parts(part: Part, path: tuple[str | int, ...] = ()) -> Iterator[tuple[Part, tuple[str | int, ...]]]:
    """A part and those in it, with their paths."""
    for key in type(part).model_fields:
        for step, one in _inner(getattr(part, key)):
            yield from _parts(one, (*path, key, *step))
    yield part, path


def _inner(value: Any) -> list[tuple[tuple[int, ...], Part]]:
    """The parts that are a value or in its list, with their numbers there."""
    if isinstance(value, tuple):
        return [((number,), one) for number, one in enumerate(value) if isinstance(one, Part)]
    return [((), value)] if isinstance(value, Part) else []


# What a machine and its run rest on. Every law, part and product names its source as author and year; here they are read.


BIBLIOGRAPHY = Path(str(files("autobalancer"))) / "catalog" / "data" / "references.bib"
PERSON = r"[A-ZÁŠŽČ][\w'-]+"
CITED = re.compile(
    rf"(?P<names>{PERSON}(?:(?:, {PERSON})* and {PERSON}| et al\.)?),? \(?(?P<year>(?:18|19|20)\d\d)\b"
    r"|ISO (?P<number>\d+(?:-\d+)?)"
)
SOFTWARE = "autobalancer"  # key of the program itself
# accents and letters of BibTeX
ACCENTS = dict(zip("\"'`^~=.vuHc", "\u0308\u0301\u0300\u0302\u0303\u0304\u0307\u030c\u0306\u030b\u0327", strict=True))
WRITTEN = {r"{\ss}": "ß", r"\l}": "ł", r"\o}": "ø", r"\&": "&", r"$^\circ$": "°", "{": "", "}": ""}


@cache
def bibliography() -> dict[str, str]:
    """Every source by its key, as BibTeX."""
    entries = re.split(r"^(?=@)", BIBLIOGRAPHY.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return {entry[entry.index("{") + 1 : entry.index(",")]: entry.strip() for entry in entries}


@cache
def methods() -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
    """Methods of the package: the public functions, and the ways of integration, that use each, and the keys of its sources."""
    rows = product_tables.rows("result_sources.csv")
    return {row["method"]: (tuple(row["results"].split()), tuple(row["sources"].split())) for row in rows}


def printed(key: str) -> str:
    """A source as a line of text: authors, year, title."""
    field: dict[str, str] = dict(re.findall(r"^\s*(\w+)\s*= (.*?),?$", letters(bibliography()[key]), re.MULTILINE))
    people = [name.split(",")[0] for name in field.get("author", field.get("editor", "")).split(" and ")]
    many = len(people) > 3 or "others" in people
    names = f"{people[0]} et al." if many else re.sub(r", ([^,]*)$", r" and \1", ", ".join(people))
    return f"{names} ({field.get('year', 'no year')}), {field['title'].replace('--', '–')}"


@cache
def _words() -> dict[str, frozenset[str]]:
    """The words of each source, among them its key."""
    return {
        key: frozenset({key, *re.findall(r"[\w'-]+", plain_letters(entry))}) for key, entry in bibliography().items()
    }


def named_in(text: str) -> tuple[str, ...]:
    """The keys of the sources that a text names, such as "Jan and Chen (1997)" or "ISO 492"."""
    found: list[str] = []
    for cited in CITED.finditer(text):
        words = {f"iso{cited['number']}"} if cited["number"] else {cited["year"], *re.findall(PERSON, cited["names"])}
        words = {plain_letters(word) for word in words}
        found += [key for key, entry in _words().items() if words <= entry]
    return tuple(dict.fromkeys(found))


def sources(
    machine: Machine | ChamberMachine | None, about: Mapping[str, Any] | None = None, results: Iterable[str] = ()
) -> dict[str, tuple[str, ...]]:
    """What a machine, an answer with attributes ``about`` and ``results`` of public functions rest on: keys of sources, and uses.

    The program itself comes first. A source of a product that is not in the bibliography stands with its words in place of a key.
    """
    about, found = about or {}, {SOFTWARE: [""]}
    texts = list(_texts(machine)) if machine is not None else []
    texts += [("drag", str(about[name])) for name in ("drag_source",) if name in about]
    wanted = {*results, *re.split(r"[,\s]+", str(about.get("method", "")))}
    for method, (of, keys) in methods().items():
        for key in keys if wanted & {*of} else ():
            found.setdefault(key, []).append(method)
    for what, text in texts:
        product = what.startswith(("fluid ", "material "))  # its source is said, in the bibliography or not
        for key in named_in(text) or ((text,) if product else ()):
            found.setdefault(key, []).append(what)
    return {key: tuple(filter(None, dict.fromkeys(uses))) for key, uses in found.items()}


def _texts(machine: Machine | ChamberMachine) -> Iterator[tuple[str, str]]:
    """What names sources: the description of a machine, and each part of it with its products of the catalog."""
    yield "description of the machine", machine.description
    for part, path in _parts(machine):
        word = next((str(getattr(part, tag)) for tag in TAGS if hasattr(part, tag)), "")
        name = f"{path[-1] if path and isinstance(path[-1], str) else type(part).__name__} {word}".strip().replace(
            "_", " "
        )
        yield name, prose_of(type(part))
        if word:  # one file for each kind, whose first lines are of that kind
            yield name, str(sys.modules[type(part).__module__].__doc__)
        if isinstance(part, Fluid) and part.name is not None:
            yield f"fluid {part.name}", product_tables.fluid(part.name, part.temperature or product_tables.ROOM).source
        if getattr(part, "material", None) is not None and isinstance(part, Balls):
            yield f"material {part.material}", product_tables.material(str(part.material)).source
        if isinstance(part, Race) and part.bearing is not None:
            yield f"bearing {part.bearing}", str(product_tables.bearings.__doc__)


def letters(text: str) -> str:
    """Letters that BibTeX spells with commands and braces."""
    text = re.sub(r"\\([\"'`^~=.]|[vuHc](?=\{))\{?\\?([A-Za-z])", lambda found: found[2] + ACCENTS[found[1]], text)
    for written, letter in WRITTEN.items():
        text = text.replace(written, letter)
    return unicodedata.normalize("NFC", text)


def plain_letters(text: str) -> str:
    """Letters without their accents."""
    text = unicodedata.normalize("NFKD", letters(text).replace("ł", "l").replace("ß", "ss"))
    return "".join(letter for letter in text if not unicodedata.combining(letter))
