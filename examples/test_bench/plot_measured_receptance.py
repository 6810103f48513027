"""
From a hammer test to the border speed
======================================

Whether balls find their places depends on the rotor only through its receptance at the race: deflection over force. A
blow with a hammer and one accelerometer give it, no model of the rotor is needed.
"""

# %%
# The file holds accelerance with a percent of noise. The fit finds how many modes there are, here one, and where.

from pathlib import Path

from autobalancer.measurement.balls import equal_balls
from autobalancer.measurement.rational_fit import fit_receptance, modes_of
from autobalancer.measurement.receptance import load_receptance
from autobalancer.measurement.receptance_border import receptance_border
from autobalancer.measurement.receptance_loop import receptance_loop
from autobalancer.measurement.receptance_stability import receptance_stability
from autobalancer.plots.receptance import plot_nyquist, plot_receptance
from autobalancer.stability.borders.characteristic import PlanarBalancer, growth_rate

here = Path("examples") if Path("examples/machines").is_dir() else Path("..")
fit = fit_receptance(load_receptance(here / "measurements" / "discoidal_hammer.csv"))
figure = plot_receptance(fit)
for frequency, ratio in modes_of(fit):
    print(f"mode at {frequency:.2f} rad/s, damping ratio {100 * ratio:.2f} %")

# %%
# Two balls of 6.7 g on 77 mm, in thin oil, balance 594 g mm. The border comes with the uncertainty that the noise
# leaves; at 1200 rpm a thinner oil would do, and at 700 rpm a thicker one is needed.

balls = equal_balls(2, 6.656e-3, 0.077, 5.5e-6, spin_ratio=0.4)
how = {"balls_on_rotor": False, "unbalance": 594e-6}
border = receptance_border(fit, balls, **how, resamples=20)
at = receptance_stability(fit, balls, [73.3, 125.7], **how)
speed, deviation = border.attrs["exact_border"], border.attrs["exact_border_deviation"]
print(f"exact border {speed:.2f} rad/s, standard deviation {deviation:.2f} rad/s")
print(f"least drag: {at['drag_factor'].values.round(3)} times that of this oil")

# %%
# The loop through rotor and balls as a curve, with the measured values on it: it must leave the cross to its left.

loop = receptance_loop(fit, balls.with_drag(5.0), 100.0, balls_on_rotor=False)
figure = plot_nyquist(loop)

# %%
# The true rotor, from which the file was computed, has the border that the full equations give.

cosine = 594e-6 / (2.0 * balls.moment[0])
spread = 2.0 * abs(2.0 * cosine**2 - 1.0)
true = PlanarBalancer(
    12.27 + balls.mass.sum(), 44654.0, 68.37, 2, *(x[0] for x in (balls.moment, balls.inertia, balls.drag))
)
assert growth_rate(true, 0.999 * speed, spread) > 0.0 > growth_rate(true, 1.001 * speed, spread)
assert at["growth_rate"][0] > 0.0 > at["growth_rate"][1]
