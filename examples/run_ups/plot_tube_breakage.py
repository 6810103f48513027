"""
A tube breaks: which oil balances again soonest?
================================================

A centrifuge runs in balance when a tube breaks, and its unbalance is suddenly another one. How far the rotor goes
hardly depends on the oil around the balls: the peak comes within the first turns, when the balls are still where they
were. The time until the rotor is balanced again does. Thin oil damps the balls too little, thick oil holds them back;
in between is an oil that is best at all speeds.
"""

import autobalancer as ab

found = ab.study(ab.catalog.example_path("tube_breakage"))
print(found)
picture = ab.plot.answer(found, quantity="settling_time")

# %%
# The peaks, at the same speeds and in the same oils.

picture = ab.plot.answer(found, quantity="peak_deflection")
