"""The fluid in a race: exact solutions, conservation, and the layers that spin it up."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.relaxation import (
    all_modes,
    diffusive_swirl,
    mode_table,
    recorded_speed,
    relaxation_modes,
    wall_speed,
)
from autobalancer.flow.solve import SpectralFlow, chebyshev_grid
from autobalancer.machine import Hill, Ramp

if TYPE_CHECKING:
    from tests.references.flow_differences import DifferenceFlow

RIG = Annulus(69.3e-3, 83.1e-3, 20e-3, 76.95e-3, 20e-6, 950.0)  # Spannan 2021, table 6.2
SOLVERS = ("chebyshev", "differences")


def oil(viscosity: float) -> Annulus:
    return Annulus(69.3e-3, 83.1e-3, 20e-3, 76.95e-3, viscosity, 950.0)


def solver(name: str, annulus: Annulus, points: int, **options: object) -> SpectralFlow | DifferenceFlow:
    if name == "chebyshev":
        return SpectralFlow(annulus, points, points, **options)  # type: ignore[arg-type]
    from tests.references.flow_differences import DifferenceFlow  # compiles: not where tests are only collected

    return DifferenceFlow(annulus, points, points, **options)  # type: ignore[arg-type]


def run(flow: SpectralFlow | DifferenceFlow, speed: object, end: float, **options: object) -> object:
    if isinstance(flow, SpectralFlow):
        return flow.march(speed, end, **({"tolerance": 1e-6} | options))  # type: ignore[arg-type]
    return flow.march(speed, end, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", SOLVERS)
def test_solid_rotation_stays_as_it_is_to_rounding(name: str) -> None:
    flow = solver(name, RIG, 16)
    track = run(flow, wall_speed(60.0), 0.2)
    assert np.abs(flow.swirl).max() == 0.0
    assert np.abs(flow.stream).max() == 0.0
    assert track.orbit[-1] == 60.0  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", SOLVERS)
def test_fluid_between_cylinders_of_unequal_speed_reaches_couette_flow(name: str) -> None:
    """W = A + B/r^2, from rest in the frame of the rotor, lids that turn with it; slow enough for it to be stable."""
    annulus = oil(715e-6)
    walls = Walls(inner=-2.0, outer=3.0)
    flow = solver(name, annulus, 16, walls=walls)
    run(flow, wall_speed(5.0), 0.35)
    swirl = flow.swirl / flow.radius[:, None] ** 2
    a, b, r = annulus.inner, annulus.outer, flow.radius
    exact = ((b * b * 3.0 + a * a * 2.0) + (-5.0) * a * a * b * b / r**2) / (b * b - a * a)
    assert np.abs(swirl - exact[:, None]).max() < (1e-6 if name == "chebyshev" else 5e-4)


def test_gains_of_all_modes_add_up_to_one_and_the_first_is_the_slowest() -> None:
    rates, gains = mode_table(RIG, 60, 200)
    # the axial series is that of Leibniz: its partial sums swing about the limit, their means converge
    partial = gains.sum(axis=0).cumsum()
    assert 0.5 * (partial[-1] + partial[-2]) == pytest.approx(1.0, abs=0.01)
    assert rates.argmin() == 0
    assert rates[0, 0] == pytest.approx(RIG.decay_rate, rel=0.003)


def test_narrow_ring_decays_like_a_slit() -> None:
    """In the limit of a thin ring of great radius the modes are sines: rate nu pi^2 (1/W^2 + 1/H^2), gain (4/pi)^2."""
    slit = Annulus(10.0, 10.001, 2e-3, 10.0005, 1e-6, 1000.0)
    rates, gains = mode_table(slit, 3, 2)
    assert rates[0, 0] == pytest.approx(slit.decay_rate, rel=1e-8)
    assert gains[0, 0] == pytest.approx((4.0 / math.pi) ** 2, rel=1e-6)
    assert gains[2, 0] == pytest.approx(-gains[0, 0] / 3.0, rel=1e-6)


@pytest.mark.parametrize(("name", "points", "error"), [("chebyshev", 20, 2e-4), ("differences", 32, 5e-3)])
def test_impulsive_spin_up_of_a_viscous_fluid_follows_the_exact_series(name: str, points: int, error: float) -> None:
    """So slow a rotor that the secondary flow is nothing; whole field and orbit, early and late."""
    annulus, speed = oil(715e-6), 1e-3
    times = np.array([0.0, 0.002, 0.01, 0.03])
    flow, fields = solver(name, annulus, points), {}
    start = wall_speed(speed, 0.0)
    track = run(
        flow, start, 0.03, stops=times[1:], at_stop=lambda t: fields.update({t: flow.swirl / flow.radius[:, None] ** 2})
    )
    exact = diffusive_swirl(annulus, start, times, flow.radius, flow.height)
    for i, time in enumerate(times[1:], 1):
        inside = (slice(1, -1), slice(1, -1))
        assert np.abs(fields[time][inside] - exact[i][inside]).max() < error * speed
    seen = np.array(track.times)  # type: ignore[attr-defined]
    late = seen > 1e-3
    orbit = all_modes(annulus).response(start, seen)
    assert np.abs(np.array(track.orbit) - orbit)[late].max() < error * speed  # type: ignore[attr-defined]


def test_the_diffusive_lag_behind_a_ramp_solves_poissons_equation() -> None:
    """Lag over rate is -g/r^2 with nu D2 g = r^2: the sum over all modes against one spectral solution."""
    flow = SpectralFlow(RIG, 24, 24)
    r, z = flow.grid.r.family(), flow.grid.z.family()
    shares = r.forward @ np.tile(flow.radius[1:-1, None] ** 2, 23) @ z.forward.T
    shares /= RIG.viscosity * (r.rates[:, None] + z.rates)
    flow.swirl[1:-1, 1:-1] = r.backward @ shares @ z.backward.T
    assert all_modes(RIG).ramp_lag == pytest.approx(-flow.orbit_speed(), rel=1e-4)


@pytest.mark.parametrize("error", [1e-1, 1e-2, 1e-3])
def test_as_many_modes_are_taken_as_the_error_asks_for(error: float) -> None:
    few, all_of_them = relaxation_modes(RIG, error), all_modes(RIG)
    assert abs(few.ramp_lag / all_of_them.ramp_lag - 1.0) <= error
    assert few.rates.size < 60 * error**-0.3


def test_relaxation_modes_stepped_along_a_ramp_in_any_steps_end_alike() -> None:
    modes = relaxation_modes(RIG, 1e-3)
    coarse = modes.step(np.zeros_like(modes.rates), 2.0, 30.0)
    fine = np.zeros_like(modes.rates)
    for _ in range(7):
        fine = modes.step(fine, 2.0 / 7.0, 30.0 / 7.0)
    assert np.abs(coarse - fine).max() < 1e-12
    assert modes.step(np.zeros_like(modes.rates), 100.0, 100.0).sum() == pytest.approx(modes.ramp_lag, rel=1e-12)


@cache
def hill_run(points: int, order: int, steps: int, viscosity: float = 100e-6) -> float:
    """Fluid at the orbit at half time of a smooth run-up, fixed steps, with secondary flow."""
    flow = SpectralFlow(oil(viscosity), points, points, order=order)
    speed = wall_speed(Hill(end=40.0, half_time=0.2, exponent=6.0))
    return flow.march(speed, 0.2, tolerance=1.0, fixed=0.2 / steps).orbit[-1]


@pytest.mark.parametrize("order", [1, 2, 3])
def test_time_integration_of_the_spectral_solver_has_its_order(order: int) -> None:
    exact = hill_run(16, 3, 3200)
    one, two = (abs(hill_run(16, order, steps) - exact) for steps in (400, 800))
    assert math.log2(one / two) == pytest.approx(order, abs=0.1)


def test_the_spectral_solver_gains_digits_with_every_few_points() -> None:
    errors = [abs(hill_run(n, 3, 800) - hill_run(28, 3, 800)) for n in (8, 12, 16, 20)]
    assert errors[0] > 1e-4
    assert errors[2] < 1e-2 * errors[0]
    assert errors[3] < 2e-8 * 40.0


def test_differences_have_order_two_in_space_and_time() -> None:
    from tests.references.flow_differences import DifferenceFlow

    annulus, speed = oil(100e-6), wall_speed(Hill(end=40.0, half_time=0.2, exponent=6.0))
    found = [DifferenceFlow(annulus, n, n).march(speed, 0.2, fixed=0.2 / (4 * n * n)).orbit[-1] for n in (24, 36)]
    exact = hill_run(20, 3, 1600)
    one, two = (abs(value - exact) for value in found)
    assert math.log(one / two) / math.log(1.5) == pytest.approx(2.0, abs=0.1)
    coarse = [DifferenceFlow(annulus, 12, 12).march(speed, 0.2, fixed=0.2 / n).orbit[-1] for n in (250, 500, 4000)]
    rate = math.log2(abs(coarse[0] - coarse[2]) / abs(coarse[1] - coarse[2]))
    assert rate == pytest.approx(2.0, abs=0.1)


@pytest.mark.slow
def test_both_solvers_agree_where_the_secondary_flow_rules() -> None:
    annulus, speed = oil(50e-6), wall_speed(Ramp(end=60.0, duration=0.4))
    moments = {}
    for name, points in (("chebyshev", 24), ("differences", 64)):
        flow = solver(name, annulus, points)
        run(flow, speed, 0.4)
        moments[name] = (60.0 + flow.orbit_speed(), np.abs(flow.stream).max(), flow.torque(), flow.momentum(60.0))
    one, other = (np.array(moments[name]) for name in SOLVERS)
    assert np.abs(other / one - 1.0)[[0, 3]].max() < 1e-3
    assert np.abs(other / one - 1.0)[[1, 2]].max() < 1e-2


@pytest.mark.parametrize(("name", "points", "error"), [("chebyshev", 24, 2e-5), ("differences", 40, 5e-3)])
def test_torque_of_the_walls_is_the_rate_of_angular_momentum(name: str, points: int, error: float) -> None:
    annulus, speed = oil(100e-6), wall_speed(Hill(end=40.0, half_time=0.2, exponent=6.0))
    flow, seen = solver(name, annulus, points), []
    times = np.linspace(0.0, 0.5, 201)
    run(flow, speed, 0.5, stops=times, at_stop=lambda t: seen.append((flow.torque(), flow.momentum(speed.at(t)[0]))))
    torque, momentum = np.array(seen).T
    step = times[1] - times[0]
    impulse = step / 3.0 * (torque[0] + torque[-1] + 4.0 * torque[1:-1:2].sum() + 2.0 * torque[2:-1:2].sum())  # Simpson
    assert momentum[0] == 0.0
    assert impulse == pytest.approx(momentum[-1], rel=error)


@pytest.mark.parametrize("name", SOLVERS)
def test_the_flow_is_symmetric_about_mid_height_and_closed(name: str) -> None:
    annulus = oil(100e-6)
    flow = solver(name, annulus, 20)
    run(flow, wall_speed(Ramp(end=40.0, duration=0.2)), 0.2)
    psi, most = flow.stream, np.abs(flow.stream).max()
    assert most > 0.0
    assert np.abs(psi + psi[:, ::-1]).max() < 1e-9 * most
    assert np.abs(flow.swirl - flow.swirl[:, ::-1]).max() < 1e-9 * np.abs(flow.swirl).max()
    assert all(np.abs(edge).max() == 0.0 for edge in (psi[0], psi[-1], psi[:, 0], psi[:, -1]))
    # the lids drive their fluid outward while the rotor speeds up: u_r = -psi_z/r > 0 near the lids
    assert psi[10, 1] < 0.0
    assert psi[10, -2] > 0.0


def test_no_fluid_slips_along_a_wall() -> None:
    flow = SpectralFlow(oil(100e-6), 20, 24)
    flow.march(wall_speed(Ramp(end=40.0, duration=0.2)), 0.2, tolerance=1e-5)
    slope_r = flow.grid.r.derivative[[0, -1]] @ flow.stream
    slope_z = flow.stream @ flow.grid.z.derivative[[0, -1]].T
    scale = np.abs(flow.grid.r.derivative @ flow.stream).max()
    assert max(np.abs(slope_r).max(), np.abs(slope_z).max()) < 1e-10 * scale


def test_a_slower_lid_makes_the_flow_one_sided() -> None:
    flow = SpectralFlow(oil(100e-6), 16, 20, walls=Walls(bottom=-5.0))
    flow.march(wall_speed(20.0), 0.2, tolerance=1e-4)
    # the slower lid lets fluid fall inward along it
    assert flow.stream[8, 1] > 0.0
    assert np.abs(flow.stream + flow.stream[:, ::-1]).max() > 0.1 * np.abs(flow.stream).max()


def test_thin_oil_spins_up_by_ekman_layers_ten_times_faster_than_by_diffusion() -> None:
    """A hundredth faster at 60 rad/s: the fluid follows within H/(2 sqrt(nu w)) (Greenspan and Howard 1963)."""
    annulus, speed, jump = oil(0.65e-6), 60.0, 0.6
    theory = annulus.height / (2.0 * math.sqrt(annulus.viscosity * speed))
    flow = SpectralFlow(annulus, 28, 36)
    track = flow.march(wall_speed(speed, speed - jump), 1.3 * theory, tolerance=1e-5)
    times, _, orbit = track.arrays()
    lag = (speed - orbit) / jump
    i = int(np.argmax(lag < math.exp(-1.0)))
    fold = np.interp(-math.exp(-1.0), -lag[i - 1 : i + 1], times[i - 1 : i + 1])
    assert fold == pytest.approx(theory, rel=0.05)
    grid = np.linspace(0.0, 40.0, 4001)
    alone = 1.0 - all_modes(annulus).response(wall_speed(1.0, 0.0), grid)
    assert grid[np.argmax(alone < math.exp(-1.0))] > 10.0 * fold


@pytest.mark.parametrize("name", SOLVERS)
def test_the_flow_is_the_same_in_axes_at_rest_and_in_axes_that_turn(name: str) -> None:
    """Walls that turn, seen as a rotor, or as walls with their own speed on a rotor that stands still."""
    annulus, speed = oil(100e-6), 40.0
    turning = solver(name, annulus, 20)
    resting = solver(name, annulus, 20, walls=Walls(inner=speed, outer=speed))
    run(turning, wall_speed(speed, 0.0), 0.1, fixed=5e-5)
    run(resting, wall_speed(0.0), 0.1, fixed=5e-5)
    r2 = turning.radius[:, None] ** 2
    error = 1e-6 if name == "chebyshev" else 1e-3  # the square of r^2 w is not exact for differences
    assert np.abs(turning.swirl + r2 * speed - resting.swirl).max() < error * speed * annulus.outer**2
    assert np.abs(turning.stream).max() > 1e-6
    assert np.abs(turning.stream - resting.stream).max() < 3.0 * error * np.abs(turning.stream).max()


def test_energy_of_the_relative_flow_falls_by_what_viscosity_takes() -> None:
    """Between walls at a steady speed: half of |v|^2 falls by nu times the square of its vorticity; nothing else works."""
    annulus, speed = oil(50e-6), 40.0
    flow, seen = SpectralFlow(annulus, 28, 28), []
    d_r, d_z = flow.grid.r.derivative, flow.grid.z.derivative.T
    weight = np.outer(flow.grid.r.weights / flow.radius, flow.grid.z.weights)

    def look(_: float) -> None:
        g, q, psi = flow.swirl, flow.vorticity, flow.stream
        energy = ((d_r @ psi) ** 2 + (psi @ d_z) ** 2 + g**2) * weight
        loss = (q**2 + (d_r @ g) ** 2 + (g @ d_z) ** 2) * weight
        share = (((d_r @ psi) ** 2 + (psi @ d_z) ** 2) * weight).sum() / energy.sum()
        seen.append((0.5 * energy.sum(), annulus.viscosity * loss.sum(), share))

    times = np.linspace(0.02, 0.12, 401)
    flow.march(wall_speed(speed, 0.0), 0.12, tolerance=1e-7, stops=times, at_stop=look)
    energy, loss, secondary = np.array(seen).T
    step = times[1] - times[0]
    lost = step / 3.0 * (loss[0] + loss[-1] + 4.0 * loss[1:-1:2].sum() + 2.0 * loss[2:-1:2].sum())  # Simpson
    assert secondary.max() > 0.004
    assert energy[0] - energy[-1] == pytest.approx(lost, rel=1e-5)


def test_half_of_a_symmetric_flow_is_the_whole_of_it() -> None:
    """Against the whole height, where a lid with hardly a speed of its own takes the symmetry away; even and odd intervals."""
    annulus, speed = oil(50e-6), wall_speed(Ramp(end=40.0, duration=0.2))
    for points in (20, 21):
        half, whole = (SpectralFlow(annulus, 16, points, walls=Walls(bottom=b)) for b in (None, 1e-12))
        for flow in (half, whole):
            flow.march(speed, 0.2, tolerance=1e-6, fixed=1e-3)
        for one, other in ((half.swirl, whole.swirl), (half.stream, whole.stream), (half.vorticity, whole.vorticity)):
            assert np.abs(one - other).max() < 1e-8 * np.abs(other).max() + 1e-12
        assert np.abs(half.stream).max() > 1e-6


@pytest.mark.parametrize("smooth", [False, True])
def test_implicit_waves_give_what_explicit_ones_do_in_far_fewer_steps(smooth: bool) -> None:
    """A slow run-up to a high speed, where the lag is small and the waves are fast."""
    annulus, speed = oil(20e-6), wall_speed(Ramp(end=125.0, duration=60.0))
    tracks = [
        SpectralFlow(annulus, 16, 20, order=order, waves=waves, smooth=smooth).march(speed, 8.0, tolerance=tolerance)
        for order, waves, tolerance in ((3, False, 2e-5), (2, True, 2e-6))
    ]
    one, other = (CubicSpline(track.times, track.orbit)(np.linspace(0.0, 8.0, 101)) for track in tracks)
    assert np.abs(one - other).max() < 2.5e-4 * 125.0 / 7.5
    assert tracks[1].steps < 0.7 * tracks[0].steps


def test_implicit_waves_have_order_two() -> None:
    found = []
    for steps in (200, 400, 3200):
        flow = SpectralFlow(oil(100e-6), 16, 16, order=2, waves=True)
        found.append(
            flow.march(wall_speed(Hill(end=40.0, half_time=0.2, exponent=6.0)), 0.2, tolerance=1.0, fixed=0.2 / steps)
        )
    one, two, exact = (track.orbit[-1] for track in found)
    assert math.log2(abs(one - exact) / abs(two - exact)) == pytest.approx(2.0, abs=0.1)
    assert exact == pytest.approx(hill_run(16, 3, 3200), abs=2e-4)


def test_the_filter_keeps_low_wave_numbers_and_takes_the_highest_away() -> None:
    line = chebyshev_grid(RIG, 30, 30).r
    x = (line.points[1:-1] - line.points.mean()) / (0.5 * RIG.width)
    plain, smooth = line.family(), line.family(smooth=True)
    kept = plain.backward @ smooth.filtered @ np.polynomial.chebyshev.chebval(x, np.eye(30)[:16].sum(axis=0))
    assert np.abs(kept - np.polynomial.chebyshev.chebval(x, np.eye(30)[:16].sum(axis=0))).max() < 1e-9
    highest = np.sin(29 * np.arccos(x)) / np.sin(np.arccos(x))
    assert np.abs(plain.backward @ smooth.filtered @ highest).max() < 1e-9 * np.abs(highest).max()


def test_a_record_of_the_speed_is_followed_like_the_profile_it_is_of() -> None:
    profile = wall_speed(Hill(end=40.0, half_time=0.2, exponent=3.0))
    times = np.linspace(0.0, 0.4, 401)
    record = recorded_speed(times, profile.over(times))
    assert record.at(0.1234)[0] == pytest.approx(profile.at(0.1234)[0], rel=1e-5)
    assert record.at(0.1234)[1] == pytest.approx(profile.at(0.1234)[1], rel=1e-3)
    one, other = (SpectralFlow(oil(100e-6), 14, 16).march(w, 0.4, tolerance=1e-6).orbit[-1] for w in (profile, record))
    assert one == pytest.approx(other, abs=1e-4 * 40.0)
    assert record.at(9.0) == (pytest.approx(profile.at(0.4)[0]), 0.0)


def test_a_run_up_in_the_thinnest_oil_reaches_the_lag_of_ekman_layers_in_spite_of_its_vortices() -> None:
    """1200 rpm within a minute in 0.65 mm^2/s, up to 20 s: lag is rate times H/(2 sqrt(nu w)), on the mean over 5 s."""
    annulus, rate = oil(0.65e-6), 2.0 * math.pi * 20.0 / 60.0
    flow = SpectralFlow(annulus, 30, 36, smooth=True)
    times, speeds, orbit = flow.march(wall_speed(Ramp(end=rate * 30.0, duration=30.0)), 20.0, tolerance=2e-5).arrays()
    late = np.linspace(15.0, 20.0, 501)
    lag = np.interp(late, times, speeds - orbit).mean()
    theory = rate * annulus.height / (2.0 * math.sqrt(annulus.viscosity * rate * 17.5))
    assert lag == pytest.approx(theory, rel=0.2)
