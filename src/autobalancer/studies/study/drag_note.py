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
    made = Made(study, 0, len(study.points))
    worst, text = 0.0, ""
    for number in np.unique(np.linspace(0, made.members.count - 1, MOST).astype(int)).tolist():
        if number in made.reasons:
            continue
        try:
            assembly, _ = made.members.ready(number, made.plan)
            if not any(ball.drag_curve is not None or ball.slipstream or ball.stokes for ball in assembly.balls):
                break  # the drag is given as a number
            with unwarned():
                run = simulate_races(
                    made.members.machine_of(number),
                    duration=study.duration,
                    save=[Envelope(study.bins)],
                    tolerance=study.tolerance,
                    seed=int(made.members.seeds[number]),
                )
        except AutobalancerError:  # the member has its reason
            continue
        over = float(run.attrs.get("drag_reynolds", 0.0)) / float(run.attrs.get("drag_reynolds_limit", np.inf))
        if run.attrs.get("drag_warning") and over > worst:
            worst, text = over, str(run.attrs["drag_warning"])
    return text
