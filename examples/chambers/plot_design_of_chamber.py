"""
Which balls for a deep chamber?
===============================

Chamber, rotor and motor are given, and the rotor has 60 000 g mm of unbalance. How many balls, and how heavy? Closed forms rule
out many designs before anything runs.
"""

# %%
# What balls side by side on the wall can balance rises with their mass, and falls where they are so few that their size keeps
# them from the wall. At the bottom up to five balls of 1 kg lie in one row along the axis; such a row acts as one ball, and
# needs a friction of 0.6 to be lifted.

import matplotlib.pyplot as plt

import autobalancer as ab

machine = ab.example("deep_chamber")
print(ab.chamber.bounds(ab.chamber.variant(machine, balls=5, friction=0.5)))

figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for mass, color in (("0.6 kg", "#0072B2"), ("1 kg", "#E69F00"), ("1.5 kg", "#009E73")):
    heavy = ab.parse_machine(ab.machine_text(machine).replace('total_mass = "1 kg"', f'total_mass = "{mass}"'))
    counts = range(3, 41)
    found = [ab.chamber.bounds(ab.chamber.variant(heavy, balls=count)) for count in counts]
    axes.plot(counts, [1e6 * one.capability for one in found], color=color, label=f"{mass} of balls")
    row = [(count, 1e6 * one.capability) for count, one in zip(counts, found, strict=True) if one.axial_rows == 1]
    axes.plot(*zip(*row, strict=True), "o", color=color, ms=5)
axes.plot([], [], "o", color="0.4", ms=5, label="in one row")
axes.axhline(60e3, color="#D55E00", ls="--", lw=0.9, label="unbalance")
axes.set(xlabel="number of balls", ylabel="can be balanced (g mm)", ylim=(0, None))
axes.legend(ncols=2)

# %%
# A small search: closed forms rule out four of eight designs, short runs of one filling two more, and two run in full. Free
# vibrations of the lightly damped body still decay then, so that a real search takes longer runs, and more fillings.

specification = {
    "machine": machine,
    "limits": {"stall_probability": 0.5},
    "candidates": {"balls": [5, 12, 20, 30], "total_mass": [0.6, 1.0], "friction": [0.7]},
    "runs": {"duration": 4.0, "short": 2.0, "fillings": 2, "budget": 2},
}
found = ab.design(specification)
print(found)
figure = ab.plot.design(found)
assert (found["capability"].values[found["stage"].values == "runs"] > 0.06).all()

# %%
# The best one is a machine, with what was assumed in its description.

print(ab.designed_machine(found).description)
