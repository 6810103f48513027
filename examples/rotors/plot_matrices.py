"""
A rotor from a program of finite elements
=========================================

A rotor that exists as matrices of another program gets its balancer here. In this example the matrices are those of the
centrifuge rotor on its elastic shaft, Spannan (2021), section 6.2, written as such a program would: in t, mm and s.
"""

# %%
# Two files: the matrices, and a table that says what their rows are. Slopes are dx/dz = ry and dy/dz = -rx.

from pathlib import Path
from tempfile import mkdtemp

import numpy as np

import autobalancer as ab

shaft = ab.with_parameter(ab.example("cfrp_rig"), "stations[2].position", 0.18)  # the race at the end of the shaft
model = ab.rotor.lateral_model(shaft)
folder = Path(mkdtemp())

lines, factors = ["node, direction, position [mm]"], []
for name in model.coordinates:  # such as "x at 9 mm", "y slope at 9 mm"
    axis, position = name[0], name.split()[-2]
    direction = {"x": "ry", "y": "rx"}[axis] if "slope" in name else f"u{axis}"
    lines.append(f"{position}, {direction}, {position}")
    factors.append((1e3 if "slope" in name else 1.0) * (-1.0 if direction == "rx" else 1.0))
(folder / "nodes.csv").write_text("\n".join(lines))
scale = 1e-3 * np.outer(factors, factors)
matrices = {"M": model.mass, "K": model.stiffness[0], "C": model.damping[0], "G": model.gyroscopic}
np.savez(folder / "rotor.npz", **{name: scale * matrix for name, matrix in matrices.items()})

# %%
# The machine file names them. Three nodes are kept, and three modes of the rotor with these held.

text = """
name = "centrifuge rotor of finite elements"
axis = "vertical"
stations = [{ name = "sleeve", position = "165.5 mm" }, { name = "annulus", position = "180 mm" }]
unbalances = [{ moment = "300 g*mm", station = "annulus" }]
drive = { kind = "speed", profile = { kind = "table", time = [0, 100], speed = ["0 rad/s", "50 rad/s"] } }
run = { duration = "120 s" }

[rotor]
kind = "matrices"

[rotor.files]
file = "rotor.npz"
nodes = "nodes.csv"
length_unit = "mm"
mass_unit = "t"
keep = ["0 mm", "165.5 mm", "180 mm"]
modes = 3

[[balancers]]
station = "annulus"

[[balancers.races]]
orbit_radius = "73.55 mm"
fluid = { name = "silicone oil 10", temperature = "25 degC" }
drag = { law = "race_geometry", clear_width = "10.815 mm" }

[[balancers.races.balls]]
count = 2
mass = "4.4 g"
diameter = "10.3 mm"
motion = "rolling"
start_angles = ["40 deg", "250 deg"]
"""
machine = ab.parse_machine(text, folder=folder)
print(machine.rotor.source)

# %%
# It has the modes and border speeds of the shaft.

figure = ab.plot.campbell(
    ab.rotor.campbell(machine, np.linspace(0.0, 60.0, 61), balls=False, modes=4), speed_unit="rad/s"
)
for border, same in zip(ab.stability.borders(machine), ab.stability.borders(shaft), strict=True):
    if np.isfinite(border.speed):
        print(f"{border.name}: {border.speed:.4f} rad/s, with the shaft {same.speed:.4f} rad/s")

# %%
# And its balls run as in the shaft.

run, reference = ab.simulate(machine), ab.simulate(shaft)
figure = ab.plot.run_up(run)
apart = float(abs(run["ball_angle_in_rotor"] - reference["ball_angle_in_rotor"]).max())
print(f"angles of the balls differ by at most {apart:.1e} rad")
