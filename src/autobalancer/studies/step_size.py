"""Which step a contact needs: two equal balls collide head on, again and again, at another phase of the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.impacts import contact_time, energy_error
from autobalancer.random_numbers import generator
from autobalancer.results.answers.answer import Labeled
from autobalancer.results.provenance import provenance
from autobalancer.units import list_argument

Floats = NDArray[np.float64]
SCHEMES = ("runge_kutta", "velocity_verlet")


def step_size(
    speeds: Sequence[float | str] = (4.0, 6.0, 8.0, 10.0),
    steps: Sequence[float | str] = (1e-4, 1e-5, 1e-6, 1e-7),
    *,
    stiffness_over_mass: float,
    restitution: float = 1.0,
    phases: int = 200,
    seed: int = 0,
    scheme: str = "runge_kutta",
    progress: Callable[[int, int], None] | None = None,
) -> xr.Dataset:
    """Error of the energy after a central collision, over the step, the speed, and where in a step the contact begins.

    Law of Pakuła (2021), (15): k d^1.5 in approach, the square of the restitution of it in separation; appendix 2 and
    table 5 take an elastic one. The source uses one phase for each entry and therefore finds one sign only.

    Parameters
    ----------
    speeds
        Relative speeds of the balls (m/s).
    steps
        Steps of the integration (s).
    stiffness_over_mass
        k/m of one ball (m^-0.5 s^-2), such as 1e10.
    restitution
        Ratio of the speeds after and before.
    phases
        Number of collisions, with the beginning of the contact anywhere in a step.
    seed
        Of these beginnings.
    scheme
        ``"runge_kutta"``, the classical one of the source, or ``"velocity_verlet"``.
    progress
        Called with (collisions done, in all) after each pair of speed and step.

    Returns
    -------
    xarray.Dataset
        Over ``relative_speed``, ``step`` and ``phase_number``: ``energy_error``, relative to the energy before; over the
        first two ``greatest``, ``least``, ``mean``, ``root_mean_square`` of it, ``share_of_gains`` with more energy than
        exact, ``contact_time`` (s); for the elastic contact under Runge-Kutta ``expected_root_mean_square``, that of the
        leading order for these collisions, and ``typical_root_mean_square`` with the end of the contact, too, anywhere in a
        step, which grows with the step to the power 2.5 and the root of the speed.

    Raises
    ------
    QuestionError
        If a number is not possible.
    """
    speeds = list_argument("speeds", speeds, "m/s")
    steps = list_argument("steps", steps, "s")
    _check(speeds, steps, stiffness_over_mass, restitution, phases, scheme)
    start = generator(seed).random(phases)
    error = np.empty((len(speeds), len(steps), phases))
    expected = np.full(error.shape[:2], np.nan)
    typical = np.full_like(expected, np.nan)
    other = generator(seed).random((2, 4000))
    done = 0
    for i, speed in enumerate(speeds):
        for j, step in enumerate(steps):
            after = _collide(speed, step, stiffness_over_mass, restitution, start, scheme)
            error[i, j] = (after / speed) ** 2 - restitution**2
            if scheme == "runge_kutta" and restitution == 1.0:
                ended = start + contact_time(speed, stiffness_over_mass) / step
                for cell, entry, end in ((expected, start, ended), (typical, *other)):
                    likely = energy_error(speed, step, stiffness_over_mass, 1.0 - entry, 1.0 - (-end) % 1.0)
                    cell[i, j] = np.sqrt(np.mean(likely**2))
            done += phases
            if progress is not None:
                progress(done, error.size)
    return _dataset(error, expected, typical, speeds, steps, stiffness_over_mass, restitution, seed, scheme)


def _collide(speed: float, step: float, k: float, restitution: float, phase: Floats, scheme: str) -> Floats:
    """Relative speeds after the collision; the distance closes from a part of a step before the contact."""
    gap = speed * step * phase
    rate = np.full_like(gap, -speed)
    recovered = restitution**2
    end = 1.5 * contact_time(speed, k) * (1.0 + 1.0 / max(restitution, 0.1)) + 20.0 * step

    def pull(gap: Floats, rate: Floats) -> Floats:
        depth = np.maximum(-gap, 0.0)
        return 2.0 * k * depth * np.sqrt(depth) * np.where(rate > 0.0, recovered, 1.0)

    for _ in range(int(np.ceil(end / step))):
        if scheme == "velocity_verlet":
            rate = rate + 0.5 * step * pull(gap, rate)
            gap = gap + step * rate
            rate = rate + 0.5 * step * pull(gap, rate)
            continue
        a1 = pull(gap, rate)
        v2 = rate + 0.5 * step * a1
        a2 = pull(gap + 0.5 * step * rate, v2)
        v3 = rate + 0.5 * step * a2
        a3 = pull(gap + 0.5 * step * v2, v3)
        v4 = rate + step * a3
        a4 = pull(gap + step * v3, v4)
        gap = gap + step / 6.0 * (rate + 2.0 * v2 + 2.0 * v3 + v4)
        rate = rate + step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return rate


def _check(
    speeds: Sequence[float], steps: Sequence[float], k: float, restitution: float, phases: int, scheme: str
) -> None:
    for name, values in (("speeds", speeds), ("steps", steps), ("stiffness_over_mass", [k])):
        if len(values) == 0 or not all(np.isfinite(value) and value > 0.0 for value in values):
            raise QuestionError(f"{name}: given {list(values)}; must be numbers greater than zero")
    if not 0.0 < restitution <= 1.0:
        raise QuestionError(f"restitution: given {restitution:g}; must be above 0, at most 1")
    if phases < 1:
        raise QuestionError(f"phases: given {phases}; must be at least 1")
    if scheme not in SCHEMES:
        raise QuestionError(f"scheme: given {scheme!r}; must be one of {', '.join(SCHEMES)}")


def _dataset(
    error: Floats,
    expected: Floats,
    typical: Floats,
    speeds: Sequence[float],
    steps: Sequence[float],
    k: float,
    restitution: float,
    seed: int,
    scheme: str,
) -> xr.Dataset:
    dims = ("relative_speed", "step")
    found = xr.Dataset(
        coords={
            "relative_speed": ("relative_speed", list(speeds), {"units": "m/s", "long_name": "relative speed"}),
            "step": ("step", list(steps), {"units": "s", "long_name": "step"}),
        },
        attrs={
            "title": "Energy error of a step in a central collision",
            "stiffness_over_mass": k,
            "restitution": restitution,
            "seed": seed,
            "scheme": scheme,
            **provenance(),
        },
    )
    found["energy_error"] = ((*dims, "phase_number"), error)
    found["greatest"] = (dims, error.max(axis=2))
    found["least"] = (dims, error.min(axis=2))
    found["mean"] = (dims, error.mean(axis=2))
    found["root_mean_square"] = (dims, np.sqrt((error**2).mean(axis=2)))
    found["share_of_gains"] = (dims, (error > 0.0).mean(axis=2))
    found["expected_root_mean_square"] = (dims, expected)
    found["typical_root_mean_square"] = (dims, typical)
    found["contact_time"] = ("relative_speed", [contact_time(speed, k) for speed in speeds], {"units": "s"})
    texts = {
        "energy_error": "energy error after the collision over the energy before",
        "greatest": "greatest energy error",
        "least": "least energy error",
        "mean": "mean energy error",
        "root_mean_square": "root mean square of the energy error",
        "share_of_gains": "share of the collisions that gain energy",
        "expected_root_mean_square": "root mean square to leading order in the step",
        "typical_root_mean_square": "the same with the end of the contact anywhere in a step",
        "contact_time": "duration of the contact, elastic",
    }
    for name, text in texts.items():
        found[name].attrs.setdefault("units", "1")
        found[name].attrs["long_name"] = text
    return Labeled.of(found)
