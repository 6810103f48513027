"""
More balls, less balance
========================

A race compensates at most what its balls add up to. Each ball that joins the group stands further aside and adds less;
beyond half of the annulus every further ball takes something away. For the outer ring and the balls of a 6304 bearing
the rule to fill half of the annulus and round down is one ball short.
"""

# %%
# The bearing comes from the catalog, in SI units. It is one of the verified rows of the table.

import numpy as np

import autobalancer as ab

ring = ab.catalog.bearing("6304")
race = (ring.orbit_radius, ring.ball_diameter)
steel = 7860.0
counts = np.arange(1, ab.laws.largest_count(*race) + 1)
unbalance = 1e6 * np.array([ab.laws.capability(*race, steel, int(n)) for n in counts])

# %%
# The closed form :math:`\sin(n\alpha)/\sin(\alpha)` of Spannan (2021), eq. (2.3), has its greatest value at the integer
# nearest to :math:`\pi/2\alpha`.

best = ab.laws.largest_useful_count(*race)
alpha = np.arcsin(ring.ball_diameter / (2.0 * ring.orbit_radius))
lower = int(np.pi / (2.0 * alpha))

with ab.plot.style.look():
    figure = ab.plot.style.picture(7.0, 3.8)
    axes = figure.subplots()
    colors = np.where(
        counts == best,
        ab.plot.style.BALLS[0],
        np.where(counts == lower, ab.plot.style.BALLS[1], ab.plot.style.ALL_BALLS),
    )
    bars = axes.bar(counts, unbalance, color=colors, width=0.7)
    axes.bar_label(bars, fmt="%.0f", fontsize=8)
    axes.set_xticks(counts)
    axes.set(xlabel="number of balls", ylabel="capability (g mm)")
    axes.grid(False, axis="x")
    ab.plot.style.heading(figure, f"6304: {lower} balls by the printed rule (yellow), {best} are better (blue)")

# %%
# The gain of the sixth ball is small, but it comes for nothing.

gain = unbalance[best - 1] / unbalance[lower - 1] - 1.0
print(f"{best} balls compensate {100.0 * gain:.1f} % more than {lower}")
assert abs(gain - 0.0269) < 0.0001
