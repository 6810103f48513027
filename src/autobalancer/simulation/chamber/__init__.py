"""Runs of machines whose balls move freely in chambers."""

from autobalancer.simulation.chamber.run import simulate_chamber

__all__ = ["simulate_chamber"]
