"""
Tutorial 5: from one run to a decision
======================================

One run is one machine on one day. Parts scatter, balls start anywhere, and friction is hardly known. How much can be
promised to a customer, which oil should be taken, and which tolerance is worth its money?
"""

# %%
# One run
# -------
#
# The centrifuge of Spannan (2021), with the drag that was measured on it. Its balls now have a rolling resistance: the
# wall force acts 0.0005 ball radii ahead of the contact. That is little, and it is not nothing.

import tempfile
from pathlib import Path

import autobalancer as ab

machine = ab.with_parameter(ab.example("discoidal"), "balancers[1].races[1].drag", {"law": "discoidal"})
machine = ab.with_parameter(machine, "balancers[1].races[1].friction", {"rolling_resistance": 5e-4})
print(ab.verdict(ab.simulate(machine)))

# %%
# The rolling resistance stops the balls before they reach their places. They stop wherever the force that drives them,
# which becomes smaller as the rotor comes to rest, is not greater than the friction. So the residual is not a number but
# an accident. What can be said of accidents?
#
# Many starts
# -----------
#
# First question: is it the start of the balls? An ensemble runs the machine from random starts.

starts = ab.ensemble(machine, seeds=100, tolerance=1e-6)
starts

# %%
# The interval beside each share is where the share of very many starts would lie with 95 % confidence. A hundred runs
# cannot say more than this, and a share of 0 % in a hundred runs does not mean *never*.

ab.plot.answer(starts, "distribution", measure="residual_unbalance")

# %%
# Nearly all of them end alike. The run-up is slow, and the balls forget where they started. A hundred equal results look
# very certain, but they are certain about a machine that nobody has: the one with exactly the nominal values.
#
# Many machines
# -------------
#
# A study draws the machine itself. Its question is a dict here, and may be a TOML file. A list of values is a grid, over
# which you can decide: the oil. A distribution is what you cannot decide: samples in the centrifuge, rubber and friction.

folder = Path(tempfile.mkdtemp())
ab.save_machine(machine, folder / "centrifuge.toml")
scatter = {
    "unbalances[1].mass": {"distribution": "normal", "mean": "5.5 g", "standard_deviation": "0.8 g", "low": "1 g"},
    "stiffness": {"distribution": "tolerance", "plus_minus": "10 %"},
    "rolling_resistance": {"distribution": "log-normal", "median": 5e-4, "factor": 2},
}
question = {
    "machine": str(folder / "centrifuge.toml"),
    "members": 120,
    "show": ["residual_unbalance", "peak_deflection"],
    "vary": {"viscosity": ["5 mm^2/s", "20 mm^2/s", "50 mm^2/s", "100 mm^2/s"], **scatter},
}
found = ab.study(question)
found

# %%
# Read a row with its intervals. Is an oil really better than its neighbor, or do their intervals overlap?

ab.plot.answer(found, quantity="residual_unbalance")

# %%
# The line is the median machine, the upper edge of the pale band the one that only 5 % exceed. If you sign for *every*
# machine, the edge counts; if you pay for the wear of many, the median does. The study does not decide; it says what each
# decision costs. The greatest deflection, which the gap must allow, is another matter:

ab.plot.answer(found, quantity="peak_deflection")

# %%
# How many members are enough? An interval becomes half as wide with four times as many. Instead of guessing, a study may
# stop by itself, with ``"stop": {"of": "peak_deflection", "statistic": "quantile", "at": 0.5, "half_width": "20 um"}``.
#
# Which tolerance is to blame?
# ----------------------------
#
# Sobol' indices share the variance of a result among its causes: *alone* is what one input makes by itself, *in all*
# counts everything in which it takes part. They need a plan of their own, here with one oil.

one_oil = {**question, "plan": "sensitivity", "members": 64, "vary": {"viscosity": "20 mm^2/s", **scatter}}
planned = ab.study(one_oil)
peak = ab.sensitivity(planned, "peak_deflection")
peak

# %%

ab.plot.answer(peak)

# %%
# For the greatest deflection the answer is plain: the unbalance. Closer tolerances of the rubber would buy nothing. And
# for the residual?

residual = ab.sensitivity(planned, "residual_unbalance")
residual

# %%
# Here no input explains much alone (an index slightly below zero is the noise of its estimate), but all matter together:
# where the balls stop is decided by unbalance, stiffness and friction jointly. The intervals are wide, since 64 base
# samples are few. What can be said is: there is no single tolerance that one could tighten.
#
# A clever idea
# -------------
#
# Friction holds the balls because the rotor hardly deflects at full speed. Nearer to the critical speed the same
# unbalance deflects it more. So go up, come down for a while to let the balls find their places, and go up again. First
# with the nominal machine, of which only the starts are random; 1200 rpm means no reduction:

shaped = {
    **question,
    "members": 60,
    "duration": "110 s",
    "vary": {"run_up.reduced": ["1200 rpm", "900 rpm", "800 rpm"]},
    "run_up": {"speed": "1200 rpm", "rate": "40 rpm/s", "before_reduction": "10 s", "reduced_for": "15 s"},
}
print(ab.study(shaped))

# %%
# Compare the shares of the first and the last row: this looks like the solution. Now with machines as they are made:

reduced = ab.study({**shaped, "vary": {**shaped["vary"], **scatter}})
print(reduced)

# %%
# Look at the intervals of the rows once more. Nearly all of the gain is gone: 800 rpm is right for the nominal machine,
# and not for its neighbors. This is why a study draws the machine and not the start alone. (Which of the three causes it?
# See the exercises.)
#
# The plain idea
# --------------
#
# A race with less friction:

plain = {**question, "members": 80, "vary": {**scatter, "rolling_resistance": [1e-5, 1e-4, 5e-4]}}
smoother = ab.study(plain)
print(smoother)

# %%

ab.plot.answer(smoother, quantity="residual_unbalance")

# %%
# So measure the rolling resistance of your race before you build: the angle at which a ball stands in a slowly turned
# race gives it (``ab.measure.evaluate_angles``).
#
# Put it on paper
# ---------------
#
# A report collects what is known of the machine on one page that somebody can sign: check, verdict, borders and margins,
# map, random starts, and the study. Below each number stands the command that makes it again. With a name that ends with
# ``.pdf`` it is typeset.

page = ab.report(machine, folder / "centrifuge.html", study=found, grade="G 2.5", starts=50)
print(f"{page.name}: {page.stat().st_size / 1e6:.1f} MB in one file")

# %%
# Exercises
# ---------
#
# 1. Repeat the last study with ``"seed": 1``. Which digits of the table can you trust? Compare with its intervals.
# 2. The shape of a tolerance matters: replace that of the stiffness by a ``uniform`` distribution of the same width.
# 3. Take the rolling resistance out of ``scatter`` and repeat the study of the clever idea. Then take out the stiffness
#    instead. Which of the two spoils it?
