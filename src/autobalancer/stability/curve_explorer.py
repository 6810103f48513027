"""All connected curves: steady states, what branches off them, and the orbits born at their Hopf points."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.arrays import Floats
from autobalancer.results.answers.answer import Answer, Form
from autobalancer.results.display_units import axis_unit
from autobalancer.stability.bifurcations import (
    Loop,
    NoConvergence,
    Point,
    Special,
    Steps,
    at_parameter,
    correct,
    follow,
    special_points,
    tangent_at,
)
from autobalancer.stability.periodic_orbits import FIRST_AMPLITUDE, Mesh, Orbits, Row, follow_orbits, steady_row
from autobalancer.stability.steady_curves import Groups, Range, Steady, signature
from autobalancer.tables import Column

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
class SpecialPoint:
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
        self.specials: list[SpecialPoint] = []

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
            result = waiting.popleft()
            if result.used or result.steady is None:
                continue
            result.used, seen = True, len(self.specials)
            for groups, way in result.special.onward:
                self._switched(result, result.steady, groups, way)
            waiting.extend(f for f in self.specials[seen:] if f.special.onward)

    def tail(self) -> float:
        """Size of the highest harmonic that was counted, greatest of all steady states."""
        steady = [branch for branch in self.branches if branch.problem is not None]
        return max((b.problem.tail(p.u) for b in steady if b.problem for p in b.points), default=0.0)

    def orbits(self) -> None:
        """Follow the periodic orbits born at every Hopf point."""
        for result in [f for f in self.specials if f.special.kind == "Hopf"]:
            if result.used or result.steady is None or result.steady.loose or len(self.branches) >= self.limit:
                continue
            result.used = True
            try:
                problem, u, way = _born_at(self.span, result.steady.groups, result.special, self.intervals)
            except (NoConvergence, np.linalg.LinAlgError):
                continue
            number = self._open("orbit")
            self.branches[number].rows = [result.row, *self._follow_orbits(number, problem, u, way, born=True)]

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
        # piece by piece; special points that end a branch (a symmetry, a continuum) cut the piece
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
        # a row for each point, found once the branch is complete
        branch.points = points
        branch.rows = [steady_row(problem, point.u) for point in points]
        if len(points) < 2:
            self.branches.pop(number)
        return len(points) > 1

    def _switched(self, found: SpecialPoint, old: Steady, groups: Groups, way: Floats) -> None:
        """What branches off: balls joined, balls split along ``way``, or another direction of the same balls."""
        # the point in the unknowns of the new branch, whose balls are grouped otherwise
        u = found.special.point.u
        new = Steady(self.span, groups)
        here = np.append(new.gathered(old.state(u)), u[-1])
        if found.row.name == "balanced" and new.freedom_or_none(here):
            return  # a continuum of balanced states, of which the curve of two bundles is followed
        # directions in which it leaves: that of the kernel both ways, or one where both ways are the same by exchange
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
        # a small step off the old branch, corrected on the new one, then followed
        followed = 0
        for like in likes:
            row = like * new.weight
            try:
                first = correct(new, here + OFF * like, row, float(row @ here) + OFF)[0]
            except (NoConvergence, np.linalg.LinAlgError):
                continue
            if 0.0 <= first[-1] <= 1.0 and not self._known(new, first):
                followed += self._steady(new, first, (first - here) / OFF, here)
        if followed == 2:  # two that leave in opposite directions are one branch
            other, branch = self.branches.pop(), self.branches[-1]
            branch.rows = [*reversed(other.rows), *branch.rows[1:]]
            branch.points = [*reversed(other.points), *branch.points[1:]]
            for result in self.specials:
                result.branch = min(result.branch, len(self.branches) - 1)

    def _note(self, special: Special, number: int, problem: Steady) -> None:
        row = steady_row(problem, special.point.u)
        mark = signature(self.span.whole(row.share).host, row.state)
        for other in self.specials:
            same_place = abs(other.row.share - row.share) < 1e-7 and other.steady is not None
            if same_place and np.abs(signature(self.span.whole(row.share).host, other.row.state) - mark).max() < 1e-5:
                return
        self.specials.append(SpecialPoint(special, number, row, problem))

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
        self.specials += [SpecialPoint(special, number, row, None) for special, row in part.specials]
        self.branches[number].ended = part.ended
        if part.ended == "Hopf":  # the point at which an orbit has shrunk to nothing needs no branch of its own
            share = part.rows[-1].share
            open_ends = [f for f in self.specials if f.special.kind == "Hopf" and not f.used]
            near = min(open_ends, key=lambda f: abs(f.row.share - share), default=None)
            if near is not None and abs(near.row.share - share) < 0.02:
                near.used = True
        return part.rows


def _born_at(span: Range, groups: Groups, hopf: Special, intervals: int) -> tuple[Orbits, Floats, Floats]:
    """The problem, a small orbit that is born at a Hopf point, and the direction in which it grows."""
    mesh = Mesh(np.linspace(0.0, 1.0, intervals + 1))
    turn = np.exp(2j * np.pi * mesh.nodes)[:, None]
    swing = 2.0 * (hopf.mode * turn).real
    center = np.broadcast_to(hopf.point.u[:-1], swing.shape)
    problem = Orbits(span, groups, (0,) * len(groups), mesh, 2.0 * math.pi / hopf.frequency, swing)
    u = np.append(center.ravel(), [0.0, hopf.point.u[-1]])
    way = np.append(swing.ravel(), [0.0, 0.0])
    row = way * problem.weight
    amplitude = FIRST_AMPLITUDE
    while True:  # at amplitude zero the period has no effect and the equations are singular: step off first
        try:
            first = correct(problem, u + amplitude * way, row, float(row @ (u + amplitude * way)))[0]
            return problem, first, way / math.sqrt(float(problem.weight @ way**2))
        except NoConvergence:
            amplitude *= 0.5
            if amplitude < 1e-4:
                raise


# Branches and special points as a labeled dataset.


def stable_ranges(branches: xr.Dataset, number: int) -> list[tuple[float, float]]:
    """Ranges of the parameter (begin, end in the order of the branch, SI) in which a branch is not unstable."""
    part = branches.isel(point=np.flatnonzero(branches["branch"].values == number))
    good, values = part["verdict"].values != "unstable", part["parameter"].values
    inside = good[1:] & good[:-1]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(int)))
    return [(float(values[a]), float(values[b])) for a, b in edges.reshape(-1, 2)]


# Branches as tables: one row for each branch, and one for each special point.


SPECIAL = ("special_parameter", "special_frequency", "lyapunov_coefficient", "special_deflection_max", "special_period")


class Branches(Answer):
    """Branches of steady states and periodic motions along a parameter."""

    __slots__ = ()
    shown_as = Form(
        row_of="point",
        needed=("parameter", "branch", "name", "kind", "verdict"),
        known=frozenset({"branch_ends", "machine_name", "ignores"}),
    )

    def branch_rows(self) -> list[dict[str, Any]]:
        """Number, kind, name, ends (SI) and stable ranges of each branch."""
        rows = []
        for number, ended in enumerate(self.attrs["branch_ends"], 1):
            part = self.isel(point=np.flatnonzero(self["branch"].values == number))
            if not part.sizes["point"]:  # cut out
                continue
            names, counts = np.unique(part["name"].values, return_counts=True)
            rows.append(
                {
                    "branch": number,
                    "kind": str(part["kind"].values[0]),
                    "name": str(names[np.argmax(counts)]),
                    "from": float(part["parameter"].values[0]),
                    "to": float(part["parameter"].values[-1]),
                    "lowest": float(part["parameter"].min()),
                    "highest": float(part["parameter"].max()),
                    "ended": ended,
                    "stable": stable_ranges(self, number),
                }
            )
        return rows

    def special_rows(self) -> list[dict[str, Any]]:
        """Type, branch, criticality and numbers (SI) of each special point; None where one is not known."""
        rows = []
        for i in range(self.sizes["special"]):
            row = {"type": str(self["special_type"].values[i]), "branch": int(self["special_branch"].values[i])}
            row["criticality"] = str(self["criticality"].values[i])
            numbers = {name.removeprefix("special_"): float(self[name].values[i]) for name in SPECIAL}
            rows.append({**row, **{key: value if math.isfinite(value) else None for key, value in numbers.items()}})
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Motion, range of the parameter, where it is stable, and how the branch ended."""
        shown_in, rows = axis_unit(self["parameter"], unit or "rpm"), self.branch_rows()

        def shown(value: float) -> str:
            return f"{value * shown_in.factor:.6g}"

        def span(stable: list[tuple[float, float]]) -> str:
            ends = sorted(sorted(pair) for pair in stable)
            parts = [shown(a) if shown(a) == shown(b) else f"{shown(a)} to {shown(b)}" for a, b in ends]
            return ", ".join(parts) or "nowhere"

        ends = [[row[key] * shown_in.factor for row in rows] for key in ("lowest", "highest")]
        return [
            Column("branch", [row["branch"] for row in rows]),
            Column("motion", [row["name"] for row in rows], wraps=True),
            Column("lowest", ends[0], shown_in.sign, ".6g"),
            Column("highest", ends[1], shown_in.sign, ".6g"),
            Column("stable or marginal", [span(row["stable"]) for row in rows], shown_in.sign, wraps=True),
            Column("ended", [row["ended"] for row in rows], wraps=True),
        ]

    def special_columns(self, rows: Sequence[dict[str, Any]], unit: str = "") -> list[Column]:
        """Special points, all or some of :meth:`special_rows`."""
        shown_in = axis_unit(self["parameter"], unit or "rpm")
        what = [f"{row['type']}, {row['criticality']}" if row["criticality"] else row["type"] for row in rows]
        return [
            Column("branch", [row["branch"] for row in rows]),
            Column("what", what),
            Column("at", [row["parameter"] * shown_in.factor for row in rows], shown_in.sign, ".6g"),
            Column("frequency", [row["frequency"] for row in rows], "rad/s"),
            Column("Lyapunov coefficient", [row["lyapunov_coefficient"] for row in rows]),
        ]

    def heading(self) -> str:
        """Whose they are, along what, and what is left out."""
        ignores = f"; ignores {self.attrs['ignores']}" if self.attrs["ignores"] else ""
        return f"{self.attrs['machine_name']}: branches along {self['parameter'].attrs['long_name']}{ignores}"

    def remarks(self) -> Sequence[str]:
        """How many special points there are, and what is not followed."""
        count = self.sizes.get("special", 0)
        result = [f"{count} special points: special_rows() lists them"] if count else []
        return result + self.not_followed()

    def not_followed(self) -> list[str]:
        """Why motions are missing, if any may be."""
        why = self.attrs.get("not_followed")
        return [f"periodic motions: {why}"] if why else []
