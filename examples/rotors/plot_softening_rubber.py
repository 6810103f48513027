"""
Rubber that softens with the amplitude
======================================

One rig, three first resonances: 10.7 Hz in a run-up with its own small unbalance, 9.6 Hz after a blow, 8.4 Hz under balls that
hang at the resonance. One rubber explains them: the farther it moves, the softer it is. What it loses follows from that.
"""

# %%
# Springs that slide, side by side, at the race of the discoidal rig of Spannan (2021), section 6.1: elastic and viscous part, and
# five elements of which each slides beyond its own deflection. These numbers are fitted to the three resonances.

import math

import numpy as np

import autobalancer as ab

machine = ab.example("rubber")
given = machine.rotor.rubber
friction = tuple(zip(given.friction.stiffness, given.friction.breakaway_amplitude, strict=True))
rubber = ab.laws.RubberLaw(given.stiffness, given.damping, friction)
for stiffness, limit in friction:
    print(f"{stiffness:.0f} N/m, slides beyond {1e3 * limit:.2f} mm")
HERTZ = 2.0 * math.pi
MASS, BALL, ORBIT = 12.27, 6.656e-3, 0.07695  # kg, kg, m

# %%
# What was measured gives points of stiffness and loss. No deflection is printed: the amplitudes here are estimates, after the
# blow half of a first swing of 0.4 mm. Frequency and decay rate give both; the resonance in the run-up gives the stiffness.

blow = ab.measure.rubber_resonances(MASS, 9.6 * HERTZ, 0.2e-3, 2.8, loss_uncertainty=0.1)
run_up = ab.measure.rubber_resonances(MASS, 10.7 * HERTZ, 0.03e-3, motion="circle")

# %%
# Balls that hang at 53 rad/s while the rotor turns at 60.7 rad/s are dragged by the fluid and braked by the whirl they make. The
# balance of torques says by which angle they lead the deflection, and force over deflection is K. Rolling resistance 0.001.

rotor_speed, whirl, rolling = 60.74, 53.0, 0.001
drag = ab.laws.DragCurve(ab.laws.discoidal(), 760.0, 0.65e-6, 0.0123).torque(np.array([rotor_speed - whirl]), ORBIT)[0]
size = np.array([0.65e-3, 0.7e-3, 0.8e-3])
lead = np.full(3, 1.0)
for _ in range(100):
    pressed = BALL * whirl**2 * (ORBIT + size * np.cos(lead))
    lead = np.arcsin((drag + rolling * pressed * ORBIT) / (BALL * ORBIT * whirl**2 * size))
k = (MASS + 2.0 * BALL) * whirl**2 + 2.0 * BALL * ORBIT * whirl**2 / size * np.exp(1j * lead)
hanging = ab.measure.rubber_loops(
    np.full(3, whirl), size, np.abs(k), k.imag / whirl, motion="circle", loss_uncertainty=0.2
)
label = "measured, amplitude estimated,"
figure = ab.plot.answer(
    rubber, points=[run_up, blow, hanging], frequency=10.0 * HERTZ, amplitudes=(0.01e-3, 3e-3), points_label=label
)

# %%
# The response to three unbalances: the largest has the lowest and broadest resonance. The curve does not fold over. An element
# that begins to slide begins to lose energy, and this loss outweighs its softening.

for moment in ("20 g*mm", "40 g*mm", "594 g*mm"):
    peak = ab.rotor.response_peaks(machine, "8 Hz", "12 Hz", unbalance=moment)
    frequency, deflection = float(peak["peak_speed"][-1]) / HERTZ, float(peak["peak_amplitude"].max())
    print(f"{moment}: {frequency:.2f} Hz, {1e3 * deflection:.3f} mm")
figure = ab.plot.response(ab.rotor.response(machine, "8 Hz:12 Hz:200", unbalance="594 g*mm"))

# %%
# Modes at an amplitude say what a blow of this size shows.

for amplitude in ("1 um", "0.1 mm", "0.5 mm"):
    mode = ab.rotor.modes(machine, rubber_amplitude=amplitude).isel(mode=0)
    print(f"{amplitude}: {float(mode['frequency']) / HERTZ:.2f} Hz, decay {float(mode['decay_rate']):.2f} 1/s")

# %%
# On supports that differ along x and y the rubber moves in ellipses. Each element is then integrated over a period, and its first
# harmonic counts; the third, which is left out, is estimated. Here springs stand beside the same rubber, much stiffer along y:
# two resonances, and backward whirl between them.

half = {
    "stiffness": 0.5 * given.stiffness,
    "damping": 0.5 * given.damping,
    "friction": {
        "breakaway_amplitude": list(given.friction.breakaway_amplitude),
        "stiffness": [0.5 * one for one in given.friction.stiffness],
    },
}
uneven = ab.machine.Machine(
    name="springs beside the rubber",
    axis="vertical",
    rotor={
        "kind": "rigid",
        "mass": MASS,
        "transverse_inertia": 0.3,
        "polar_inertia": 0.05,
        "supports": [
            {"position": -0.1, "rubber": half},
            {"position": 0.1, "rubber": half},
            {"position": 0.0, "stiffness": [2e3, 20e3]},
        ],
    },
    stations=[{"name": "middle", "position": 0.0}],
    unbalances=[{"moment": 594e-6, "station": "middle"}],
    drive={"kind": "speed", "profile": {"kind": "constant", "speed": 60.0}},
)
found = ab.rotor.response(uneven, "7 Hz:15 Hz:81", smooth=True)
figure = ab.plot.response(found, speed_unit="Hz")
left_out = float((found["rubber_third_harmonic"] / found["rubber_amplitude"]).max())
print(f"third harmonic of the deflection: at most {100.0 * left_out:.2f} %")
for motion in ("line", "circle", "ellipse"):
    mode = ab.rotor.modes(uneven, "100 rad/s", rubber_amplitude="0.2 mm", motion=motion)
    print(motion, [f"{value / HERTZ:.2f} Hz" for value in mode["frequency"].values])
