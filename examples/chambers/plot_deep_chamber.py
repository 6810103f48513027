"""
Balls in a deep chamber
=======================

Twelve balls lie at the bottom of a deep chamber. When the motor starts they slide, pile up and collide; with enough friction
the wall carries them around, and seconds later they have found places that balance the rotor.
"""

# %%
# The reference machine, with twelve balls of 1 kg together and a friction of 0.7.

from pathlib import Path

from autobalancer.files.machine_file import load_chamber_machine
from autobalancer.plots.chamber_arrangement import plot_arrangement
from autobalancer.plots.chamber_history import plot_chamber_run, plot_energy
from autobalancer.results.chamber_measures import chamber_measures
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.studies.chamber_machines import chamber_variant

here = Path("examples") if Path("examples/machines").is_dir() else Path("..")
machine = chamber_variant(load_chamber_machine(here / "machines" / "deep_chamber.toml"), balls=12, friction=0.7)
run = simulate_chamber(machine, duration=16.0)
figure = plot_chamber_run(run)

# %%
# At rest, on their way, and in balance: seen from the front, and with the race unrolled from the unbalance on.

figure = plot_arrangement(run, [0.0, 1.0, 16.0])

# %%
# Where the work of the motor went, and how well the balance closes.

figure = plot_energy(run)
measured = chamber_measures(run)
for name in ("share_carried", "vertical_synchronous", "residual_unbalance", "energy_error"):
    print(f"{name}: {float(measured[name]):.3g} {measured[name].attrs['units']}")
assert float(measured["share_carried"]) == 1.0
assert float(measured["residual_unbalance"]) < 0.03 * 0.06
assert float(measured["energy_error"]) < 1e-3
