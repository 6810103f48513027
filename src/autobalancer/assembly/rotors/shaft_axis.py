"""Places on a shaft and on the rigid bodies fixed to it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from autobalancer.assembly.rotors.model import Rows
from autobalancer.assembly.rotors.shaft_mesh import Mesh
from autobalancer.machine import Disk
from autobalancer.machine.rotors.shaft import SAME

INSIDE = 4  # places drawn along an element


@dataclass(frozen=True)
class ShaftAxis:
    """The axis of a shaft; coordinates are deflection and rotation of each node in turn."""

    mesh: Mesh
    disks: tuple[Disk, ...]

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.model.Axis`; ``None`` is the mass center of the only disk."""
        if body is not None:
            return self._named(position, body)
        if position is None:
            if len(self.disks) > 1:
                raise ValueError(f"missing; the shaft carries {len(self.disks)} disks, so say where along it")
            return self.on_disk(self.disks[0]) if self.disks else self.on_shaft(0.5 * float(self.mesh.nodes[-1]))
        end = float(self.mesh.nodes[-1])
        if -SAME * end <= position <= end * (1.0 + SAME):
            return self.on_shaft(position)
        reaching = [disk for disk in self.disks if _reaches(disk, position)]
        if len(reaching) == 1:
            return self.on_disk(reaching[0], position)
        if reaching:
            raise ValueError(f"position {position:g} m: {len(reaching)} disks reach there; name one of them as 'body'")
        arms = "".join(
            f"; disk {disk.name or number} from {disk.reach[0]:g} to {disk.reach[1]:g} m"
            for number, disk in enumerate(self.disks, 1)
            if disk.reach[0] < 0.0 or disk.reach[1] > end
        )
        raise ValueError(
            f"position {position:g} m: nothing is there; the shaft reaches from 0 to {end:g} m{arms}; "
            "a longer 'extent' of a disk reaches farther"
        )

    def on_shaft(self, position: float) -> Rows:
        """Rows of a position on the shaft, between nodes by the shapes of the element."""
        nodes = self.mesh.nodes
        i = min(max(int(np.searchsorted(nodes, position)) - 1, 0), nodes.size - 2)
        share = np.clip((position - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.0, 1.0)
        w, psi = self.mesh.elements[i].shapes(share)
        deflection, slope = np.zeros((2, 2 * nodes.size))
        deflection[2 * i : 2 * i + 4], slope[2 * i : 2 * i + 4] = w, psi
        return Rows(deflection, slope)

    def on_disk(self, disk: Disk, position: float | None = None) -> Rows:
        """Rows of a position on the rigid arm of a disk, by default of its mass center."""
        foot = self.on_shaft(float(disk.position))
        arm = float(disk.offset) if position is None else position - float(disk.position)
        return Rows(foot.deflection + arm * foot.slope, foot.slope)

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.model.Axis`; with the arms that stick out of the ends."""
        nodes = self.mesh.nodes
        places = [z + share * (after - z) for z, after in pairwise(nodes) for share in np.arange(INSIDE) / INSIDE]
        line = [(float(z), self.on_shaft(float(z))) for z in [*places, nodes[-1]]]
        for disk in self.disks:
            low, high = disk.reach
            if low < 0.0 and all(other is disk or other.reach[0] >= 0.0 for other in self.disks):
                line.insert(0, (low, self.on_disk(disk, low)))
            if high > nodes[-1] and all(other is disk or other.reach[1] <= nodes[-1] for other in self.disks):
                line.append((high, self.on_disk(disk, high)))
        return line

    def _named(self, position: float | None, body: str) -> Rows:
        found = [disk for disk in self.disks if disk.name == body]
        if not body or not found:
            known = ", ".join(repr(disk.name) for disk in self.disks if disk.name) or "none with a name"
            raise ValueError(f"body {body!r}: no disk has this name; there is {known}")
        if position is not None and not _reaches(found[0], position):
            low, high = found[0].reach
            raise ValueError(f"position {position:g} m: disk {body!r} reaches from {low:g} to {high:g} m only")
        return self.on_disk(found[0], position)


def _reaches(disk: Disk, position: float) -> bool:
    low, high = disk.reach
    slack = SAME * max(abs(low), abs(high), high - low)
    return low - slack <= position <= high + slack
