"""Which class shows which answer: a file keeps its name, and what is read back shows itself as before."""

from __future__ import annotations

from importlib import import_module

import xarray as xr

from autobalancer.results.answers.answer import Answer

PACKAGE = "autobalancer"
HOMES = {  # modules, some of them above this one, imported when such an answer is read
    "Balancing": "measurement.balancing.balance",
    "BallFilm": "results.answers.run",
    "BifurcationCurves": "stability.diagrams.explorer",
    "BorderCurve": "stability.maps.curve",
    "Branches": "stability.diagrams.explorer",
    "Campbell": "rotordynamics.question",
    "ChamberDesigns": "results.answers.chamber",
    "ChamberRun": "simulation.chamber.run",
    "ChamberStudy": "results.answers.chamber",
    "Comparison": "results.answers.run",
    "CriticalSpeeds": "rotordynamics.question",
    "Designed": "studies.design.answer",
    "Eigenvalues": "stability.states.questions",
    "Ends": "results.answers.studied",
    "Ensemble": "results.answers.studied",
    "Equilibria": "stability.states.questions",
    "FourRun": "measurement.balancing.four_run",
    "FittedReceptance": "rotordynamics.receptance.answer",
    "Labeled": "results.answers.answer",
    "LiquidResponse": "rotordynamics.liquid",
    "Measured": "results.answers.measured",
    "Modes": "rotordynamics.question",
    "PlaneUnbalances": "measurement.balancing.run_down",
    "Overlay": "results.answers.run",
    "PlanarOscillators": "rotordynamics.question",
    "Orders": "results.signals",
    "RaceShape": "measurement.race",
    "Ranges": "stability.states.questions",
    "Response": "rotordynamics.question",
    "ResponsePeaks": "rotordynamics.question",
    "Run": "results.answers.run",
    "Sensitivity": "results.answers.studied",
    "Signals": "results.signals",
    "Spectrum": "results.signals",
    "StabilityMap": "stability.maps.curve",
    "SteppedResponse": "results.answers.run",
    "Studied": "results.answers.studied",
    "Swept": "results.answers.studied",
    "TorsionalCriticalSpeeds": "rotordynamics.torsion",
    "TorsionalModes": "rotordynamics.torsion",
    "TorsionalResponse": "rotordynamics.torsion",
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
