"""All connected curves: steady states, what branches off them, and the orbits born at their Hopf points."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from autobalancer.stability.continuation.bifurcations import special_points
from autobalancer.stability.continuation.follow import (
    NoConvergence,
    Point,
    Steps,
    at_parameter,
    correct,
    follow,
    tangent_at,
)
from autobalancer.stability.continuation.loop import Loop
from autobalancer.stability.continuation.special import Special
from autobalancer.stability.continuation.steady import Range, Steady
from autobalancer.stability.continuation.symmetry import Groups, signature
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.periodic.branch import follow_orbits
from autobalancer.stability.periodic.orbits import Orbits, born_at
from autobalancer.stability.periodic.rows import Row, steady_row

Progress = Callable[[int, float], None]
OFF = 0.02  # first step on a branch that leaves another one


@dataclass
class Branch:
    """One curve: its points in order, and where it came from."""

    kind: str  # equilibrium, orbit
    rows: list[Row] = field(default_factory=list)
    points: list[Point] = field(default_factory=list)
    problem: Steady | None = None
    ended: str = "end of the range"


@dataclass
class Found:
    """A special point on a branch."""

    special: Special
    branch: int
    row: Row
    steady: Steady | None
    used: bool = False


class Explorer:
    """Follows branches from given starts until nothing new is left."""

    def __init__(
        self,
        span: Range,
        kind: list[tuple[float, ...]],
        steps: Steps,
        intervals: int,
        limit: int,
        progress: Progress | None,
    ) -> None:
        self.span, self.kind, self.steps, self.intervals, self.limit = span, kind, steps, intervals, limit
        self.progress = progress
        self.branches: list[Branch] = []
        self.specials: list[Found] = []

    def steady_from(self, groups: Groups, state: Floats, share: float = 0.0) -> None:
        """The branch through a steady state of all balls at an end of the range, unless it is known."""
        problem = Steady(self.span, groups)
        guess = np.append(problem.gathered(state), share)
        problem.loose = bool(problem.freedom_or_none(guess))
        try:
            u = at_parameter(problem, guess, share)
        except (NoConvergence, np.linalg.LinAlgError):
            return
        if not self._known(problem, u):
            like = np.zeros(u.size)
            like[-1] = 1.0 if share < 0.5 else -1.0
            self._steady(problem, u, like)

    def orbit_from(self, problem: Orbits, u: Floats, likes: Iterable[float] = (1.0, -1.0)) -> None:
        """The branch of orbits through a given one, to both sides."""
        number, both = self._open("orbit"), []
        for way in likes:
            like = np.zeros(u.size)
            like[-1] = way
            both.append(self._follow_orbits(number, problem, u, like, born=False))
            if self.branches[number].ended == "closed":
                break
        self.branches[number].rows = [*reversed(both[-1]), *both[0][1:]] if len(both) > 1 else both[0]

    def switch(self) -> None:
        """Go on from every branch point that was not used yet, and from the new ones."""
        waiting = deque(f for f in self.specials if f.special.onward)
        while waiting and len(self.branches) < self.limit:
            found = waiting.popleft()
            if found.used or found.steady is None:
                continue
            found.used, seen = True, len(self.specials)
            for groups, way in found.special.onward:
                self._switched(found, found.steady, groups, way)
            waiting.extend(f for f in self.specials[seen:] if f.special.onward)

    def tail(self) -> float:
        """Size of the highest harmonic that was counted, greatest of all steady states."""
        steady = [branch for branch in self.branches if branch.problem is not None]
        return max((b.problem.tail(p.u) for b in steady if b.problem for p in b.points), default=0.0)

    def orbits(self) -> None:
        """Follow the periodic orbits born at every Hopf point."""
        for found in [f for f in self.specials if f.special.kind == "Hopf"]:
            if found.used or found.steady is None or found.steady.loose or len(self.branches) >= self.limit:
                continue
            found.used = True
            try:
                problem, u, way = born_at(self.span, found.steady.groups, found.special, self.intervals)
            except (NoConvergence, np.linalg.LinAlgError):
                continue
            number = self._open("orbit")
            self.branches[number].rows = [found.row, *self._follow_orbits(number, problem, u, way, born=True)]

    def _open(self, kind: str) -> int:
        self.branches.append(Branch(kind))
        return len(self.branches) - 1

    def _say(self, number: int, share: float) -> None:
        if self.progress is not None:
            self.progress(number + 1, min(max(share, 0.0), 1.0))

    def _steady(self, problem: Steady, start: Floats, like: Floats, origin: Floats | None = None) -> bool:
        """A branch from a start on, which lies just beyond the branch point ``origin`` if there is one."""
        number = self._open("equilibrium")
        branch = self.branches[number]
        branch.problem, branch.ended = problem, "could not be followed further"
        points, loop = [Point(start if origin is None else origin, like)], Loop(start)
        steps = self.steps if origin is None else replace(self.steps, first=OFF)
        for _, a, b in follow(problem, start, like, steps=steps):
            specials = special_points(problem, self.kind, a, b)
            if origin is not None and len(points) == 1:
                points.append(a)
            end = next((s for s in specials if s.ends), None)
            for special in specials[: specials.index(end) + 1] if end else specials:
                self._note(special, number, problem)
                points.append(special.point)
            self._say(number, float(b.u[-1]))
            if end:
                branch.ended = end.kind
                break
            points.append(b)
            if loop.closed(a.u, b.u):
                branch.ended = "closed"
                break
            if not 0.0 < b.u[-1] < 1.0:
                branch.ended = "end of the range"
        branch.points = points
        branch.rows = [steady_row(problem, point.u) for point in points]
        if len(points) < 2:
            self.branches.pop(number)
        return len(points) > 1

    def _switched(self, found: Found, old: Steady, groups: Groups, way: Floats) -> None:
        """What branches off: balls joined, balls split along ``way``, or another direction of the same balls."""
        u = found.special.point.u
        new = Steady(self.span, groups)
        here = np.append(new.gathered(old.state(u)), u[-1])
        if found.row.name == "balanced" and new.freedom_or_none(here):
            return  # a continuum of balanced states, of which the curve of two bundles is followed
        if way.size == u.size and groups == old.groups:
            likes = [way, -way]
        elif way.any():
            like = np.zeros(here.size)
            like[new.angles] = way / np.linalg.norm(way)
            sizes = {len(g) for g, w in zip(groups, way, strict=True) if w}
            likes = [like] if len(sizes) == 1 else [like, -like]
        else:
            try:
                along = tangent_at(new, here, np.eye(here.size)[-1])
            except np.linalg.LinAlgError:
                return
            likes = [along, -along]
        followed = 0
        for like in likes:
            row = like * new.weight
            try:
                first = correct(new, here + OFF * like, row, float(row @ here) + OFF)[0]
            except (NoConvergence, np.linalg.LinAlgError):
                continue
            if 0.0 <= first[-1] <= 1.0 and not self._known(new, first):
                followed += self._steady(new, first, (first - here) / OFF, here)
        if followed == 2:
            self._sew()

    def _sew(self) -> None:
        """The last two branches leave a branch point in opposite directions: they are one."""
        second, first = self.branches.pop(), self.branches[-1]
        first.rows = [*reversed(second.rows), *first.rows[1:]]
        first.points = [*reversed(second.points), *first.points[1:]]
        for found in self.specials:
            found.branch = min(found.branch, len(self.branches) - 1)

    def _note(self, special: Special, number: int, problem: Steady) -> None:
        row = steady_row(problem, special.point.u)
        mark = signature(self.span.whole(row.share).host, row.state)
        for other in self.specials:
            same_place = abs(other.row.share - row.share) < 1e-7 and other.steady is not None
            if same_place and np.abs(signature(self.span.whole(row.share).host, other.row.state) - mark).max() < 1e-5:
                return
        self.specials.append(Found(special, number, row, problem))

    def _known(self, problem: Steady, u: Floats) -> bool:
        """Whether a branch goes through this state or one that differs by an exchange of equal balls."""
        host = self.span.whole(float(u[-1])).host
        mark = signature(host, problem.state(u))
        for branch in self.branches:
            other = branch.problem
            if other is None:
                continue
            for a, b in zip(branch.points, branch.points[1:], strict=False):
                low, high = sorted((a.u[-1], b.u[-1]))
                if not low - 1e-9 <= u[-1] <= high + 1e-9:
                    continue
                part = 0.5 if high - low < 1e-12 else (u[-1] - a.u[-1]) / (b.u[-1] - a.u[-1])
                try:
                    near = at_parameter(other, a.u + part * (b.u - a.u), float(u[-1]))
                except (NoConvergence, np.linalg.LinAlgError):
                    continue
                if np.abs(signature(host, other.state(near)) - mark).max() < 1e-7:
                    return True
        return False

    def _follow_orbits(self, number: int, problem: Orbits, u: Floats, like: Floats, *, born: bool) -> list[Row]:
        part = follow_orbits(problem, u, like, self.steps.most, born=born, say=lambda share: self._say(number, share))
        self.specials += [Found(special, number, row, None) for special, row in part.specials]
        self.branches[number].ended = part.ended
        if part.ended == "Hopf":
            self._arrived(part.rows[-1].share)
        return part.rows

    def _arrived(self, share: float) -> None:
        """The Hopf point at which an orbit has shrunk to nothing needs no branch of its own."""
        open_ends = [f for f in self.specials if f.special.kind == "Hopf" and not f.used]
        near = min(open_ends, key=lambda f: abs(f.row.share - share), default=None)
        if near is not None and abs(near.row.share - share) < 0.02:
            near.used = True
