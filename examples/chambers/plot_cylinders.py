"""
Cylinders in place of balls
===========================

Ten cylinders in one layer, guided by the flat walls as the rollers of a bearing are, and ten balls of the same mass.
Cylinders are slimmer, so that they find room where the unbalance asks for them; but they need more friction to be carried around.
"""

# %%
# The sample, with contacts a tenth as stiff as those of steel, which allows steps three times as long; and balls of the same
# mass in the same drum, in a layer of their own depth.

import tomllib

import matplotlib.pyplot as plt

import autobalancer as ab
from autobalancer.machine import ChamberMachine

described = tomllib.loads(ab.machine_text(ab.example("chamber_cylinders")))
described["contact"]["youngs_modulus"] = "20.6 GPa"
cylinders = ChamberMachine(**described)
balls = ab.chamber.variant(cylinders, balls=10, layers="single", body="ball")
for machine in (cylinders, balls):
    print(ab.check(machine).chambers[0])

# %%
# One study for each: a start of 8 s with little and with much friction.

studies = {
    body: ab.chamber.amplitudes(machine, [10], [0.3, 0.5], duration=8.0, layers=("single",))
    for body, machine in (("cylinders", cylinders), ("balls", balls))
}
for body, study in studies.items():
    for friction in (0.3, 0.5):
        found = study.sel(friction=friction).squeeze()
        carried, left = float(found["share_carried"]), float(found["residual_unbalance"]) / 0.06
        print(f"{body}, friction {friction}: {carried:.0%} carried around, {left:.1%} of the unbalance left")
assert float(studies["cylinders"].sel(friction=0.3)["share_carried"].squeeze()) == 0.0
assert float(studies["balls"].sel(friction=0.3)["share_carried"].squeeze()) == 1.0
left = {body: float(study.sel(friction=0.5)["residual_unbalance"].squeeze()) for body, study in studies.items()}
assert left["cylinders"] < 0.03 * 0.06
assert left["balls"] > 0.15 * 0.06  # ten of them can balance only 85 % of it

# %%
# On their way and in balance.

run = ab.simulate(cylinders, duration=8.0)
figure = ab.plot.chamber_arrangement(run, [0.0, 0.5, 8.0])

# %%
# A run holds cylinders parallel to the rotor. What contacts do to tilt them, over what these contacts could bear, is a
# variable of the run: here next to nothing, as all lie side by side between the flat walls. Short cylinders in the deep chamber
# push each other at their ends until they are carried around; what the run says of that time is no more than a guess.

deep = tomllib.loads(ab.machine_text(ab.example("deep_chamber")))
deep["contact"]["youngs_modulus"] = "2 GPa"
short = {"body": "cylinder", "count": 50, "density": "7800 kg/m^3", "total_mass": "1 kg", "length": "12 mm"}
deep["chambers"][0]["balls"] = [short]
loose = ab.simulate(ChamberMachine(**deep), duration=6.0, seed=1)
figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
for name, each in (("one layer", run), ("deep chamber", loose)):
    over = (each["tilting"] > 1.0).groupby((each["time"] // 0.2) * 0.2).mean()
    axes.step(over["time"], 100.0 * over, where="post", label=name)
axes.set(
    xlabel="time (s)",
    ylabel="samples in which a contact\nwould tilt a cylinder (%)",
    xlim=(0.0, 6.0),
    ylim=(-2.0, 100.0),
)
axes.legend()
print(ab.verdict(loose).notes[-1])
