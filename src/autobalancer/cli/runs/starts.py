"""What is said of balls that start at random."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalancer.cli.terminal.words import note

if TYPE_CHECKING:
    from autobalancer.machine import Machine


def say_seed(machine: Machine, seed: int) -> None:
    """Say that a run is one sample, where balls have no start angles."""
    groups = [group for balancer in machine.balancers for race in balancer.races for group in race.balls]
    if any(group.start_angles is None for group in groups):
        note(f"the start angles of the balls are random, seed {seed}: this is one sample; try others with --seed")
