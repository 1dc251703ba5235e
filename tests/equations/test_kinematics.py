"""Kinematics are values: reading them adds no frame, and velocities that wait are those computed at once."""

from __future__ import annotations

import pickle
from pathlib import Path

import symbody as sb
from symbody.equations.kinematics.lazy_mapping import LazyMapping, Rule

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_frames_of_contacts_stand_from_the_beginning() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "bicycle" / "bicycle.toml"))
    kinematics = eqs.formed.kinematics
    frames = (set(kinematics.shifts), set(kinematics.tree.parents), set(kinematics.velocities))
    assert all("rear_tyre" in names for names in frames)
    eqs.frame_motion("r", "rear_tyre")
    assert frames == (set(kinematics.shifts), set(kinematics.tree.parents), set(kinematics.velocities))
    assert eqs.formed.kinematics is kinematics


def test_a_lazy_mapping_computes_each_value_once_and_only_when_read() -> None:
    computed: list[str] = []

    def following(name: str) -> Rule[int]:
        def add(before: int) -> int:
            computed.append(name)
            return before + 1

        return str(int(name) - 1), add

    mapping = LazyMapping({"0": 0}, {str(k): following(str(k)) for k in range(1, 5000)})
    assert "4999" in mapping and len(mapping) == 5000 and not computed
    assert mapping["3000"] == 3000 and len(computed) == 3000
    assert mapping["2999"] == 2999 and len(computed) == 3000
    assert pickle.loads(pickle.dumps(LazyMapping({"a": 1}, {}))) == {"a": 1}
    assert list(mapping)[:2] == ["0", "1"]
