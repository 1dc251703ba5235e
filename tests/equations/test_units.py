"""Units of outputs by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symbody as sb


def crane() -> sb.EquationSet:
    joints = [
        sb.Prismatic("slide", "ground", "Cart", axis="x", coordinate="x", force=sb.Drive("F")),
        sb.Revolute("hinge", "Cart", "Load", axis="z", coordinate="phi", motion="sin(t)"),
        sb.Revolute("free", "Load", "Tail", axis="z", coordinate="psi"),
    ]
    bodies = [sb.Body(name, mass=1, inertia=(1, 1, 1)) for name in ("Cart", "Load", "Tail")]
    return sb.form_equations(sb.Model("crane", [*bodies, *joints], inputs=["F"]))


def test_units_of_what_joints_and_frames_tell(tmp_path: Path) -> None:
    run = sb.simulate(crane(), 0.1)
    run.save(tmp_path / "run.npz")
    expected = {
        "x": "m", "x_dot": "m/s", "x_ddot": "m/s^2", "phi": "rad", "phi_dot": "rad/s", "energy": "J", "F": "N",
        "effort slide": "N", "effort hinge": "N m",
        "reaction hinge Fx": "N", "reaction hinge Fz": "N", "reaction slide Mx": "N m", "reaction slide Mz": "N m",
        "frame r Load ground": "m", "frame v Load ground ground x": "m/s", "frame vdot Load Cart": "m/s^2",
        "frame w Load ground": "rad/s", "frame wdot Load ground": "rad/s^2",
    }  # fmt: skip
    for found in (run, sb.Trajectory.load(tmp_path / "run.npz")):
        assert {name: found.units.get(name) for name in expected} == expected
        for unknown in ("effort free", "frame R Load ground", "frame", "frame r", "E"):
            assert (unknown in found.units) is (unknown == "frame r")
        with pytest.raises(KeyError):
            found.units["E"]
        assert len(found.units) == len(list(found.units)) == len(dict(found.units))


def test_a_unit_belongs_to_an_output() -> None:
    """Outputs that are listed can be computed; differences over time have the units of rates."""
    eqs = crane()
    state = sb.assemble(eqs)
    for name in eqs.units:
        if name not in ("t", "work", "psi_ddot", "x_ddot", "phi_ddot"):
            assert np.isfinite(state[name]).all()
