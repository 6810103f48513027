"""Whether the drag law of a study holds for its balls: seen in one member of each point, run alone."""

from __future__ import annotations

import numpy as np

from autobalancer.errors import AutobalancerError, unwarned
from autobalancer.simulation.run import simulate_races
from autobalancer.simulation.sampling import Envelope
from autobalancer.studies.study.chunk import Made
from autobalancer.studies.study.outputs import RUN
from autobalancer.studies.study.spec import Study

MOST = 8  # points that are looked at, the first and the last among them


def drag_note(study: Study) -> str:
    """What a run of such a member says of the range of its drag law, of the point at which it is left furthest; else empty."""
    if RUN not in study.results or study.sudden is not None:
        return ""
    worst, text = 0.0, ""
    for number in np.unique(np.linspace(0, len(study.points) - 1, MOST).astype(int)).tolist():
        try:
            made = Made(study, number, number + 1)
            assembly, _ = made.members.ready(0, made.plan)
            if not any(ball.drag_curve is not None or ball.slipstream or ball.stokes for ball in assembly.balls):
                break  # the drag is given as a number
            with unwarned():
                run = simulate_races(
                    made.members.machine_of(0),
                    duration=study.duration,
                    save=[Envelope(study.bins)],
                    tolerance=study.tolerance,
                    seed=int(made.members.seeds[0]),
                )
        except AutobalancerError:  # it is impossible, and its reason stands with the members
            continue
        over = float(run.attrs.get("drag_reynolds", 0.0)) / float(run.attrs.get("drag_reynolds_limit", np.inf))
        if run.attrs.get("drag_warning") and over > worst:
            worst, text = over, str(run.attrs["drag_warning"])
    return text
