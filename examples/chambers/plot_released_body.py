"""
A released body is balanced dynamically
=======================================

A drum with an unbalance and a couple stands on soft supports and may move in all six coordinates. A chamber with six balls at
each end takes away both within seconds. A body that cannot tilt, or a single layer of balls, leaves the couple; one deep
chamber finds its way along the axis, but slowly.
"""

# %%
# The machine, and three others with the same rotor: a body held in planar motion, one layer in the middle, one deep chamber.

import tomllib

import numpy as np

import autobalancer as ab
from autobalancer.machine import ChamberMachine

described = tomllib.loads(ab.catalog.example_path("released_body").read_text(encoding="utf-8"))
steel = {"density": "7800 kg/m^3", "total_mass": "1 kg"}
layer = {"radius": "100 mm", "balls": [{"count": 6, **steel}]}
deep = {"radius": "100 mm", "depth": "300 mm", "balls": [{"count": 12, **steel}]}
machines = {
    "two chambers": described,
    "two chambers, planar body": described | {"body": described["body"] | {"freedom": "planar"}},
    "one layer": described | {"chambers": [layer]},
    "one deep chamber": described | {"chambers": [deep]},
}
runs = {name: ab.simulate(ChamberMachine(**each), duration=12.0, seed=1) for name, each in machines.items()}

# %%
# What is left of unbalance and couple, the greatest in each tenth of a second.

static, couple = ab.chamber.unbalance_of(runs["two chambers"])
with ab.plot.style.look():
    figure = ab.plot.style.picture(8.0, 6.0)
    axes = figure.subplots(2, 1, sharex=True)
    for (name, run), color in zip(runs.items(), ab.plot.style.BALLS, strict=False):
        left = (
            ab.run_measures(run, "residual_of_balls", unbalance=static, couple=couple)
            .isel(time=slice(1, None))
            .coarsen(time=100, boundary="trim")
        )
        highest, time = left.max(), left.mean()["time"]
        axes[0].plot(time, 100.0 * highest["static"] / abs(static), color=color, label=name)
        axes[1].plot(time, 100.0 * highest["couple"] / abs(couple), color=color)
    axes[0].set_ylabel("unbalance left (%)")
    axes[1].set(ylabel="couple left (%)", xlabel="time (s)")
    for each in axes:
        each.set(yscale="log", ylim=(0.1, 1000.0))
    ab.plot.style.heading(figure, "What balls leave of unbalance and couple")
    ab.plot.style.legend(axes[0])

# %%
# In numbers: what is left in the last second, the tilting of the body, the force of a bearing about its mean.

for name, run in runs.items():
    measured = ab.run_measures(run, last=1.0)
    late = run.isel(time=slice(-1000, None))
    tilt = np.abs(late["body_rotation"] - late["body_rotation"].mean("time")).max()
    force = np.sqrt(((late["bearing_force"] - late["bearing_force"].mean("time")) ** 2).sum("axis").mean("time")).max()
    print(
        f"{name:26} unbalance {measured['residual_unbalance'] / abs(static):7.4f}  couple "
        f"{measured['residual_couple'] / abs(couple):7.4f}  tilt {1e6 * tilt:6.0f} urad  bearing {force:6.1f} N"
    )
assert float(ab.run_measures(runs["two chambers"], last=1.0)["residual_couple"]) < 0.02 * abs(couple)
assert float(ab.run_measures(runs["one layer"], last=1.0)["residual_couple"]) > 0.9 * abs(couple)
