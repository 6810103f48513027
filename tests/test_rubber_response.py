"""The response to unbalance, modes and the release of balls on rubber that softens with the amplitude."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.rubber import CHAIN, ELASTIC, MASS, VISCOUS, described

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.equivalent_stiffness import softened
from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import RubberLaw
from autobalancer.machine import Machine

LAW = RubberLaw(ELASTIC, VISCOUS, CHAIN)
HERTZ = 2.0 * math.pi
BALL = 6.656e-3  # effective, of Spannan (2021), table 6.2
RACE: dict[str, Any] = {
    "orbit_radius": 0.07695,
    "fluid": {"density": 760.0, "viscosity": 0.65e-6},
    "drag": {"law": "discoidal"},
    "balls": [{"count": 2, "mass": BALL + 760.0 * math.pi / 6.0 * 0.0123**3, "diameter": 0.0123}],
}


def machine(rotor: dict[str, Any], *, moment: float = 594e-6, rolling: float | None = None, **more: Any) -> Machine:
    friction = {} if rolling is None else {"friction": {"rolling_resistance": rolling}}
    return Machine(
        name="on rubber",
        axis="vertical",
        rotor=rotor,
        unbalances=[{"moment": moment}] if moment else [],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 60.0}},
        **({} if rolling is None else {"balancers": [{"races": [{**RACE, **friction}]}]}),
        **more,
    )


def planar(rubber: Any = None, **more: Any) -> Machine:
    return machine({"mass": MASS, "rubber": described() if rubber is None else rubber}, **more)


def peak_by_amplitudes(moment: float, mass: float) -> tuple[float, float]:
    """Frequency (Hz) and size (m) of the peak: the largest amplitude for which some speed solves the balance, a quartic in w."""

    def speeds(a: float) -> np.ndarray:
        k = LAW.stiffness(a, 0.0)
        # |K' - M w^2 + i (K'' + c w)|^2 = (U w^2 / a)^2
        quartic = [
            mass**2 - (moment / a) ** 2,
            0.0,
            VISCOUS**2 - 2.0 * mass * k.real,
            2.0 * VISCOUS * k.imag,
            abs(k) ** 2,
        ]
        roots = np.roots(quartic)
        return roots[(np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0.0)].real

    low, high = moment / mass * 1.01, 1e-2
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if speeds(middle).size else (low, middle)
    return float(speeds(low).mean()) / HERTZ, low


@pytest.mark.parametrize("moment", [20e-6, 40e-6, 594e-6])
def test_the_peak_of_the_response_is_where_a_scan_over_amplitudes_has_it(moment: float) -> None:
    frequency, size = peak_by_amplitudes(moment, MASS)
    peak = ab.rotor.response_peaks(planar(moment=moment), "8 Hz", "12 Hz", samples=200)
    assert float(peak["peak_speed"][-1]) / HERTZ == pytest.approx(frequency, rel=2e-4)
    assert float(peak["peak_amplitude"].max()) == pytest.approx(size, rel=1e-5)


def test_the_response_satisfies_its_balance_at_every_speed() -> None:
    w = np.linspace(20.0, 120.0, 60)
    found = ab.rotor.response(planar(described(maxwell=True)), w)
    law = RubberLaw(ELASTIC, VISCOUS, CHAIN, ((3000.0, 4e-3), (2000.0, 40e-3)))
    a = found["rubber_amplitude"].values[:, 0]
    assert a == pytest.approx(found["semi_major"].values[:, 0])
    assert np.abs(law.stiffness(a, w) - MASS * w**2) * a == pytest.approx(594e-6 * w**2, rel=1e-9)
    assert found["rubber_stiffness"].values[:, 0] == pytest.approx(law.stiffness(a, w).real)


def test_a_run_at_constant_speed_comes_to_the_circle_of_the_response() -> None:
    one = planar(moment=594e-6)
    run = ab.simulate(one, duration=8.0, save=ab.Samples(count=801), tolerance=1e-8)
    last = np.hypot(run.x.values, run.y.values)[-200:]
    size = float(ab.rotor.response(one, 60.0)["semi_major"].item())
    assert last == pytest.approx(size, rel=2e-3)  # what sticks remembers the start, and forgets it as 1/time


def test_small_unbalance_finds_the_rubber_of_small_motions_and_large_unbalance_the_softest() -> None:
    w = np.array([30.0, 90.0])
    small, stiff = ab.rotor.response(planar(moment=1e-9), w), planar_linear(LAW.at_rest().real)
    assert small["semi_major"].values == pytest.approx(ab.rotor.response(stiff, w, unbalance=1e-9)["semi_major"].values)
    large = ab.rotor.response(planar(moment=1e3), w)["semi_major"].values
    assert large == pytest.approx(
        ab.rotor.response(planar_linear(ELASTIC), w, unbalance=1e3)["semi_major"].values, rel=1e-5
    )


def planar_linear(stiffness: float) -> Machine:
    return machine({"mass": MASS, "stiffness": stiffness, "damping": VISCOUS})


SLIPPING = {"stiffness": 1e4, "damping": 5.0, "friction": {"breakaway_amplitude": [1e-4], "stiffness": [3e4]}}


@pytest.mark.parametrize("law", ["elastoplastic", "endochronic"])
def test_a_circle_on_rubber_has_one_size_only_however_much_the_rubber_softens(law: str) -> None:
    random = np.random.default_rng(3)
    a = np.geomspace(1e-3, 1e3, 3000)
    for _ in range(200):
        count = int(random.integers(1, 5))
        rubber = RubberLaw(
            0.0, 0.0, tuple(zip(random.random(count), 10.0 ** random.uniform(-2, 2, count), strict=True)), law=law
        )
        rest = random.uniform(-4.0, 1.0)  # k - M w^2
        force = np.abs(rest + rubber.stiffness(a, 1.0)) * a
        assert (np.diff(force) > -1e-12 * force[1:]).all()


def test_rubber_beyond_its_elements_is_named() -> None:
    found = ab.rotor.response(planar(SLIPPING, moment=600e-6), np.linspace(40.0, 60.0, 11))
    assert any("farther than its largest breakaway amplitude" in text for text in found.remarks())


def rigid(share: float = 0.5) -> Machine:
    support = {"rubber": described(share=share)}
    return machine(
        {
            "kind": "rigid", "mass": MASS, "transverse_inertia": 0.3, "polar_inertia": 0.05,
            "supports": [{"position": -0.1, **support}, {"position": 0.1, **support}],
        },
        stations=[{"name": "middle", "position": 0.0}, {"name": "end", "position": 0.1}],
    )  # fmt: skip


def test_two_supports_of_half_the_rubber_are_as_one() -> None:
    w, load = np.linspace(40.0, 80.0, 41), 594e-6
    one = machine({"mass": MASS, "rubber": described()})
    two = Machine(**{**_fields(rigid()), "unbalances": [{"moment": load, "station": "middle"}]})
    found = ab.rotor.response(two, w, "middle")
    assert found["semi_major"].values == pytest.approx(ab.rotor.response(one, w)["semi_major"].values, rel=1e-7)
    assert found.sizes["rubber"] == 2


def _fields(one: Machine) -> dict[str, Any]:
    return {key: getattr(one, key) for key in one.model_fields_set}


def rig(height: float, *, axial: bool = True) -> Machine:
    """A body whose mass center is above three bushings, so that it tilts and strains them along their axes."""
    along = {"axial_rubber": described(share=2.0)} if axial else {"axial_stiffness": 1e6}
    return machine(
        {
            "kind": "multibody",
            "bodies": [
                {
                    "name": "all", "rotating": True, "mass": 2.0, "transverse_inertia": 0.01, "polar_inertia": 0.01,
                    "position": height,
                },
                {"name": "base", "mass": 10.27, "transverse_inertia": 0.04, "polar_inertia": 0.05, "position": height},
            ],
            "joints": [
                {
                    "kind": "bearing", "between": ["all", "base"], "position": height + 0.03,
                    "stiffness": 1e8, "axial_stiffness": 1e8,
                },
                {"kind": "bearing", "between": ["all", "base"], "position": height - 0.03, "stiffness": 1e8},
                {
                    "kind": "bushing", "between": ["base", "ground"], "position": 0.0, "count": 3, "radius": 0.12,
                    "shear_rubber": described(share=1.0 / 3.0), **along,
                },
            ],
        },
        stations=[{"name": "top", "position": height, "body": "all"}],
    )  # fmt: skip


def test_bushings_under_a_rig_that_tilts_have_the_stiffness_of_their_own_shear_and_stretch() -> None:
    one, w = rig(0.08), np.array([40.0, 52.0, 58.0, 66.0])
    found = ab.rotor.response(Machine(**{**_fields(one), "unbalances": [{"moment": 594e-6, "station": "top"}]}), w)
    assert found.sizes["rubber"] == 6
    size = found["rubber_amplitude"].values
    assert size[:, 0] == pytest.approx(size[:, 2])
    assert (size[:, 1] > 0.05 * size[:, 0]).all()
    bare = lateral_model(one)
    soft = softened(one, bare)
    assert soft is not None
    for i, speed in enumerate(w):  # the same by the linear model with these stiffnesses, x and y apart
        model = soft.at_amplitude(size[i], float(speed))
        row = bare.both(bare.axis.rows(0.08, "all").deflection[None])
        dynamic = model.stiffness_at(speed) + 1j * speed * model.damping_at(speed)
        dynamic = dynamic + speed**2 * (1j * model.gyroscopic - model.mass)
        x, y = row @ np.linalg.solve(dynamic, speed**2 * 594e-6 * (row[0] - 1j * row[1]))
        assert abs(x) == pytest.approx(found["semi_major"].values[i, 0], rel=1e-6)
        assert y == pytest.approx(-1j * x, rel=1e-6)


def test_modes_at_an_amplitude_have_the_stiffness_and_loss_of_that_amplitude() -> None:
    for motion in ("line", "circle"):
        found = ab.rotor.modes(planar(), rubber_amplitude="0.3 mm", motion=motion)
        root = complex(-found["decay_rate"][0], found["frequency"][0])
        k = LAW.stiffness(3e-4, 0.0, motion)
        miss = MASS * root**2 + (VISCOUS + k.imag / root.imag) * root + k.real
        assert abs(miss) < 1e-9 * abs(k)
    small = ab.rotor.modes(planar(), rubber_amplitude=1e-9)
    assert small["frequency"].values == pytest.approx(ab.rotor.modes(planar())["frequency"].values)


def test_modes_of_a_rig_have_less_stretched_rubber_stiffer() -> None:
    one = rig(0.08)
    linear, soft = ab.rotor.modes(one, modes=4), ab.rotor.modes(one, modes=4, rubber_amplitude=3e-4)
    assert (soft["frequency"].values < linear["frequency"].values).all()
    every = softened(one, lateral_model(one))
    assert every is not None
    floor = np.linalg.eigvals(
        np.linalg.solve(every.sliding.mass, every.at_amplitude(3e-4, 60.0, "line").stiffness_at(0.0))
    )
    lowest = math.sqrt(np.sort(floor.real)[np.sort(floor.real) > 1.0][0])
    assert soft["undamped_frequency"].values[0] > lowest  # all rubber at the amplitude of the one that moves farthest


def test_amplitudes_without_rubber_and_impossible_ones_are_refused() -> None:
    with pytest.raises(QuestionError, match="no rubber that softens"):
        ab.rotor.modes(planar_linear(1e4), rubber_amplitude=1e-3)
    with pytest.raises(QuestionError, match="must be finite and not negative"):
        ab.rotor.modes(planar(), rubber_amplitude=-1.0)
    with pytest.raises(QuestionError, match="must be 'line', 'circle' or 'ellipse'"):
        ab.rotor.modes(planar(), rubber_amplitude=1e-3, motion="spiral")


def test_friction_elements_at_rest_add_neutral_eigenvalues_and_nothing_else() -> None:
    k = np.array([one for one, _ in CHAIN])
    count = k.size
    matrix = np.zeros((2 + count, 2 + count))  # of one direction: z, v, f; <f v> is of the second order at rest
    matrix[0, 1] = 1.0
    matrix[1, 0], matrix[1, 1], matrix[1, 2:] = -ELASTIC / MASS, -VISCOUS / MASS, -1.0 / MASS
    matrix[2:, 1] = k
    values = np.linalg.eigvals(matrix)
    order = np.argsort(np.abs(values))
    assert np.abs(values[order[:count]]).max() < 1e-6 * np.abs(values).max()  # one of each element and direction
    found = ab.rotor.modes(planar())
    assert values[order[-1]].real == pytest.approx(-float(found["decay_rate"][0]), rel=1e-6)
    assert abs(values[order[-1]].imag) == pytest.approx(float(found["frequency"][0]), rel=1e-9)


ONLY = ("release speed", "capture speed")


def test_balls_are_released_where_the_torque_balance_with_the_stiffness_of_their_own_whirl_ends() -> None:
    mass, total, orbit = MASS + 2.0 * BALL, 2.0 * BALL * 0.07695, 0.07695
    curve = ab.laws.DragCurve(ab.laws.discoidal(), 760.0, 0.65e-6, 0.0123)
    ball = ab.laws.StalledBall(0.5 * total, total, orbit, lambda slip: curve.torque(slip, orbit), rolling=0.003)
    # over the amplitude: its stiffness, then the speeds at which this load has it
    best = 0.0
    for a in np.append(np.linspace(0.90e-3, 1.05e-3, 61), 1e-3):
        k = LAW.stiffness(a, 0.0)
        roots = np.roots(
            [mass**2 - (total / a) ** 2, 0.0, VISCOUS**2 - 2.0 * mass * k.real, 2.0 * VISCOUS * k.imag, abs(k) ** 2]
        )
        for v in roots[(np.abs(roots.imag) < 1e-7 * np.abs(roots)) & (roots.real > 0.0)].real:
            receptance = 1.0 / (k - mass * v**2 + 1j * VISCOUS * v)
            best = max(best, float(ab.laws.stall_balance(ball, lambda _, h=receptance: np.array([h]), v).speed[0]))
    released, caught = ab.stability.borders(planar(rolling=0.003), only=ONLY)
    assert best == pytest.approx(64.92, abs=0.005)  # found by another program, see docs/rubber.md
    assert f"up to {best:.4g} rad/s" in released.note
    assert 0.99 * best < released.speed < best  # two balls part at the phase of the resonance
    assert caught.speed < released.speed
    assert "softening of the rubber by the unbalance" in released.note
    assert "small motions" not in released.note


def test_release_on_rubber_that_hardly_softens_is_that_of_plain_springs() -> None:
    hard = {"stiffness": 44654.0, "damping": 68.37, "friction": {"breakaway_amplitude": [1e-3], "stiffness": [1e-3]}}
    springs = machine({"mass": MASS, "stiffness": 44654.0, "damping": 68.37}, rolling=0.003)
    one, other = (ab.stability.borders(m, only=ONLY) for m in (planar(hard, rolling=0.003), springs))
    assert [border.speed for border in one] == pytest.approx([border.speed for border in other], rel=1e-6)


def test_borders_of_balanced_states_say_that_they_have_the_stiffness_of_small_motions() -> None:
    (border,) = ab.stability.borders(planar(rolling=0.003), only=("averaged border",))
    assert "stiffness of small motions" in border.note


@pytest.mark.parametrize(
    ("one", "station"),
    [
        pytest.param(lambda: rigid(), "middle", marks=pytest.mark.slow, id="rigid"),
        pytest.param(lambda: rig(1e-6, axial=False), "top", id="rig"),
    ],
)
def test_balls_on_any_rotor_are_released_as_on_the_planar_one(one: Any, station: str) -> None:
    plane = planar(rolling=0.003)
    here = {"balancers": [{"station": station, "races": plane.balancers[0].races}], "unbalances": []}
    (wanted,) = ab.stability.borders(plane, only=ONLY[:1])
    (found,) = ab.stability.borders(Machine(**{**_fields(one()), **here}), only=ONLY[:1])
    assert found.speed == pytest.approx(wanted.speed, rel=1e-5)  # the bearings of the rig give way a little
