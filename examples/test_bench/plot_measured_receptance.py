"""
From a hammer test to the border speed
======================================

Whether balls find their places depends on the rotor only through its receptance at the race: deflection over force. A
blow with a hammer and one accelerometer give it, no model of the rotor is needed.
"""

# %%
# The file holds accelerance with a percent of noise. The fit finds how many modes there are, here one, and where.

import autobalancer as ab

fit = ab.measure.receptance(ab.measure.load_receptance(ab.catalog.example_path("discoidal_hammer")))
figure = ab.plot.answer(fit)
for frequency, ratio in ab.measure.modes_of(fit):
    print(f"mode at {frequency:.2f} rad/s, damping ratio {100 * ratio:.2f} %")

# %%
# Two balls of 6.7 g on 77 mm, in thin oil, balance 594 g mm. The border comes with the uncertainty that the noise
# leaves; at 1200 rpm a thinner oil would do, and at 700 rpm a thicker one is needed.

balls = ab.measure.equal_balls(2, 6.656e-3, 0.077, 5.5e-6, spin_ratio=0.4)
how = {"balls_on_rotor": False, "unbalance": 594e-6}
border = ab.measure.receptance_border(fit, balls, **how, resamples=20)
at = ab.measure.receptance_stability(fit, balls, [73.3, 125.7], **how)
speed, deviation = border.attrs["exact_border"], border.attrs["exact_border_deviation"]
print(f"exact border {speed:.2f} rad/s, standard deviation {deviation:.2f} rad/s")
print(f"least drag: {at['drag_factor'].values.round(3)} times that of this oil")

# %%
# The loop through rotor and balls as a curve, with the measured values on it: it must leave the cross to its left.

loop = ab.measure.receptance_loop(fit, balls.with_drag(5.0), 100.0, balls_on_rotor=False)
figure = ab.plot.answer(loop)

# %%
# The true rotor, from which the file was computed, has the border that the full equations give.

race = {
    "orbit_radius": "77 mm",
    "drag": {"law": "viscous", "damping": "5.5e-6 N*m*s"},
    "balls": [{"count": 2, "mass": "6.656 g", "diameter": "12 mm"}],
}
true = ab.machine.Machine(
    name="The rotor of the hammer test",
    axis="vertical",
    rotor={"mass": "12.27 kg", "stiffness": "44.654 kN/m", "damping": "68.37 N*s/m"},
    unbalances=[{"moment": "594 g*mm"}],
    balancers=[{"races": [race]}],
    drive={"kind": "speed", "profile": {"kind": "constant", "speed": "1200 rpm"}},
)
(exact,) = (border for border in ab.stability.borders(true) if border.name == "exact border")
print(f"exact border of the true rotor {exact.speed:.2f} rad/s")
assert abs(speed / exact.speed - 1.0) < 1e-3
assert at["growth_rate"][0] > 0.0 > at["growth_rate"][1]
