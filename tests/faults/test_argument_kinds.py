"""Whatever is given to a public function, it ends in a result or in a fault of this package."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.arguments import checked_arguments
from tests.faults.argument_calls import CONSTRUCTORS, NOT_CALLED, Call, calls, strange_values

KINDS = len(list(strange_values()))
FUNCTIONS = (
    "load_model save_model load_urdf save_urdf form_equations reduce_index separate_derivatives compile "
    "generate_code assemble redundancy solve_positions find_equilibrium linearize singular_configurations "
    "trace_positions velocity_ratios solve_index_1 simulate sweep Stepper LaneStepper "
    "generate_simulation inverse_dynamics plot save_plot animate save_animation save_fmu save_report without_sampling"
).split()
# Each takes a second or more where the strange value fits.
SLOW = {"singular_configurations", "solve_positions", "velocity_ratios", "trace_positions"}


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Some of the strange texts are names of files that can be written."""
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Call]:
    return calls(tmp_path_factory.mktemp("arguments"))


def raw_fault(call: Call, argument: str, value: object) -> str:
    """What leaves a call with one argument exchanged, if it is neither a result nor a fault of ours."""
    try:
        call.function(**{**call.arguments, argument: value})
    except sb.SymbodyError as error:
        told = [isinstance(p, sb.Problem) and bool(p.code and p.what) for p in error.problems]
        return "" if told and all(told) and str(error) else f"a fault that says nothing: {error!r}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def faults(known: dict[str, Call], names: Iterator[str] | list[str], every: int, first: int = 0) -> list[str]:
    """Raw faults of functions: each argument takes each `every`th strange value, others the next time."""
    found = []
    turn = first
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name in names:
            for argument in known[name].arguments:
                for k, value in enumerate(strange_values()):
                    if (k + turn) % every == 0:
                        fault = raw_fault(known[name], argument, value)
                        found += [f"{name}, {argument}, value {k}: {fault}"] if fault else []
                turn += 1
    return found


def test_every_public_name_is_called(known: dict[str, Call]) -> None:
    public = {name for name in sb.__all__ if not name.startswith("_")}
    errors = {name for name in public if isinstance(getattr(sb, name), type)
              and issubclass(getattr(sb, name), Exception)}  # fmt: skip
    assert public - errors - NOT_CALLED == {*CONSTRUCTORS, *FUNCTIONS}
    assert {*CONSTRUCTORS, *FUNCTIONS} <= set(known)


def test_strange_arguments_are_told(known: dict[str, Call]) -> None:
    assert faults(known, sorted(set(known) - SLOW), every=24) == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("part", range(8))
def test_all_strange_arguments_are_told(known: dict[str, Call], part: int) -> None:
    assert faults(known, sorted(known)[part::8], every=1) == []


def test_the_argument_is_named() -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.Explicit(max_step="long")  # type: ignore[arg-type]
    problem = caught.value.problems[0]
    assert problem.code == "call.argument"
    assert problem.where == "Explicit, argument max_step"
    assert problem.fix == "give a number or None"


def test_faults_with_arguments_that_fit_go_on_as_they_are() -> None:
    @checked_arguments
    def look_up(name: str, table: dict[str, int]) -> int:
        return table[name]

    with pytest.raises(KeyError, match="mine"):
        look_up("mine", {"yours": 1})
    with pytest.raises(sb.UsageError, match="argument table"):
        look_up("mine", [1])  # type: ignore[arg-type]


UNFIT: list[tuple[Callable[[], object], str, str]] = [
    (lambda: sb.simulate(None), "call.missing_argument", "t_end is missing"),  # type: ignore[call-arg, arg-type]
    (lambda: sb.Revolute("A"), "call.missing_argument", "start, end are missing"),  # type: ignore[call-arg]
    (lambda: sb.Body("B", mas=1), "call.unknown_argument", "did you mean 'mass'?"),  # type: ignore[call-arg]
    (lambda: sb.Frame(at=(0, 0, 0), turn=1), "call.unknown_argument", "known names: at, matrix, rotate"),  # type: ignore[call-arg]
    (lambda: sb.Explicit(ordr=8), "call.unknown_argument", "did you mean 'order'?"),  # type: ignore[call-arg]
    (lambda: sb.Model("m", element=[]), "call.unknown_argument", "did you mean 'elements'"),  # type: ignore[call-arg]
    (lambda: sb.form_equations(sb.Model("m"), formulaton=1), "call.unknown_argument", "'formulation'"),  # type: ignore[call-arg]
    (lambda: sb.Frame(1, 2, 3, 4), "call.arguments", "it takes (at, rotate, matrix)"),  # type: ignore[call-arg, arg-type]
]


@pytest.mark.parametrize(("call", "code", "text"), UNFIT)
def test_calls_that_fit_no_signature_are_faults_with_a_cure(
    call: Callable[[], object], code: str, text: str
) -> None:
    with pytest.raises(sb.UsageError, match=re.escape(text)) as caught:
        call()
    assert caught.value.problems[0].code == code
    assert isinstance(caught.value, TypeError)  # as Python's own


def test_names_that_are_misspelt_are_refused_with_those_alike() -> None:
    with pytest.raises(AttributeError, match="did you mean 'Revolute'"):
        sb.Revolut  # type: ignore[attr-defined]  # noqa: B018
    with pytest.raises(AttributeError, match="did you mean 'form_equations'"):
        sb.form_equation  # type: ignore[attr-defined]  # noqa: B018
    assert not hasattr(sb, "nothing_like_it")


def test_a_number_is_no_path(known: dict[str, Call]) -> None:
    # open(1) would write to the terminal, and close it.
    with pytest.raises(sb.UsageError, match="argument path"):
        sb.Trajectory.load(1)  # type: ignore[arg-type]


WRONG_RESULTS = [
    np.empty(2), np.empty((1, 1)), np.empty(1, dtype=np.int64), np.empty(1, dtype=np.float32),
    np.empty(1, dtype=">f8"), np.empty(4)[::4].view()[:0], [0.0], np.frombuffer(bytes(8)),
    np.ones(9, dtype=np.uint8)[1:].view(np.float64),
]  # fmt: skip


@pytest.mark.parametrize("place", range(len(WRONG_RESULTS)))
def test_what_cannot_receive_results_is_refused(known: dict[str, Call], place: int) -> None:
    call = known["f"]
    with pytest.raises(sb.CompileError, match="compile.out"):
        call.function(**{**call.arguments, "out": WRONG_RESULTS[place]})


def test_results_of_batches_go_where_they_are_asked_for(known: dict[str, Call]) -> None:
    call = known["f of a batch"]
    expected = call.function(**call.arguments)
    out = np.full((2, 1), np.nan)
    assert call.function(**{**call.arguments, "out": out}) is out
    np.testing.assert_array_equal(out, expected)
    with pytest.raises(sb.CompileError, match="compile.out"):
        call.function(**{**call.arguments, "out": np.empty((4, 1))[::2]})
    several = known["f of parameters"]
    with pytest.raises(sb.CompileError, match="one array"):
        several.function(**{**several.arguments, "out": out})


def test_arrays_of_any_layout_give_the_same(known: dict[str, Call]) -> None:
    """Strided, reversed, misaligned, byte-swapped and integer arrays are read, not taken for what they are not."""
    call = known["f"]
    expected = call.function(**call.arguments)
    shifted = np.frombuffer(b"\0" + np.array([1.0]).tobytes(), dtype=np.uint8)[1:].view(np.float64)
    for q in (np.ones(9)[::9], np.ones(2)[:0:-1], shifted, np.ones(1, dtype=">f8"), np.ones(1, dtype=int)):
        np.testing.assert_array_equal(call.function(**{**call.arguments, "q": q}), expected)
