"""The fault checklist, F: formulation and symbols. One test a row; the number is the row's."""

from __future__ import annotations

import gc
import itertools
import math
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from symbody.analysis.linear.linearize import linearize
from symbody.codegen.compile import compile
from symbody.equations.form import form_equations
from symbody.equations.formulations.virtual_work import VirtualWork
from symbody.errors import TimeLimitError, UsageError
from symbody.expr import deadline
from symbody.expr.calculus import derivative
from symbody.expr.graph import Graph, Symbol
from symbody.expr.language.formula import Formula, build
from symbody.expr.opcodes import COS, FLOAT, SIN
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, build_sequence
from symbody.expr.sympy.sympy_bridge import from_sympy
from symbody.formats import load_model
from symbody.model import Body, Drive, Frame, Free, Model, Prismatic, Revolute, Spherical, SpringDamper
from symbody.simulation.methods.implicit.gear_gupta_leimkuhler import GGL
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.simulate import simulate
from tests.effort import limited
from tests.faults.refusals import refused
from tests.simulation.loops import EXAMPLES, example

EPS = float(np.finfo(float).eps)


def chain(count: int) -> Model:
    """Pendulums about skew axes, hung one on the other."""
    frames = {"top": Frame(at=(0, 0, "l")), "end": Frame(at=("l", 0, "-l"))}
    bodies = [Body(f"B{k}", mass=f"m{k}", inertia=("I", "2*I", "2*I"), frames=frames) for k in range(count)]
    joints = [
        Revolute(
            f"J{k}", f"B{k - 1}.end" if k else "ground", f"B{k}.top", axis="xyz"[k % 3], coordinate=f"q{k}"
        )
        for k in range(count)
    ]
    masses = {f"m{k}": 1 for k in range(count)}
    return Model("chain", [*bodies, *joints], ("0", "0", "-g"), {"l": 1, "I": 0.1, "g": 9.81} | masses)


def block(law: str, **parameters: object) -> Model:
    """A unit mass on a line with a law."""
    slide = Prismatic("P", "ground", Body("A", mass=1), axis="x", coordinate="x", force=Drive(applied=law))
    return Model("block", [slide], parameters=parameters)


def test_row_61_closed_forms_over_the_limit_come_in_definitions() -> None:
    eqs = form_equations(chain(7))
    with limited(6):  # seconds; written out, the entries have millions of operations
        matrix, definitions = eqs.mass_matrix, eqs.definitions
    assert definitions and matrix.shape == (7, 7)
    known: set[sp.Symbol] = set()
    named = {name for name, _ in definitions}
    for name, value in definitions:  # each in what is defined before
        assert value.free_symbols & named <= known
        known.add(name)
    assert matrix.free_symbols & named <= known


def test_row_62_an_interrupt_leaves_nothing_half_made() -> None:
    script = (
        "import _thread, signal, threading, sys\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a process in the background ignores it
        "from tests.faults.test_formulation_rows import chain\n"
        "from symbody.equations.form import form_equations\n"
        "from symbody.codegen.compile import compile\n"
        "threading.Timer(0.3, _thread.interrupt_main).start()\n"
        "try:\n"
        "    for _ in range(400):\n"
        "        form_equations(chain(12)).mass_matrix\n"
        "except KeyboardInterrupt:\n"
        "    print(compile(form_equations(chain(2)), 'udot')(0.0, [0.1, 0.2], [0.0, 0.0]).shape)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, "(2,)"), done.stderr


def ticking(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every look at the clock of time limits take a second: a limit of n ends at the n-th check."""
    looks = itertools.count()
    clock = SimpleNamespace(perf_counter=lambda: float(next(looks)))
    monkeypatch.setattr(deadline, "time", clock)


def graphs() -> int:
    gc.collect()
    return sum(type(found) is Graph for found in gc.get_objects())  # weak references answer for theirs


def test_row_62_forming_ends_in_time_and_names_the_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    before = graphs()
    ticking(monkeypatch)
    with pytest.raises(TimeLimitError) as caught:
        form_equations(chain(60), VirtualWork(), time_limit=20)  # it looks some 300 times
    error = caught.value
    assert error.stage and [name for name, _ in error.finished][:2] == ["trees", "coordinates"]
    assert all(spent >= 0.0 for _, spent in error.finished)
    (problem,) = error.problems
    assert problem.where == f"stage {error.stage}" and "time_limit = 20 s" in problem.what
    assert "trees (" in problem.why and "allow more time" in problem.fix
    assert error.exit_code == 4 and error.__cause__ is None and error.__context__ is None
    assert graphs() == before  # though the error is kept


def test_row_62_every_stage_can_be_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    model = load_model(EXAMPLES / "slider_crank" / "slider_crank.toml")
    monkeypatch.setenv("SYMBODY_CACHE", "off")  # stored notes would put the forming off
    ticking(monkeypatch)
    stages: dict[str, TimeLimitError] = {}
    for limit in range(1, 100):
        try:
            form_equations(model, time_limit=limit)
        except TimeLimitError as error:
            stages[error.stage] = error
        else:
            break
    formed = [
        "trees",
        "coordinates",
        "kinematics",
        "constraints",
        "loads",
        "mass matrix and forcing",
        "energy",
    ]
    assert list(stages) == formed
    assert stages["trees"].notes == () and "first stage" in stages["trees"].problems[0].why
    # What was chosen stands in what is told.
    assert set(stages["energy"].notes) <= set(form_equations(model).notes)
    assert any("joint B" in note for note in stages["kinematics"].notes)


def test_row_62_equations_serve_on_after_compiling_ran_out_of_time(monkeypatch: pytest.MonkeyPatch) -> None:
    outputs, state = ["udot", "mass_matrix", "reaction J1"], ([0.1, 0.2, 0.3], [0.4, 0.5, 0.6])
    expected = compile(form_equations(chain(3)), outputs)
    eqs = form_equations(chain(3))
    stages = set()
    with monkeypatch.context() as patch:
        patch.setenv("SYMBODY_CACHE", "off")
        ticking(patch)
        for limit in (1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16):
            with pytest.raises(TimeLimitError, match="compiling takes longer") as caught:
                compile(eqs, outputs, time_limit=limit)
            stages.add(caught.value.stage)
    assert {"output udot", "output reaction J1", "computational sequence"} <= stages
    found = compile(eqs, outputs, time_limit=math.inf)
    assert found.operations == expected.operations
    for one, other in zip(found(0.0, *state), expected(0.0, *state), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("limit", [0, -1.0, math.nan, True, "10 s"])
def test_row_62_a_limit_is_a_time(limit: Any) -> None:
    eqs = form_equations(chain(1))
    for attempt in (
        lambda: form_equations(chain(1), time_limit=limit),
        lambda: compile(eqs, "udot", time_limit=limit),
    ):
        assert refused(attempt, UsageError, "give seconds") == [("time.limit", "time_limit")]


def test_row_62_the_limit_of_one_call_does_not_bind_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    ticking(monkeypatch)
    with pytest.raises(TimeLimitError):
        form_equations(chain(2), time_limit=2)
    assert form_equations(chain(2)).coordinate_names == ("q0", "q1")
    deadline.check()
    outer = deadline.in_time(math.inf, "all", "", lambda: form_equations(chain(2), time_limit=1e6))
    assert outer.coordinate_names == ("q0", "q1")
    with pytest.raises(TimeLimitError, match="all takes longer"):  # the earlier end holds
        deadline.in_time(3.0, "all", "give more", lambda: form_equations(chain(2), time_limit=1e6))


def test_row_62_equations_known_from_the_disk_raise_nothing_later(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("SYMBODY_CACHE", str(tmp_path))
    compile(form_equations(chain(6)), "udot")
    ticking(monkeypatch)
    eqs = form_equations(chain(6), time_limit=3)  # nothing is formed
    assert compile(eqs, "udot").operations > 500
    assert len(eqs.coordinate_names) == 6  # formed now: the limit was that of the call above
    limit: Any = "3 s"
    with pytest.raises(UsageError, match="is not a positive time"):
        form_equations(chain(6), time_limit=limit)


def test_row_62_ctrl_c_between_two_lines_leaves_a_graph_whole() -> None:
    class Pressed(list[int]):
        """A list that Ctrl-C comes before."""

        def append(self, value: int) -> None:
            raise KeyboardInterrupt

    for half in ("hashes", "left", "right", "ops"):
        graph = Graph()
        x = graph.symbol(Symbol("x"))
        whole = list(getattr(graph, half))
        setattr(graph, half, Pressed(whole))
        with pytest.raises(KeyboardInterrupt):
            graph.node(SIN, x)
        setattr(graph, half, whole)
        made = graph.node(COS, x)
        assert made == x + 1 and graph.operands(made) == (x,) and graph.ops[made] == COS
        assert len({len(graph.ops), len(graph.hashes), len(graph.left), len(graph.right)}) == 1
        assert graph.hashes[made] == hash_of_a_cosine()


def hash_of_a_cosine() -> int:
    graph = Graph()
    return graph.hashes[graph.node(COS, graph.symbol(Symbol("x")))]


def test_row_63_singular_angles_are_noted() -> None:
    ball = Spherical(
        "pivot",
        "ground",
        Body("Top", inertia=(1, 1, 2)),
        angles="313",
        coordinates=["a", "b", "c"],
        speeds="end",
    )
    notes = form_equations(Model("top", [ball])).notes
    assert any("joint pivot" in note and "sin(b) = 0" in note for note in notes)


def values_at(graph: Graph, roots: list[int], x: int, place: float) -> list[float]:
    """Values of roots with a number in place of x."""
    found = substitute(graph, roots, {x: graph.constant(place)})
    sequence = build_sequence(graph, [Roots("f", (len(found),), tuple(found))], {})
    return [float(value) for value in evaluate_sequence(sequence, {})[0]]


# Text, derivative by x in closed form, and places, of which some are at or beside the kink.
KINKED = [
    ("abs(x)", lambda x: math.copysign(1, x), (-2.0, 3.0)),
    ("sign(x)*x**2", lambda x: 2 * abs(x), (-2.0, 3.0)),
    ("min(x, 1)", lambda x: 1.0 if x < 1 else 0.0, (0.5, 2.0)),
    ("max(x, 1)", lambda x: 0.0 if x < 1 else 1.0, (0.5, 2.0)),
    ("if(x < 0, 0, 1)", lambda x: 0.0, (-1.0, 0.0, 1.0)),
    ("if(x < 1, x**2, 2*x - 1)", lambda x: 2 * x if x < 1 else 2.0, (0.5, 1.0, 4.0)),
    ("atan2(x, 2)", lambda x: 2 / (x**2 + 4), (-1.0, 0.0, 5.0)),
    ("atan2(x, -2)", lambda x: -2 / (x**2 + 4), (-1.0, 5.0)),
    ("floor(x)*x", lambda x: math.floor(x), (0.5, -0.5)),
    ("mod(x, 2)", lambda x: 1.0, (0.5, 3.0, -0.5)),
    ("smoothstep(x, 0, 2)", lambda x: 1.5 * x * (2 - x) / 2 if 0 < x < 2 else 0.0, (-1.0, 0.5, 3.0)),
    ("interp1(x, 0, 0, 1, 2, 3, 3)", lambda x: 0.0 if not 0 <= x < 3 else 2.0 if x < 1 else 0.5, (-1.0, 0.5, 2.0, 4.0)),
    ("if(x > 0, sqrt(abs(x)), 0)", lambda x: 0.5 / math.sqrt(x) if x > 0 else 0.0, (4.0, -4.0)),
]  # fmt: skip


@pytest.mark.parametrize(("text", "slope", "places"), KINKED, ids=[text for text, *_ in KINKED])
def test_row_64_functions_with_kinks_have_derivatives(
    text: str, slope: object, places: tuple[float, ...]
) -> None:
    assert callable(slope)
    graph = Graph()
    x = graph.symbol(Symbol("x"))
    root = build(Formula.from_value(text), graph, lambda name, _: x)
    rate = derivative(graph, [root], x)
    for place in places:
        (found,) = values_at(graph, rate, x, place)
        assert found == pytest.approx(slope(place), abs=8 * EPS)


def test_row_64_objects_of_sympy_with_kinks() -> None:
    x = sp.Symbol("x")
    pieces = [sp.Abs(x), sp.sign(x), sp.Max(x, 1), sp.Min(x, 1), sp.Heaviside(x, 1), sp.atan2(x, 2),
              sp.Piecewise((x**2, x < 1), (2 * x - 1, True))]  # fmt: skip
    for piece in pieces:
        graph = Graph()
        value = from_sympy(piece, graph, lambda name, _: Symbol(name))
        node = graph.symbol(Symbol("x"))
        for place in (-1.5, 0.5, 2.5):
            (found,) = values_at(graph, [value], node, place)
            assert found == pytest.approx(float(piece.subs(x, place)), abs=4 * EPS)


def test_row_64_forces_with_kinks_move_a_stiff_solver_too() -> None:
    # abs and min stand in the Jacobian that the stiff solver takes from the graph.
    eqs = form_equations(block("-2*x - x_dot*abs(x_dot) + min(x, 0.5) - max(0, x - 1)"))
    ends = [simulate(eqs, 2.0, initial={"x": 1.3}, integrator=way)["x"][-1] for way in (None, Stiff())]
    assert ends[0] == pytest.approx(ends[1], abs=1e-5)


def test_row_65_functions_of_the_user() -> None:
    """Formulas take none; laws of inputs do, and implicit methods take their derivatives by differences."""
    words = "'f' is not a function of the language"
    assert refused(lambda: block("f(x)"), words=words)[0][0] == "expression.unknown_function"
    slide = Prismatic("P", "ground", Body("A", mass=1), axis="x", coordinate="x", force=Drive(applied="F"))
    eqs = form_equations(Model("block", [slide], inputs=["F"]))
    formula = "-1e4*(x - cos(t)) - 1e4*x_dot"  # time constants of 1 s and 0.1 ms

    def law(t: float, q: np.ndarray, u: np.ndarray) -> float:
        return float(-1e4 * (q[0] - np.cos(t)) - 1e4 * u[0])

    for way in ({"integrator": Stiff()}, {}):
        asked, known = (simulate(eqs, 2.0, inputs={"F": each}, **way) for each in (law, formula))
        assert any("derivatives by differences" in note for note in asked.notes)
        # Slopes good to 1e-8 cost no steps: without them it took a hundred times as many.
        assert asked.statistics.accepted <= known.statistics.accepted + 20
        assert asked["x"][-1] == pytest.approx(known["x"][-1], abs=1e-6)
    found = refused(lambda: linearize(eqs, inputs={"F": law}))
    assert found == [("expression.type", "input F")]


@pytest.mark.parametrize("way", [{"integrator": Stiff()}, {"constraints": GGL()}], ids=["stiff", "GGL"])
def test_row_65_a_function_that_brakes_a_loop(way: dict[str, object]) -> None:
    eqs = example("slider_crank")
    place = eqs.speed_names.index("s_dot")
    laws = (lambda t, q, u: -2000.0 * float(u[place]), "-2000*s_dot")
    asked, known = (simulate(eqs, 0.5, inputs={"F": law}, times=[0.0, 0.25, 0.5], **way) for law in laws)
    assert asked.success and asked.statistics.accepted < 1.2 * known.statistics.accepted
    assert np.abs(asked.q - known.q).max() < 1e-6  # some hundred steps of 1e-8


def test_row_66_nothing_is_divided_by_a_symbol_that_may_be_zero() -> None:
    """Every parameter of an arm but what resists it may vanish, and the values stay finite."""
    frames = {"end": Frame(at=("l", 0, 0))}
    parts = [
        Body("A", mass="m", inertia=("I", "I", "I"), frames=frames),
        Body("B", mass="M", inertia=("I", "I", "I"), frames=frames),
        Revolute("R", "ground", "A", coordinate="a", torque=Drive(stiffness="k", damping="d")),
        Revolute("S", "A.end", "B.end", axis="y", coordinate="b"),
        SpringDamper("pull", "ground", "B", stiffness="k"),
    ]
    names = ["l", "m", "M", "k", "d", "g"]
    model = Model("arm", parts, (0, 0, "-g"), {"I": 1} | dict.fromkeys(names, 1))
    eqs = form_equations(model)
    for zeros in (*[[name] for name in names], names):
        f = compile(eqs, ["udot", "energy", "power"], dict.fromkeys(zeros, 0))
        assert all(np.isfinite(value).all() for value in f(0.0, [0.3, 0.2], [0.1, 0.4]))


def test_row_67_no_derivative_of_an_unknown_function_is_left() -> None:
    bodies = Free("J", "ground", Body("A", mass=1, inertia=(1, 2, 3)), angles="313")
    eqs = form_equations(Model("top", [bodies], (0, 0, -9.81)))
    rates = set(eqs.speeds) | set(eqs.coordinates)
    for matrix in (eqs.mass_matrix, eqs.forcing):
        assert matrix.atoms(sp.Derivative) <= rates
        assert matrix.atoms(sp.core.function.AppliedUndef) <= set(eqs.coordinates) | set(eqs.speeds)


def test_row_68_floats_stay_floats_and_decimals_exact() -> None:
    graph = Graph()
    noisy = build(Formula.from_value(0.1 + 0.2), graph, lambda name, _: 0)
    assert graph.ops[noisy] == FLOAT and graph.number(noisy) == 0.1 + 0.2
    plain = build(Formula.from_value(0.3), graph, lambda name, _: 0)
    assert graph.number(plain) == Fraction(3, 10)
    eqs = form_equations(block("-k*x", k=0.1 + 0.2))
    assert compile(eqs, "udot")(0.0, [1.0], [0.0])[0] == -(0.1 + 0.2)


def test_row_69_no_huge_rationals() -> None:
    graph = Graph()
    value = build(Formula.from_value(math.pi / 3), graph, lambda name, _: 0)
    assert graph.ops[value] == FLOAT
    # Sums of floats stay floats; thousands of terms do not grow digits.
    text = " + ".join(repr(math.sqrt(k)) for k in range(2, 2000))
    total = graph.number(build(Formula.from_value(text), graph, lambda name, _: 0))
    assert isinstance(total, float) and total == pytest.approx(
        sum(math.sqrt(k) for k in range(2, 2000)), rel=1e-12
    )
