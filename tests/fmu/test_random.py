"""FMUs of random mechanisms with loops, with a signal and with an event that sets it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.fmu import binaries
from tests.fmu.importer import KINDS, check_archive, simulate, states
from tests.laws.mechanisms import random_mechanism
from tests.laws.model_files import model_with_state

pytestmark = [
    pytest.mark.exhaustive,
    pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler"),
]
# With loops and at most twelve states: compilers take long for the derivatives of more.
SEEDS = (8, 16, 21, 23, 26, 27, 28, 32, 33, 38, 41, 47, 49, 51, 88, 90, 91, 93, 98, 118)


def with_signal(model: sb.Model, coordinate: str, span: float) -> sb.Model:
    """The model with a signal that follows a coordinate."""
    signal = sb.Signal("follower", rate=f"({coordinate} - follower)/{span!r}")
    return sb.Model(
        model.name, [*model.elements, signal], model.gravity, dict(model.parameters), model.inputs,
        dict(model.initial), dict(model.ground), model.notes, model.ground_shapes,
    )  # fmt: skip


@pytest.mark.parametrize("seed", SEEDS)
def test_random_mechanisms(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binaries, "FLAGS", (*binaries.FLAGS, "-O0"))  # the optimizer takes most of the time
    version = ("2.0", "3.0")[seed % 2]
    model = model_with_state(random_mechanism(seed))
    plain = sb.form_equations(model)
    assert plain.multiplier_names
    end = 0.2 * mechanism_scales(plain, {}).time
    times = np.linspace(0.0, end, 21)
    motion = sb.simulate(plain, end, times=times, rtol=1e-11)
    travel = np.ptp(motion.q, axis=1) / np.maximum(np.abs(motion.q).max(axis=1), 1e-30)
    coordinate = plain.coordinate_names[int(np.argmax(travel))]
    level = float(motion[coordinate][9:11].mean())  # between samples
    eqs = sb.form_equations(with_signal(model, coordinate, end))
    event = sb.Event(f"{coordinate} - ({level!r})", 0, {"follower": "2*follower"}, "passing")
    run = sb.simulate(eqs, end, times=times, rtol=1e-11, events=[event])
    made = sb.save_fmu(eqs, tmp_path / "mechanism.fmu", version, events=[event])  # type: ignore[arg-type]
    check_archive(made.path, version)
    nominal = {variable.name: variable.nominal for variable in made.variables}
    x = states(run)
    sizes = np.maximum([nominal[name] for name in eqs.state_names[:-1]], np.abs(x[:-1]).max(axis=1))
    sizes = np.append(sizes, np.abs(x[-1]).max())
    for kind in KINDS:
        seen = simulate(made.path, kind, end, [*eqs.state_names, "constraint_violation"], 1e-9)
        assert (np.abs(seen[:-1] - x) / sizes[:, np.newaxis]).max() < 1e-4, kind
        assert seen[-1].max() < 1e-6, kind
