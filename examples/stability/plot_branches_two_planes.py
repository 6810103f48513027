"""
What the balls of two planes can do
===================================

A rotor that moves and tilts, with a balancer at each end. At which speed does the balanced state become unstable, which motion
follows, and up to which speed can all balls stay stalled at the second resonance?
"""

# %%
# The balanced state, from 176 rad/s down. It becomes unstable at a supercritical Hopf point, the exact border; just below it the
# balls of both planes swing together. The motion is stable in a very narrow range only and ends at a fold: below that
# the balls leave.

import autobalancer as ab

rotor = ab.example("two_plane_rotor")
found = ab.stability.branches(rotor, "speed", "176 rad/s", "174.5 rad/s")
motions = ab.plot.branches(found, speed_unit="rad/s")

# %%
# The state in which all four balls are stalled: they turn with the second resonance, which gyroscopic effects raise with the
# speed, while the rotor runs on. They stay together up to 206.75 rad/s. Beyond it the balls of a plane separate.

stalled = ab.stability.branches(rotor, "speed", "150 rad/s", "214 rad/s", from_state="stalled")
resonance = ab.plot.branches(stalled, speed_unit="rad/s")

# %%
# The numbers of the pictures, and the border that the scan over the speed finds.


def places(data, kind):
    """Speeds of the special points of one kind."""
    return data["special_parameter"].values[data["special_type"].values == kind]


(border,) = (one for one in ab.stability.borders(rotor) if one.name == "exact border")
hopf, swings_end = places(found, "Hopf")[0], places(found, "fold")[0]
part, stalled_end = places(stalled, "branch point")[0], places(stalled, "fold")[0]
print(f"balanced from {hopf:.3f} rad/s on; the balls swing down to {swings_end:.3f} rad/s")
print(f"all balls stalled together up to {part:.2f} rad/s; the branch turns back at {stalled_end:.2f} rad/s")
assert abs(hopf / border.speed - 1.0) < 1e-9
assert swings_end < hopf < part < stalled_end
