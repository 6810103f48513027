"""Workers begin with kernels of their own, so that those of a fresh checkout are not compiled twice at the same time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]


def pytest_configure(config: Any) -> None:
    worker = getattr(config, "workerinput", {}).get("workerid")
    if worker == "gw0":
        import autobalancer as ab

        ab.simulate(ROOT / "examples/machines/discoidal.toml", duration=0.01)
        ab.simulate(ROOT / "examples/machines/resolved_balls.toml", duration=0.01)
        ab.basin(ROOT / "examples/machines/discoidal.toml", 100.0, random=2, hold=0.01)
    elif worker == "gw1":
        import autobalancer as ab
        from autobalancer.files.machine_file import load_chamber_machine
        from autobalancer.simulation.chamber import simulate_chamber

        simulate_chamber(load_chamber_machine(ROOT / "examples/machines/deep_chamber.toml"), duration=0.002)
        ab.simulate(ROOT / "examples/machines/rigid_rotor.toml", duration=0.01)
        ab.simulate(ROOT / "docs/machines/real_race.toml", duration=0.01)
