"""
Tutorial 3: a real rotor
========================

A rotor that tilts and bends has more than one critical speed, and one plane of balls is not enough. Modes, Campbell
diagram, unbalance response and balancing in two planes, on two published rigs.
"""

# %%
# Where the rotor is held
# -----------------------
#
# Tutorials 1 and 2 had a planar rotor, which only moves sideways. A real one has a length. The rig of Rodrigues et al.
# (2011) is a rigid rotor in two bearings, which are stiffer along x than along y, with one race of balls on its disk.

import numpy as np

import autobalancer as ab

RPM = np.pi / 30.0  # rad/s
rig = ab.example("rodrigues_rig")
ab.plot.machine(rig)

# %%
# How it wants to move
# --------------------
#
# A rotor on springs has modes, like a bell. With its balls held and at standstill there are four of interest here: the
# rotor moves up and down (*cylindrical*) or tilts (*conical*), each along x and y.

modes = ab.rotor.modes(rig, balls=False, modes=4)
modes

# %%
# A table of frequencies says little. Look at the shapes: the points on the axis at rest are where a force would not
# excite the mode, and where a balancer could do nothing about it.

ab.plot.modes(modes)

# %%
# The frequencies depend on the speed, since a spinning rotor resists tilting. The Campbell diagram has them over the
# speed. An unbalance excites with the frequency of the rotation, the line of order 1; where it meets a natural frequency
# is a critical speed.

campbell = ab.rotor.campbell(rig, np.linspace(0.0, 5000.0, 101) * RPM, balls=False, modes=4)
ab.plot.campbell(campbell)

# %%
# This rotor is slender: its polar inertia is small and its lines are nearly horizontal. A rotor that is almost flat is
# quite different. That of the centrifuge of Spannan (2021), on an elastic shaft, has lines that fan out:

centrifuge = ab.example("cfrp_rig")
ab.plot.machine(centrifuge)

# %%

fan = ab.rotor.campbell(centrifuge, np.linspace(0.0, 60.0, 61), balls=False, modes=4)
ab.plot.campbell(fan, speed_unit="rad/s")

# %%
# Its spin stiffens forward whirl and softens backward whirl. The supports of this rotor are the same along x and y, so
# that an unbalance, which turns forward, excites forward whirl only: one of the two circles is harmless. On the rig
# above, each of the four is met.
#
# What its unbalance makes of it
# ------------------------------
#
# Back to the rig. The critical speeds are where it *can* be in resonance; how much it vibrates depends on where the
# unbalance is, and in which direction. The response at both bearings:

response = ab.rotor.response(rig, np.linspace(600.0, 5000.0, 1200) * RPM, ["B1", "B2"])
ab.plot.response(response)

# %%
# The peaks lie near the critical speeds, not at them: damping moves a single peak up, and where modes are close to each
# other, each stands on the slope of the next. What a test bench measures is the peaks.

peaks = ab.rotor.response_peaks(rig, 1000.0 * RPM, 3000.0 * RPM, ["B1", "B2"])
critical = ab.rotor.critical_speeds(rig, balls=False)
print("peaks:          ", np.round(np.sort(peaks["peak_speed"].values) / RPM, 1), "rpm")
print("critical speeds:", np.round(critical["critical_speed"].values / RPM, 1), "rpm")

# %%
# One plane of balls
# ------------------
#
# A run at 4500 rpm, above all four critical speeds, with two balls in the race on the disk:

run = ab.simulate(rig)
print(ab.verdict(run))

# %%
# Compare the three places. The disk, where the race is, hardly moves any more; but both bearings still do. The unbalance
# and the misalignment of the rotor are a force *and* a moment. Balls in one plane make a force only, so that the rotor
# turns about the place that they hold still:

ab.plot.orbit(run)

# %%
# Two planes
# ----------
#
# A force and a moment need two planes. The sample ``two_plane_rotor`` has a balancer at each end. ``check`` says what
# each of them has to do, which does not depend on the speed; it is like the two reactions of a beam.

rotor = ab.example("two_plane_rotor")
checked = ab.check(rotor)
for plane in checked.stations:
    print(f"{plane.name}: needs {1e6 * plane.required:.1f} g mm, has {1e6 * plane.capability:.1f} g mm")
ab.plot.machine(rotor)

# %%
# With both balancers, and with the upper one alone:

alone = ab.with_parameter(rotor, "balancers", [rotor.balancers[1]])
both = ab.compare({"both planes": rotor, "upper plane alone": alone})
both

# %%
# As above, one plane brings its own place to rest and leaves the other. Two planes leave nothing:

two_planes = ab.simulate(rotor)
ab.plot.race(two_planes)

# %%
# From which speed on? The balls of two planes have more ways of moving against each other, so the border speed is above
# *both* critical speeds, not the first one:

print("critical speeds:", [f"{speed / RPM:.0f} rpm" for speed in checked.critical_speeds])
windows = ab.stability.stable_windows(rotor, 1000.0)
print(windows)
assert windows.windows[0][0] > max(checked.critical_speeds)

# %%
# Exercises
# ---------
#
# 1. Move the race of the rig to another place: ``ab.with_parameter(rig, "stations[3].position", "60 mm")``. Which bearing
#    is the quieter one now? Is there a place at which one plane is enough?
# 2. ``disk_like_rotor`` is the two-plane rotor with a greater polar inertia. Draw its Campbell diagram. Why does it have
#    one critical speed less, and what does ``stable_windows`` say of it?
# 3. How would you find the stiffness of the bearings of your own rig? Tutorial 4 does it from what was measured.
