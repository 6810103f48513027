"""Runs of machines whose balls move freely in chambers."""

from autobalancer.simulation.chamber.chamber_run import simulate_chamber

__all__ = ["simulate_chamber"]
