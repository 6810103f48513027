"""Room for samples, and the sample of an instant."""

from __future__ import annotations

from autobalancer.kernels.chamber.chamber import Chamber, Samples
from autobalancer.kernels.chamber.records import MOTION, SAMPLE


def room_for(chamber: Chamber, count: int, every: int) -> Samples:
    """Room for ``count`` samples, each after ``every`` steps."""
    return Samples(every, SAMPLE.rows(count), MOTION.rows(count, chamber.balls.shape[0]))


def sample_now(chamber: Chamber) -> Samples:
    """The sample of the state as it is, with reactions of this instant."""
    from autobalancer.kernels.chamber.samples import note_sample

    since = chamber.since.copy()
    for name in ("bearing_1", "bearing_2", "constraint"):
        since[name] = chamber.body[name]
    samples = room_for(chamber, 1, 1)
    note_sample(chamber._replace(since=since), 1.0, samples.rows[0], samples.balls[0])
    return samples
