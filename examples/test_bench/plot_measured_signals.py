"""
Balls that do not turn with the rotor, in the signals of a logger
=================================================================

A rotor runs up past its critical speed and stays above it while the balls of its balancer hang near the critical speed. What do a
displacement sensor and a tacho show of this? The signals are made of a simulated run, so that it is known what they should show.
"""

# %%
# The run-up ends at 330 rad/s; the balls would be released above. A logger records the displacement, with noise, and one pulse a
# turn.

import autobalancer as ab

text = ab.catalog.example_path("stall_and_release").read_text(encoding="utf-8").replace("500 rad/s", "330 rad/s")
run = ab.simulate(ab.parse_machine(text), save=ab.Samples(24000))
sensors = [ab.measure.Sensor("displacement", name="x", noise="40 dB"), ab.measure.Tacho()]
signals = ab.measure.record(run, sensors, "1 kHz", start=1.0, seed=1)
turned = ab.measure.rotor_angle(signals)
print(turned)

# %%
# Over the frequency, the vibration of the unbalance follows the line of order 1. From the critical speed on there is another one,
# which stays where it is: that of the balls. This is figure 6.22 of Spannan (2021) in kind.

rising = ab.measure.rotor_angle(ab.measure.record(run, sensors, "1 kHz", start=1.0, end=15.0, seed=1))
figure = ab.plot.order_map(
    ab.measure.order_map(rising, "x", over="frequency", revolutions=32, highest=500.0), orders=(1, 2)
)

# %%
# At the final speed the spectrum tells both apart and names them.

steady = ab.measure.rotor_angle(ab.measure.record(run, sensors, "1 kHz", start=15.5, seed=1))
spectrum = ab.measure.spectrum(steady, "x", resolution="0.5 Hz", natural=[250.0])
figure = ab.plot.spectrum(spectrum, highest=600.0)
print(spectrum)

# %%
# The strongest subsynchronous line is the speed of the balls in the run, which no sensor saw.

lines = spectrum.isel(line=spectrum["line_name"].str.startswith("subsynchronous").values)
balls = float(run["ball_speed_in_space"].sel(time=slice(15.5, None)).mean())
print(f"line at {float(lines['line_frequency'][0]):.2f} rad/s, balls at {balls:.2f} rad/s")
assert abs(float(lines["line_frequency"][0]) - balls) < 0.5

# %%
# The balls are only 13 Hz away from the first order. A window of some revolutions would let them through as a beat; a Vold-Kalman
# filter of 4 Hz keeps them out where they are that far away. At the final speed its amplitude is that of the line.

orders = ab.measure.orders(rising, method="vold-kalman", bandwidth="4 Hz")
figure = ab.plot.orders(orders)
at_end = ab.measure.orders(steady, method="vold-kalman", bandwidth="4 Hz")["amplitude"].values[0, 0, 500:-500]
line = float(spectrum["line_amplitude"][spectrum["line_name"].values == "order 1"][0])
print(f"order 1: {1e6 * at_end.mean():.1f} µm by the filter, {1e6 * line:.1f} µm in the spectrum")
assert abs(at_end.mean() / line - 1.0) < 0.05
