"""A system at a steady drive, with the unbalance after all schedules."""

from __future__ import annotations

import numpy as np

from autobalancer.kernels.system import Drive, System


def steadily(system: System, drive: Drive) -> System:
    """The same with another drive, in all of whose segments the loads are the last ones."""
    loads = np.repeat(system.host.loads[-1:], len(drive.segments), axis=0)
    return system._replace(drive=drive, host=system.host._replace(loads=loads))
