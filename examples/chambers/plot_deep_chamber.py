"""
Balls in a deep chamber
=======================

Twelve balls lie at the bottom of a deep chamber. When the motor starts they slide, pile up and collide; with enough friction
the wall carries them around, and seconds later they have found places that balance the rotor.
"""

# %%
# The reference machine, with twelve balls of 1 kg together and a friction of 0.7.

import autobalancer as ab

machine = ab.chamber.variant(ab.example("deep_chamber"), balls=12, friction=0.7)
run = ab.simulate(machine, duration=16.0)
figure = ab.plot.chamber_run(run)

# %%
# At rest, on their way, and in balance: seen from the front, and with the race unrolled from the unbalance on.

figure = ab.plot.chamber_arrangement(run, [0.0, 1.0, 16.0])

# %%
# Where the work of the motor went, and how well the balance closes.

figure = ab.plot.answer(run, "energy")
measured = ab.run_measures(run)
for name in ("share_carried", "vertical_synchronous", "residual_unbalance", "energy_error"):
    print(f"{name}: {float(measured[name]):.3g} {measured[name].attrs['units']}")
assert float(measured["share_carried"]) == 1.0
assert float(measured["residual_unbalance"]) < 0.03 * 0.06
assert float(measured["energy_error"]) < 1e-3
