"""Which class shows which answer: a file keeps its name, and what is read back shows itself as before."""

from __future__ import annotations

from importlib import import_module

import xarray as xr

from autobalancer.results.answers.answer import Answer

PACKAGE = "autobalancer"
HOMES = {  # modules, some of them above this one, imported when such an answer is read
    "Balancing": "measurement.balancing.answer",
    "BallFilm": "results.answers.ball_film",
    "BifurcationCurves": "stability.diagrams.answers",
    "BorderCurve": "stability.maps.answers",
    "Branches": "stability.diagrams.answers",
    "Campbell": "rotordynamics.answers",
    "ChamberDesigns": "results.answers.chamber_designs",
    "ChamberRun": "simulation.chamber.run",
    "ChamberStudy": "results.answers.chamber_study",
    "Comparison": "results.answers.comparison",
    "CriticalSpeeds": "rotordynamics.answers",
    "Designed": "studies.design.answer",
    "Eigenvalues": "stability.states.answers",
    "Ends": "results.answers.ends",
    "Ensemble": "results.answers.ensemble",
    "Equilibria": "stability.states.answers",
    "FourRun": "measurement.balancing.four_run",
    "FittedReceptance": "rotordynamics.receptance.answer",
    "Labeled": "results.answers.labeled",
    "LiquidResponse": "rotordynamics.liquid.response",
    "Measured": "results.answers.measured",
    "Modes": "rotordynamics.answers",
    "PlaneUnbalances": "measurement.balancing.run_down",
    "Overlay": "results.answers.overlay",
    "PlanarOscillators": "rotordynamics.answers",
    "Orders": "results.signals.orders",
    "RaceShape": "measurement.race.roundness",
    "Ranges": "stability.states.answers",
    "Response": "rotordynamics.answers",
    "ResponsePeaks": "rotordynamics.answers",
    "Run": "results.answers.run",
    "Sensitivity": "results.answers.sensitivity",
    "ShearedDrag": "flow.ball.sheared_question",
    "Signals": "results.signals.signals",
    "Spectrum": "results.signals.spectrum",
    "StabilityMap": "stability.maps.answers",
    "SteppedResponse": "results.answers.stepped",
    "Studied": "results.answers.studied",
    "Swept": "results.answers.swept",
    "TorsionalCriticalSpeeds": "rotordynamics.torsion.answers",
    "TorsionalModes": "rotordynamics.torsion.answers",
    "TorsionalResponse": "rotordynamics.torsion.answers",
}


def kind_of(found: xr.Dataset) -> str:
    """Name of its class; empty for a plain dataset."""
    return type(found).__name__ if isinstance(found, Answer) else ""


def as_kind(found: xr.Dataset, kind: str) -> xr.Dataset:
    """The same data as an answer of that name; of a name that this version does not know, a plain dataset.

    Runs of earlier versions, which kept no name, are recognized.
    """
    if not kind and "outcome_text" in found.attrs:
        kind = "ChamberRun" if "body_position" in found else "Run"
    if kind not in HOMES:
        return found
    home: type[Answer] = getattr(import_module(f"{PACKAGE}.{HOMES[kind]}"), kind)
    return home.of(found)
