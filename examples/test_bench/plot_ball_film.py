"""
Balls in a film
===============

A camera looks at a race from the side. From marks of known place the program knows how it stands, and follows the balls,
which look alike, through their impacts. Here the film is made of a simulated run-up, so the truth is known.
"""

# %%
# Two balls at the beginning of a run-up. The camera stands still, 30 degrees off the axis; one picture in fifty is lost.

import numpy as np

import autobalancer as ab

machine = ab.example("stall_and_release")
run = ab.simulate(machine, duration="0.4 s", save=ab.Samples(801))
camera = ab.measure.film_camera(run, tilt="30 deg", width=640, height=480)
exposure = ab.measure.Exposure(frame_rate=100, time="0.2 ms", noise=0.01, lost=0.02)
film = ab.measure.render_film(run, camera=camera, exposure=exposure)

# %%
# A set-up says what a person would measure on the rig: places of marks, and about where they are in the picture. One picture
# seen from straight above shows whether all of it is right.

setup = ab.measure.film_setup(run, camera)
figure = ab.plot.answer(ab.measure.rectified_picture(film, setup, 10))

# %%
# All angles come with their standard deviations.

found = ab.measure.track_balls(film, setup)
figure = ab.plot.answer(found)
print(found)

# %%
# They are those of the run.

known = np.interp(film.time, run["time"], run["ball_angle_in_rotor"][:, 0])
away = np.degrees(np.angle(np.exp(1j * (found["ball_angle"].values - known[:, None]))))
print(f"ball 1 of the run is within {np.nanmin(np.nanmax(np.abs(away), axis=0)):.2f} degrees of one in the film")

# %%
# A single picture will do for balls at rest, from a camera that turns with the rotor: here the end of each of eight run-ups.
# Their places are counted around the rotor; all are opposite to the unbalance.

photos = []
for seed in range(8):
    ended = ab.simulate(ab.example("one_ball_run_up"), save=ab.Samples(4001), seed=seed)
    last = float(ended["time"][-1])
    above = ab.measure.film_camera(ended, width=480, height=480, turning=True)
    picture = ab.measure.render_film(ended, camera=above, start=last - 0.05, end=last)
    photos.append(ab.measure.photographed_angles(picture.pictures[-1], ab.measure.film_setup(ended, above)))
    away = float(photos[-1]["ball_angle"][0] - ended["ball_angle_in_rotor"][-1, 0])
    assert abs(np.angle(np.exp(1j * away))) < np.radians(0.5)
figure = ab.plot.answer(ab.measure.rest_histogram(photos, bins=24))
