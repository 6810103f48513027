"""The worst of random starts as a machine of its own, to run it again and look at it."""

from __future__ import annotations

import xarray as xr

from autobalancer.assembly.parameters import with_value_at
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_race_machine
from autobalancer.machine import Machine
from autobalancer.studies.random_starts import driven_to


def worst_start(found: xr.Dataset) -> Machine:
    """The machine of the worst of random starts, with its start angles, its drive and the duration of its run.

    The worst has the greatest vibration at the end of its run, of run-ups that all balance the greatest deflection on the
    way, on planar machines without run-up the greatest deflection at its end; ``found.attrs["worst_by"]`` says which.
    An ordinary run of the machine repeats it, with the same tolerance and the seed ``found["seed"][found.attrs["worst"]]``
    digit for digit. A planar basin lets balls of known size pass through each other, which they do not in a run.

    Parameters
    ----------
    found
        From :func:`autobalancer.basin` with random starts.

    Raises
    ------
    QuestionError
        If ``found`` holds no random starts.
    """
    if "start_ball_angle_in_rotor" not in found:
        raise QuestionError(
            "worst_start: this is not a result of basin() with random starts; ask basin(..., random=50)"
        )
    about = found.attrs
    number, speed, acceleration = int(about["worst"]), float(about["speed"]), float(about["acceleration"])
    ramp = speed / acceleration if acceleration else 0.0
    machine = driven_to(parse_race_machine(str(about["machine"])), speed, ramp)
    angles = found["start_ball_angle_in_rotor"].values[number].tolist()
    for i, balancer in enumerate(machine.balancers, start=1):
        for j, race in enumerate(balancer.races, start=1):
            groups = []
            for group in race.balls:
                own, angles = angles[: group.count], angles[group.count :]
                groups.append(group.model_copy(update={"start_angles": tuple(own)}))
            machine = with_value_at(machine, f"balancers[{i}].races[{j}].balls", tuple(groups))
    text = f"Start {number + 1} of {found.sizes['run']} random starts, the worst"
    return with_value_at(with_value_at(machine, "description", text), "run", {"duration": ramp + float(about["hold"])})
