"""
A disk that cannot be balanced
==============================

A rigid rotor whose polar inertia is greater than its transverse one has no forward conical critical speed: it tilts towards
its load at every speed. Balls in two planes then make the couple worse, however fast it turns.
"""

# %%
# The same rotor and balls, ever flatter. The conical critical speed goes to infinity at equal inertias and is gone beyond.

import numpy as np

import autobalancer as ab

machine = ab.example("disk_like_rotor")
transverse = machine.rotor.transverse_inertia
speeds = np.linspace(60.0, 1000.0, 160)
shares = (0.4, 0.6, 1.2, 1.6)
rates = {}
for share in shares:
    flat = ab.with_parameter(machine, "rotor.polar_inertia", share * transverse)
    rates[share] = ab.stability.eigenvalues(flat, speeds.tolist())["growth_rate"].values
    print(f"J_p/J_t = {share}: critical speeds", [f"{w:.0f} rad/s" for w in ab.check(flat).critical_speeds])

# %%
# Growth rate of the balanced state: slender rotors cross zero above their second critical speed, the later the
# flatter they are; disk-like ones never do.

with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 4.2)
    axes = figure.subplots()
    axes.axhline(0.0, color=ab.plot.style.INK, lw=0.8)
    for share, color in zip(shares, ab.plot.style.BALLS, strict=False):
        axes.plot(speeds, rates[share], color=color, label=f"$J_p/J_t$ = {share}")
    axes.set_xlabel("rotor speed (rad/s)")
    axes.set_ylabel("growth rate of the balanced state (1/s)")
    ab.plot.style.heading(figure, "Two-plane balancing of ever flatter rotors")
    ab.plot.style.legend(axes)

assert min(rates[0.4]) < 0.0
assert min(rates[0.6]) < 0.0
assert min(rates[1.2]) > 0.0
assert min(rates[1.6]) > 0.0
