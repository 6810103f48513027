"""All candidates of a design as a labeled dataset: what they are, where they were ruled out and why, what the runs left."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.author_units import in_author_units, with_author_springs
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.files.machine_file import machine_text
from autobalancer.results.provenance import provenance
from autobalancer.studies.design.answer import STAGES
from autobalancer.studies.design.building import driven
from autobalancer.studies.design.measured import labelled
from autobalancer.studies.design.ranking import meets, missed, misses, ordered, used
from autobalancer.studies.design.running import left_out
from autobalancer.studies.design.screening import Design
from autobalancer.studies.design.spec import MEASURED, Spec

SHARES = {
    "stall": "share of the runs that end with a stalled ball or rotor",
    "balanced": "share of the runs that end balanced",
    **{
        f"{name}_over": f"share of the runs with more than the limit: {text}" for name, (_, _, text) in MEASURED.items()
    },
}
ENDS = {"low": "lower end of its 95 % interval", "high": "upper end of its 95 % interval"}


def designs_dataset(spec: Spec, designs: Sequence[Design], how: str) -> xr.Dataset:
    """Over ``design``: candidates in their order; ``place`` is 1 for the best, nan for those that did not run.

    Parameters
    ----------
    spec
        What was asked.
    designs
        All candidates that were looked at.
    how
        How those that ran were chosen.
    """
    ranked = ordered(spec, [one for one in designs if one.numbers])
    place = {id(one): number for number, (one, _) in enumerate(ranked, start=1)}
    front = {id(one): level for one, level in ranked}
    best = next((one.machine for one, _ in ranked if one.machine is not None), None)
    found = xr.Dataset(attrs={**_attributes(spec, how), "left_out": left_out(spec, best) if best is not None else ""})
    found.attrs["borders_ignore"] = _borders_ignore(designs)
    found = found.assign_coords(
        design=("design", np.arange(1, len(designs) + 1), {"long_name": "number of the candidate"})
    )

    def add(name: str, values: Sequence[Any], text: str, unit: str = "") -> None:
        kept = (
            np.array(values, dtype=object) if values and isinstance(values[0], str) else np.asarray(values, np.float64)
        )
        found[name] = ("design", kept, {"long_name": text, **({"units": unit} if unit else {})})

    add("label", _labels(designs), "what it is")
    add("place", [float(place.get(id(one), np.nan)) for one in designs], "place among those that ran, 1 for the best")
    add("front", [float(front.get(id(one), np.nan)) for one in designs], "number of its Pareto front, 0 for the first")
    add(
        "meets",
        [float(meets(spec, one)) if one.numbers else -1.0 for one in designs],
        "1: keeps all limits; 0: too few runs to say; -1: does not",
    )
    beyond = [misses(spec, one) if one.numbers else {} for one in designs]
    add("misses", [float(len(one)) for one in beyond], "limits on the runs that it misses, their number", "1")
    add(
        "missed",
        [missed(spec, one) if one.numbers else one.stage for one in designs],
        "limits that it misses, or what ruled it out",
    )
    add(
        "stage",
        [one.stage for one in designs],
        f"what ruled it out: {', '.join(STAGES[:-1])}; {STAGES[-1]!r} if it ran",
    )
    add("reason", [one.reason for one in designs], "why it was ruled out")
    add(
        "excess",
        [one.excess if one.reason else sum(more.values()) for one, more in zip(designs, beyond, strict=True)],
        "how far it misses that, or limits on the runs added up, over what is allowed",
        "1",
    )
    add("bearing", [one.candidate.ring.bearing for one in designs], "bearing whose outer ring is the race")
    add("fluid", [one.candidate.fluid for one in designs], "fluid of the races")
    add("planes", [", ".join(one.candidate.planes) for one in designs], "stations with balls")
    add("count", [one.candidate.count for one in designs], "balls of a race")
    add("races", [one.candidate.races for one in designs], "races of a plane")
    for name, text in (
        ("orbit_radius", "orbit radius"),
        ("ball_diameter", "diameter of a ball"),
        ("bore", "free bore"),
        ("outer", "outer diameter"),
        ("width", "width of a race"),
    ):
        add(name, [getattr(one.candidate.ring, name) for one in designs], text, "m")
    add(
        "viscosity_cold",
        [one.viscosity[0] for one in designs],
        "kinematic viscosity at the lowest temperature",
        "m^2/s",
    )
    add(
        "viscosity_warm",
        [one.viscosity[1] for one in designs],
        "kinematic viscosity at the highest temperature",
        "m^2/s",
    )
    add("capability", [one.capability for one in designs], "unbalance that the balls of a plane can balance", "kg m")
    add(
        "capability_margin",
        [one.margin for one in designs],
        "capability over what is to be balanced, the least of all planes",
        "1",
    )
    add("ball_mass", [one.ball_mass for one in designs], "mass of all balls", "kg")
    add("pressure", [one.pressure for one in designs], "greatest pressure between ball and race (Hertz)", "Pa")
    add(
        "release",
        [one.release for one in designs],
        "release speed, the worst of all temperatures and unbalances",
        "rad/s",
    )
    add(
        "border", [one.border for one in designs], "exact border, the worst of all temperatures and unbalances", "rad/s"
    )
    for name, (_, unit, text) in MEASURED.items():
        at_share = f"{text}; {100.0 * spec.share:g} % of the runs stay below"
        add(name, [one.numbers.get(name, np.nan) for one in designs], at_share, unit)
        add(f"{name}_median", [one.numbers.get(f"{name}_median", np.nan) for one in designs], f"{text}; median", unit)
    for name, text in SHARES.items():
        if any(name in one.numbers for one in designs):
            add(name, [one.numbers.get(name, np.nan) for one in designs], text, "1")
            for end, said in ENDS.items():
                key = f"{name}_{end}"
                add(key, [one.numbers.get(key, np.nan) for one in designs], f"{text}; {said}", "1")
    add("drag_warning", [one.drag_warning for one in designs], "where its balls leave the range of their drag law")
    add(
        "used",
        [used(spec, one) if one.numbers else np.nan for one in designs],
        "greatest share of a limit that it uses up",
        "1",
    )
    found["machine"] = (
        "design",
        np.array([_text(spec, one, place) for one in designs], dtype=object),
        {"long_name": "machine file"},
    )
    if spec.measured is not None:
        variables, attributes = labelled(spec.measured)
        found = found.assign(variables).assign_attrs(attributes)
    return found


def _borders_ignore(designs: Sequence[Design]) -> list[str]:
    """What the border speeds of the table leave out of the machines, a sentence each."""
    machines = [one.machine for one in designs if one.machine is not None and one.numbers]
    found = []
    for name, theory in (("release speed", Theory.STALLED), ("exact border", Theory.AT_REST)):
        terms = dict.fromkeys(term for machine in machines for term in unknown(machine, theory))
        found += [f"{name}: ignores {', '.join(terms)}"] if terms else []
    return found


def _labels(designs: Sequence[Design]) -> list[str]:
    """What each is, without what all have in common."""
    parts = [one.candidate.parts() for one in designs]
    for part, one in zip(parts, designs, strict=True):
        part["ring"] += f" (same race: {', '.join(one.twins)})" * bool(one.twins)
    common = {key for key in ("ring", "races", "planes", "fluid") if len({one.get(key) for one in parts}) == 1}
    return [", ".join(text for key, text in one.items() if key not in common) for one in parts]


def _text(spec: Spec, one: Design, place: dict[int, int]) -> str:
    """The machine file of a design that ran, with the run-up of the specification."""
    if one.machine is None or id(one) not in place:
        return ""
    machine = driven(spec, one.machine, spec.fastest, coasting=False)
    return machine_text(in_author_units(with_author_springs(machine, spec.machine), spec.machine))


def _attributes(spec: Spec, how: str) -> dict[str, Any]:
    return {
        "title": f"Design{f' {spec.name}' * (spec.name not in ('design', spec.machine.name))} for {spec.machine.name}",
        **provenance(),
        "machine_name": spec.machine.name,
        "design_name": spec.name,
        "specification": json.dumps(spec.identity()),
        "limits": json.dumps(spec.limits),
        "unbalance_range": list(spec.unbalance),
        "temperature_range": list(spec.temperature),
        "speeds": list(spec.operation.speeds),
        "objectives": list(spec.search.objectives),
        "share": spec.share,
        "members": spec.search.members,
        "seed": spec.search.seed,
        "searched_by": how,
        **({"input_text": "\n".join(spec.remarks)} if spec.remarks else {}),
    }
