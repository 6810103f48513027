"""Machine files with slips, and files made to do harm: each is refused in words, at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from autobalancer.errors import MachineError
from autobalancer.files.machine_file import parse_any
from autobalancer.files.rigs import rig_text

ROOT = Path(__file__).parents[1]
RACE = (ROOT / "docs/machines/real_race.toml").read_text(encoding="utf-8")


def refused(text: str) -> str:
    with pytest.raises(MachineError) as reason:
        parse_any(text, "m.toml", folder=ROOT / "docs/machines")
    return str(reason.value)


def test_an_excitation_or_a_joint_without_its_kind_is_told_which_kinds_there_are() -> None:
    before, _, after = RACE.partition("[[excitations]]")
    told = refused(before + "[[excitations]]" + after.replace('kind = "base_motion"', "", 1))
    assert "excitations[1]: given" in told
    assert "'kind', which must be one of 'base_motion', 'recorded_base_motion', 'force', 'recorded_force'" in told
    told = refused(rig_text("discoidal_rig").replace('kind = "lock"', "", 1))
    assert "joints[1]: given" in told
    assert "one of 'lock', 'dashpot'" in told
