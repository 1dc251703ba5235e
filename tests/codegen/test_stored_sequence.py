"""Sequences kept on the disk: found by the equations they follow from, and by nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.codegen import stored_sequence
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.signature import Signature
from symbody.codegen.stored_sequence import read_sequence, store_sequence
from symbody.equations import cache_key as known
from symbody.equations import form as forming
from symbody.errors import CompileError, FormulationError
from symbody.expr import opcodes as op
from symbody.expr.graph import Constant
from symbody.expr.sequences.sequence import Operation, Sequence
from symbody.model.content import content_bytes
from symbody.storage import VARIABLE
from tests.codegen.sequences import EXACT, LIBRARY, TRIGONOMETRIC, random_sequence, same_bits
from tests.tiers import cases

LINKS = 11  # enough for a sequence that is kept
SIGNATURE = Signature(("q é", "q1"), ("u0",), (), ("p\n",))


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "kept"))
    return tmp_path / "kept"


def chain(links: int = LINKS, g: float | str = 9.81, name: str = "chain", **changes: object) -> sb.Model:
    """A chain with enough operations to be kept."""
    elements: list[Any] = []
    for k in range(links):
        frames = {"in": sb.Frame(at=(0, 0, "-l")), "out": sb.Frame(at=(0, 0, "l"))}
        elements.append(sb.Body(f"B{k}", mass="m", inertia=(0.2, 0.2, 0.1), frames=frames))
        start = "ground" if k == 0 else f"B{k - 1}.out"
        drive = sb.Drive(applied="F") if k == 0 else None
        elements.append(
            sb.Revolute(f"J{k}", start, f"B{k}.in", axis="xyz"[k % 3], coordinate=f"q{k}", torque=drive)
        )
    parameters: dict[str, Any] = {"m": 1, "l": 0.5, "g": g} | changes
    return sb.Model(name, elements, gravity=(0, "-g", 0), parameters=parameters, inputs=["F"])


def values(function: Callable[..., Any], links: int = LINKS) -> list[float]:
    q, u = np.linspace(0.1, 0.9, links), np.linspace(-1.0, 1.0, links)
    return [float(x) for x in np.ravel(function(0.0, q, u, [0.3]))]


def refused(*_: object, **__: object) -> None:
    raise AssertionError("equations were formed")


@pytest.mark.parametrize("seed", range(4))
def test_a_sequence_is_read_as_it_was_written(seed: int) -> None:
    sequence, _ = random_sequence(seed, 800, (*EXACT, *LIBRARY, *TRIGONOMETRIC))
    exact: tuple[Constant, ...] = (10**40, Fraction(-1, 3 * 10**30), 5e-324, 1.7976931348623157e308, 0.1, 7)
    sequence = replace(sequence, constants=(*sequence.constants, *exact))
    assert store_sequence(b"key", sequence, SIGNATURE)
    assert read_sequence(b"key") == (sequence, SIGNATURE)
    found, _ = read_sequence(b"key") or (None, None)
    assert found is not None
    assert [type(x) for x in found.constants] == [type(x) for x in sequence.constants]
    assert read_sequence(b"another") is None


def test_small_ones_and_those_without_a_key_are_not_kept(place: Path) -> None:
    sequence, _ = random_sequence(1, 30, EXACT)
    assert not store_sequence(b"key", sequence, SIGNATURE)
    large = replace(sequence, operations=sequence.operations + (Operation(op.PI, ()),) * 500)
    assert not store_sequence(b"", large, SIGNATURE)
    assert not place.exists() and read_sequence(b"") is None


def test_the_second_time_nothing_is_formed(monkeypatch: pytest.MonkeyPatch) -> None:
    eqs = sb.form_equations(chain())
    first = sb.compile(eqs, "udot", {"m": 2.0}, free=["l"])
    monkeypatch.setattr(forming, "derive", refused)
    again = sb.form_equations(chain())
    second = sb.compile(again, "udot", {"m": 2.0}, free=["l"])
    assert second.signature == first.signature
    expected = values(partial(first, p=[0.5]))
    assert same_bits(values(partial(second, p=[0.5])), expected)
    assert again.notes == eqs.notes
    with pytest.raises(AssertionError, match="were formed"):  # other outputs need the equations
        sb.compile(again, "mass_matrix")


def test_equations_that_waited_are_the_same() -> None:
    eqs = sb.form_equations(chain())
    expected = values(sb.compile(eqs, "udot"))
    later = sb.form_equations(chain())
    assert isinstance(later._given, known.DeferredEquations)
    matrices = [values(sb.compile(which, "mass_matrix")) for which in (eqs, later)]
    assert same_bits(*matrices)
    assert same_bits(expected, values(sb.compile(later, "udot")))
    assert later.coordinate_names == eqs.coordinate_names and repr(later) == repr(eqs)


def test_threads_that_ask_at_once_get_the_same_equations() -> None:
    sb.compile(sb.form_equations(chain()), "udot")
    later = sb.form_equations(chain())
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: later.formed, range(4)))
    assert all(formed is found[0] for formed in found)


def keys_of_variants() -> list[bytes]:
    """Keys of things that differ in one respect each."""
    found: list[bytes] = []

    def key(eqs: sb.EquationSet, *asked: object) -> None:
        found.append(stored_sequence.sequence_key(eqs.identity, content_bytes(*asked)))

    plain: tuple[object, ...] = (("udot",), {}, (), {})
    models = [
        chain(3),
        chain(4),
        chain(3, g=9.82),
        chain(3, g="981/100"),
        chain(3, name="other"),
        chain(3, extra=1),
    ]
    for model in models:
        key(sb.form_equations(model), *plain)
    for how in (sb.VirtualWork(), sb.Lagrange(), sb.Recursive(), sb.Recursive(method="composite")):
        key(sb.form_equations(chain(3), how), *plain)
    joints = [f"J{k}" for k in range(3)]
    trees: list[Any] = ["joints", sb.Trees(joints, joints)]
    for tree in trees:
        key(sb.form_equations(chain(3), tree=tree), *plain)
    eqs = sb.form_equations(chain(3))
    key(eqs, ("udot", "qdot"), {}, (), {})
    key(eqs, ("udot",), {"m": 2}, (), {})
    key(eqs, ("udot",), {"m": 2.0}, (), {})
    key(eqs, ("udot",), {"l": 2}, (), {})
    key(eqs, ("udot",), {"m": "l"}, (), {})
    key(eqs, ("udot",), {}, ("m",), {})
    key(eqs, ("udot",), {}, ("l", "m"), {})
    key(eqs, ("udot",), {}, ("m", "l"), {})
    key(eqs, ("udot",), {}, (), {"F": "m"})
    return found


def test_whatever_differs_has_another_key(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = keys_of_variants()
    assert all(keys) and len(set(keys)) == len(keys)
    assert keys_of_variants() == keys
    monkeypatch.setattr(known, "_sources", lambda: b"another version")
    assert not set(keys) & set(keys_of_variants())


def test_overrides_and_inputs_are_not_mixed_up() -> None:
    eqs = sb.form_equations(chain())
    asked: list[dict[str, Any]] = [
        {}, {"parameters": {"m": 2.0}}, {"parameters": {"m": 3.0}}, {"inputs": {"F": "2*m"}},
    ]  # fmt: skip
    first = [form_sequence(eqs, "udot", **one) for one in asked]
    again = [form_sequence(sb.form_equations(chain()), "udot", **one) for one in asked]
    assert first == again
    assert len({repr(sequence) for sequence, _ in first}) == len(asked)


@pytest.mark.parametrize(
    "damage", cases(["cut", "changed", "exchanged", "empty"], fast=["changed", "exchanged"])
)
def test_damaged_and_foreign_files_are_made_again(place: Path, damage: str) -> None:
    expected = values(sb.compile(sb.form_equations(chain()), "udot"))
    sb.compile(sb.form_equations(chain(g=1.0)), "udot")
    paths = sorted(place.iterdir())
    contents = [path.read_bytes() for path in paths]
    for path, content, other in zip(paths, contents, contents[1:] + contents[:1], strict=True):
        middle = len(content) // 2
        changed = content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
        path.write_bytes({"cut": content[:-3], "changed": changed, "exchanged": other, "empty": b""}[damage])
    assert same_bits(values(sb.compile(sb.form_equations(chain()), "udot")), expected)


def test_folders_open_to_others_are_not_read(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if sys.platform == "win32":
        pytest.skip("folders have no such modes there")
    sb.compile(sb.form_equations(chain()), "udot")
    place.chmod(0o777)
    monkeypatch.setattr(forming, "derive", refused)
    with pytest.raises(AssertionError, match="were formed"):
        sb.form_equations(chain())


def test_errors_come_every_time_and_are_not_kept() -> None:
    model = chain()
    for _ in range(2):
        with pytest.raises(FormulationError):
            sb.form_equations(model, dependent_speeds=["q9_dot"])
        with pytest.raises(CompileError, match="no parameter 'M'"):
            sb.compile(sb.form_equations(model), "udot", {"M": 1})
        sb.compile(sb.form_equations(model), "udot")


def test_the_next_process_forms_nothing() -> None:
    program = (
        "import sys, symbody as sb\n"
        "from symbody.equations import form as forming\n"
        "from tests.codegen.test_stored_sequence import chain, refused, values\n"
        "forming.derive = refused\n"
        "print(values(sb.compile(sb.form_equations(chain()), 'udot')))\n"
    )
    command = [sys.executable, "-c", program]
    environment = {**os.environ, "PYTHONHASHSEED": "17"}
    failed = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert "were formed" in failed.stderr
    expected = values(sb.compile(sb.form_equations(chain()), "udot"))
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.stdout.strip() == str(expected), done.stderr


def test_kernels_and_loops_are_read_too(monkeypatch: pytest.MonkeyPatch) -> None:
    folder = Path(__file__).parents[2] / "examples" / "slider_crank" / "slider_crank.toml"
    monkeypatch.setattr(stored_sequence, "SMALLEST", 1)

    def made() -> Sequence:
        return form_sequence(sb.form_equations(sb.load_model(folder)), ["udot", "lambda"])[0]

    first = made()
    assert first.kernels
    monkeypatch.setattr(forming, "derive", refused)
    assert made() == first
