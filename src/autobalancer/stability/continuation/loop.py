"""Does a curve come back to where it was?"""

from __future__ import annotations

import numpy as np

from autobalancer.stability.host.planar import Floats

AWAY = 12  # points before which a curve cannot have come back
NEAR = 0.03  # distance from the chord of a step, in units of its length


class Loop:
    """Watches for a return to the start, then to places at ever longer intervals (Brent 1980)."""

    def __init__(self, place: Floats) -> None:
        self.place, self.steps, self.next = place, 0, 4 * AWAY

    def closed(self, a: Floats, b: Floats) -> bool:
        """Whether the step from ``a`` to ``b`` passes the place."""
        self.steps += 1
        chord = b - a
        length = float(np.linalg.norm(chord))
        if self.steps > AWAY and length > 0.0:
            share = float((self.place - a) @ chord) / length**2
            if 0.0 <= share <= 1.0 and np.linalg.norm(self.place - a - share * chord) < NEAR * length:
                return True
        if self.steps == self.next:
            self.place, self.steps, self.next = b, 0, 2 * self.next
        return False
