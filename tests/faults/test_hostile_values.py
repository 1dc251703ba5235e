"""Names, numbers and formulas that mean nothing, or too much: each is refused, none accepted in silence."""

from __future__ import annotations

import math
import random
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from itertools import product

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.named_values import positions_and_rates
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.expr.rewrite import substitute, substitute_into
from symbody.simulation.sweeps.case_table import case_table
from tests.faults.argument_calls import ROOT, model
from tests.tiers import rows

NOT_STATES = {
    "k": "a parameter", "F": "an input", "t": "the time", "x_ddot": "an acceleration", "energy": "",
    "slider": "", "no such name": "",
}  # fmt: skip


@pytest.fixture(scope="module")
def eqs() -> sb.EquationSet:
    return sb.form_equations(model())


GIVEN: dict[str, Callable[[sb.EquationSet, dict[str, float]], object]] = {
    "assemble fixed": lambda eqs, named: sb.assemble(eqs, named),
    "assemble guess": lambda eqs, named: sb.assemble(eqs, guess=named),
    "assemble ranges": lambda eqs, named: sb.assemble(eqs, ranges={name: (0, 1) for name in named}),
    "simulate initial": lambda eqs, named: sb.simulate(eqs, 0.1, named),
    "simulate guess": lambda eqs, named: sb.simulate(eqs, 0.1, guess=named),
    "sweep initial": lambda eqs, named: sb.sweep(eqs, 0.1, {"d": [1, 2]}, initial=named),
    "sweep initial varied": lambda eqs, named: sb.sweep(
        eqs, 0.1, {}, initial={name: [1, 2] for name in named}
    ),
    "sweep guess": lambda eqs, named: sb.sweep(eqs, 0.1, {"d": [1, 2]}, guess=named),
    "linearize at": lambda eqs, named: sb.linearize(eqs, named),
    "find_equilibrium guess": lambda eqs, named: sb.find_equilibrium(eqs, named),
    "find_equilibrium fixed": lambda eqs, named: sb.find_equilibrium(eqs, fixed=named),
    "redundancy guess": lambda eqs, named: sb.redundancy(eqs, guess=named),
    "event action": lambda eqs, named: sb.simulate(eqs, 0.1, events=sb.Event("t - 0.05", action=named)),
    "inverse_dynamics motion": lambda eqs, named: sb.inverse_dynamics(
        eqs, {name: "t" for name in named}, "F", [0, 0.1]
    ),
}


@pytest.mark.parametrize("place", GIVEN)
@pytest.mark.parametrize("name", NOT_STATES)
def test_names_of_no_state_are_refused(eqs: sb.EquationSet, place: str, name: str) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        GIVEN[place](eqs, {name: 1.0})
    told = str(caught.value)
    assert name in told
    assert caught.value.problems[0].fix
    if place not in ("event action", "inverse_dynamics motion"):
        assert NOT_STATES[name] in told


def test_where_other_names_belong(eqs: sb.EquationSet) -> None:
    for name, cure in (("k", "parameters={'k': ...}"), ("F", "inputs={'F': ...}"), ("t", "t=")):
        with pytest.raises(sb.AssemblyError) as caught:
            sb.assemble(eqs, {name: 1.0})
        assert caught.value.problems[0].code == "assembly.no_state"
        assert cure in caught.value.problems[0].fix
    assert positions_and_rates(eqs) == {"x", "x_dot"}


@pytest.mark.parametrize("value", [1e155, 1e300])
def test_speeds_beyond_all_numbers_end_in_a_status(eqs: sb.EquationSet, value: float) -> None:
    """The square of such a speed is no double: energies and accelerations of loops are infinite."""
    loop = sb.form_equations(sb.load_model(ROOT / "examples" / "slider_crank" / "slider_crank.toml"))
    for equations, name in ((eqs, "x_dot"), (loop, "theta_dot")):
        try:
            run = sb.simulate(equations, 1.0, {name: value}, max_steps=1000)
        except sb.SymbodyError as error:
            assert error.problems[0].code != "simulation.atol"
        else:
            assert not run.success or np.isfinite(run[name]).all()
    motions = sb.sweep(eqs, 0.1, {}, initial={"x_dot": [value, 1.0]}, times=[0.1], threads=1, max_steps=1000)
    assert motions.status[1].success


def crank(rod: str) -> sb.EquationSet:
    """A crank whose pin a rod ties to a piston: by a distance, or by a body of its own."""
    arm = sb.Body("Crank", mass=1, inertia=(0, 0, 0.1),
                  frames={"A": sb.Frame(("-r/2", 0, 0)), "B": sb.Frame(("r/2", 0, 0))})  # fmt: skip
    piston = sb.Body("Piston", mass=1)
    parts: list[object] = [
        arm, piston, sb.Revolute("A", "ground", "Crank.A", coordinate="th"),
        sb.Prismatic("D", "ground", piston, axis="x", coordinate="s"),
    ]  # fmt: skip
    if rod == "distance":
        parts.append(sb.Distance("rod", "Crank.B", piston, "l"))
    else:
        frames = {"B": sb.Frame(("-l/2", 0, 0)), "C": sb.Frame(("l/2", 0, 0))}
        body = sb.Body("Rod", mass=1, inertia=(0, 0, 0.1), frames=frames)
        parts += [body, sb.Revolute("B", "Crank.B", "Rod.B"), sb.Revolute("C", "Rod.C", "Piston")]
    values = {"r": 0.1, "l": 0.3}
    return sb.form_equations(
        sb.Model("crank", parts, parameters=values, initial={"th": 0.5})  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(
    ("r", "rod"),
    rows(product([0.0, 0.1], ["distance", "body"]), fast=[(0.0, "body"), (0.1, "distance")]),
)
def test_rods_without_length_are_told(rod: str, r: float) -> None:
    """A distance of 0 has no direction: d|p| = p.dp/|p| is 0/0, and no least squares have a solution."""
    eqs, values = crank(rod), {"r": r, "l": 0.0}
    asked: list[Callable[[], object]] = [
        lambda: sb.assemble(eqs, parameters=values), lambda: sb.simulate(eqs, 0.01, parameters=values),
        lambda: sb.redundancy(eqs, values), lambda: sb.linearize(eqs, parameters=values),
        lambda: sb.find_equilibrium(eqs, parameters=values),
    ]  # fmt: skip
    for ask in asked:
        try:
            ask()
        except sb.SymbodyError as error:
            assert error.problems[0].where
            if rod == "distance":
                assert error.problems[0].where == "constraint rod, value"


def test_cases_without_length_leave_the_others() -> None:
    motions = sb.sweep(crank("distance"), 0.01, {"l": [0.0, 0.3]}, times=[0.01], threads=1)
    assert [status.success for status in motions.status] == [False, True]
    assert "rod" in motions.case_notes[0]


def test_springs_without_length_are_told() -> None:
    """A damper along a line has no direction at length 0; a plain spring of free length 0 has no need of one."""
    mass = sb.Body("M", mass=1)
    hold = sb.Cartesian("j", "ground", mass, coordinates=["x", "y", "z"])
    for damping, success in ((0, True), (1, False)):
        spring = sb.SpringDamper("s", "ground", mass, stiffness=10, damping=damping)
        run = sb.simulate(sb.form_equations(sb.Model("m", [mass, hold, spring])), 0.1)
        assert run.success is success
        assert success or "spring s has length 0" in run.notes[-1]


def three_cranks(difference: float) -> sb.EquationSet:
    """Three equal parallel cranks under a bar, the last longer by a difference."""
    pins = {f"P{k}": sb.Frame((k - 1, 0, 0)) for k in range(3)}
    bar = sb.Body("Bar", mass=2, inertia=(0, 0, 1), frames=pins)
    cranks = []
    for k, length in enumerate(("r", "r", "r + d")):
        ends = {"a": sb.Frame((0, f"-({length})/2", 0)), "b": sb.Frame((0, f"({length})/2", 0))}
        cranks.append(sb.Body(f"C{k}", mass=1, inertia=(0, 0, 0.1), frames=ends))
    hinges = [
        sb.Revolute(f"A{k}", ("ground", f"P{k}"), (cranks[k], "a"), coordinate=f"a{k}") for k in range(3)
    ]
    hinges += [sb.Revolute(f"B{k}", (cranks[k], "b"), (bar, f"P{k}")) for k in range(3)]
    return sb.form_equations(
        sb.Model("three", [bar, *cranks, *hinges], gravity=(0, -9.81, 0), ground=pins,
                 parameters={"r": 0.5, "d": difference}, initial={f"a{k}": 0.3 for k in range(3)})
    )  # fmt: skip


def test_nearly_redundant_constraints_are_told() -> None:
    """A third crank longer by 1e-9 m: the loops share what does not close, and no motion keeps them as they are.

    Of the six conditions on the ends of three cranks that stay parallel one follows from the others. The least
    squares of the gap leave a part of 1e-9 m over the mechanism's 1 m that no motion closes.
    """
    run = sb.simulate(three_cranks(1e-9), 0.1)
    (note,) = (note for note in run.notes if "B1, B2 are nearly redundant" in note)
    share = float(note.partition(" a gap of ")[2].split()[0])
    assert 1e-11 < share < 1e-9
    equal = sb.simulate(three_cranks(0.0), 0.1)
    assert equal.success and not any("nearly redundant" in note for note in equal.notes)
    # A hundred times that is a rigid structure; its loops close in the flat pose alone, far from the start.
    far = sb.simulate(three_cranks(1e-7), 0.1)
    assert any("a0 = " in note and "instead of 17.1887 deg" in note for note in far.notes)


@pytest.mark.parametrize("speeds", ["start", "end", "twist"])
def test_speeds_of_cut_joints_are_given_and_measured(speeds: str) -> None:
    """Two hinges to the ground carry a body that a free joint describes too; this one is cut.

    The first hinge turns by th, its pin is 0.3 up the link; the second by ka about the pin, and the body's
    centre is 0.5 before it. In the plane: w_z = th' + ka', and the centre c = 0.3 (-sin th, cos th)
    - 0.5 (cos(th + ka), sin(th + ka)) moves with c', by components along the axes of the start, or of the end.
    """
    body = sb.Body("P", mass=1, inertia=(1, 2, 3), frames={"Q": sb.Frame((0.5, 0, 0))})
    link = sb.Body("W", mass=1, inertia=(1, 1, 1), frames={"Q": sb.Frame((0, 0.3, 0))})
    named = ["vx", "vy", "vz", "wx", "wy", "wz"]
    free = sb.Free("f", "ground", body, speeds=speeds, speed_names=named)
    hinges = [sb.Revolute("h", "ground", link, coordinate="th"),
              sb.Revolute("k", (link, "Q"), (body, "Q"), coordinate="ka")]  # fmt: skip
    trees = sb.Trees(["h", "k"], ["h", "k"])
    eqs = sb.form_equations(sb.Model("m", [body, link, free, *hinges]), tree=trees)
    assert "wz" not in eqs.speed_names
    th, ka, th_dot, ka_dot = 0.3, 0.4, 0.7, 0.2
    state = sb.assemble(eqs, {"th": th, "ka": ka, "th_dot": th_dot, "ka_dot": ka_dot})
    turned, w = th + ka, th_dot + ka_dot
    v = 0.3 * th_dot * np.array([-math.cos(th), -math.sin(th)])
    v -= 0.5 * w * np.array([-math.sin(turned), math.cos(turned)])
    if speeds == "twist":
        c, s = math.cos(turned), math.sin(turned)
        v = np.array([[c, s], [-s, c]]) @ v
    np.testing.assert_allclose([state[n] for n in named], [*v, 0, 0, 0, w], rtol=0, atol=1e-14)
    again = sb.assemble(eqs, {"th": th, "ka": ka, "wz": w, "vx": v[0]})
    np.testing.assert_allclose([again.u["th_dot"], again.u["ka_dot"]], [th_dot, ka_dot], rtol=1e-9)
    run = sb.simulate(eqs, 0.05, {"th": th, "ka": ka, "wz": w, "vx": v[0]}, times=[0, 0.025, 0.05])
    # Without forces w_z' is the sum of both accelerations.
    np.testing.assert_allclose(run["wz_dot"], run["th_ddot"] + run["ka_ddot"], rtol=1e-9, atol=1e-12)


EXPLOSIVE = [
    "(((((1+1/10**64)**64)**64)**64)**64)", "x*(((((1+1/10**64)**64)**64)**64)**64) + 1",
    "sin(((((1+1/10**64)**64)**64)**64)*x)", "1/((((1+1/10**64)**64)**64)**64)", "(((2/3)**64)**64)**64 + x",
    "floor((((1+1/10**64)**64)**64)**64)", "max((((1+1/10**64)**64)**64)**64, x)",
    "if(x > (((1+1/10**64)**64)**64)**64, 1, 2)", "sqrt((((1+1/10**64)**64)**64)**64)",
    "atan2((((1+1/10**64)**64)**64)**64, 1)", "(1 + (((1+1/10**64)**64)**64)**64)**64",
    "2**(2**(2**(2**2)))", "10**1000000000", "10**64**64", "1e400", "(1e300*x)**64*1e300",
]  # fmt: skip


@pytest.mark.parametrize("formula", EXPLOSIVE)
def test_powers_of_numbers_stay_short(formula: str) -> None:
    """Exact, the first has 64^4 times the digits of 1 + 1e-64, which is a billion; as a double it is 1."""
    body = sb.Body("M", mass=1)
    try:
        slider = sb.Prismatic("s", "ground", body, axis="x", coordinate="x", force=sb.Drive(applied=formula))
        eqs = sb.form_equations(sb.Model("powers", [body, slider]))
    except sb.SymbodyError:
        return
    (equation,) = eqs.dynamic_equations()
    assert len(str(equation)) < 10_000
    assert len(sb.generate_code(eqs, "udot")) < 100_000
    sb.compile(eqs, "udot", quick=True)(0.0, [0.5], [0.0])


def choice(source: random.Random, depth: int) -> tuple[str, Callable[[Fraction], Fraction]]:
    """A formula of k with choices and divisions, and what it is: only what is chosen is computed."""
    kind = source.choice(["number", "k", "sum", "product", "division", "choice", "choice"]) if depth else "k"
    number = Fraction(source.randint(-2, 3))
    if kind == "number":
        return f"({number})", lambda k: number
    if kind == "k":
        return f"(k - ({number}))", lambda k: k - number
    (a, f), (b, g) = choice(source, depth - 1), choice(source, depth - 1)
    if kind == "sum":
        return f"({a} + {b})", lambda k: f(k) + g(k)
    if kind == "product":
        return f"({a}*{b})", lambda k: f(k) * g(k)
    if kind == "division":
        return f"({a}/(k - ({number})))", lambda k: f(k) / (k - number)
    sign = source.choice(["<", ">", "<=", ">=", "==", "!="])
    holds: dict[str, Callable[[Fraction], bool]] = {
        "<": lambda k: k < number, ">": lambda k: k > number, "<=": lambda k: k <= number,
        ">=": lambda k: k >= number, "==": lambda k: k == number, "!=": lambda k: k != number,
    }  # fmt: skip
    return f"if(k {sign} {number}, {a}, {b})", lambda k: f(k) if holds[sign](k) else g(k)


def compared_choices(seed: int, count: int) -> int:
    """Compare formulas at whole k with what they are; return how many have no value."""
    source, undefined = random.Random(seed), 0
    for _ in range(count):
        text, exact = choice(source, 4)
        value = Fraction(source.randint(-2, 3))
        graph = Graph()
        k = graph.symbol(Symbol("k", SymbolKind.PARAMETER))
        node = build(Formula.from_value(text), graph, lambda name, column, k=k: k)
        other = Graph()
        known = graph.constant(int(value))
        try:
            expected = exact(value)
        except ZeroDivisionError:
            undefined += 1
            continue
        (here,) = substitute(graph, [node], {k: known})
        (there,) = substitute_into(other, graph, [node], {k: known})
        assert Fraction(graph.number(here)) == expected, (text, value)
        assert Fraction(other.number(there)) == expected, (text, value)
    return undefined


def test_choices_compute_what_they_choose() -> None:
    assert compared_choices(0, 300) > 10


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(1, 11))
def test_many_choices_compute_what_they_choose(seed: int) -> None:
    compared_choices(seed, 500)


def test_a_guarded_division_is_compiled_and_an_unguarded_one_named() -> None:
    body = sb.Body("M", mass=1)

    def spring(formula: str) -> sb.EquationSet:
        drive = sb.Drive(applied=formula)
        slider = sb.Prismatic("s", "ground", body, axis="x", coordinate="x", force=drive)
        return sb.form_equations(sb.Model("m", [body, slider], parameters={"k": 1.0}))

    eqs = spring("if(k > 1, 1/(k - 1), 0)")
    for k, expected in ((1.0, 0.0), (2.0, 1.0), (0.0, 0.0)):
        assert float(sb.compile(eqs, "udot", {"k": k})(0.0, [0.0], [0.0])[0]) == expected
    with pytest.raises(sb.SymbodyError, match=r"joint s, force.applied"):
        sb.compile(spring("if(x > 0, 1/(k - 1), 0)"), "udot")


def test_sweeps_too_large_are_refused_by_counts(eqs: sb.EquationSet) -> None:
    """Nothing is made of the cases before: the last has more of them than any memory has places."""
    many = np.linspace(1.0, 2.0, 100_000)
    for given in (
        {"parameters": {"k": many, "d": many}},
        {"parameters": {"k": many, "d": many}, "initial": {"x": many, "x_dot": many}, "times": [0.1]},
        {"parameters": {"k": sb.Samples("uniform", 1, 2)}, "samples": 10**400},
    ):
        with pytest.raises(sb.SimulationError) as caught:
            sb.sweep(eqs, 0.1, **given)  # type: ignore[arg-type]
        problem = caught.value.problems[0]
        assert problem.code == "sweep.memory"
        assert "GB" in problem.what
        assert "times=[t_end]" in problem.fix


def test_tables_of_cases_are_every_combination() -> None:
    table = case_table(
        {"a": [1.0, 2.0], "b": sb.Samples("uniform", 0, 1)}, {"x": [3.0, 4.0, 5.0]}, "product", 2
    )
    drawn = sb.Samples("uniform", 0, 1).draw("b", 2, 0)
    expected = [(a, b, x) for a in (1.0, 2.0) for x in (3.0, 4.0, 5.0) for b in drawn]
    np.testing.assert_array_equal(np.hstack([table.parameters, table.initial]), expected)


def test_chains_of_parameters(eqs: sb.EquationSet) -> None:
    """p_k = p_(k-1) + 1 is k + p_0: each is put in once, however many there are."""
    chain: dict[str, object] = {"p0": 1.0} | {f"p{k}": f"p{k - 1} + 1" for k in range(1, 2000)}
    body = sb.Body("M", mass="p1999")
    slider = sb.Prismatic("s", "ground", body, axis="x", coordinate="x", force=sb.Drive(applied=1))
    long = sb.form_equations(sb.Model("m", [body, slider], parameters=chain))  # type: ignore[arg-type]
    assert float(sb.compile(long, "udot", {"p0": 1.0}, quick=True)(0.0, [0.0], [0.0])[0]) == 1 / 2000


SCRIPT = """
import symbody as sb
body = sb.Body("Mass", mass="m")
spring = sb.Drive(applied="F", stiffness="k", damping="d")
slider = sb.Prismatic("slider", "ground", body, axis="x", coordinate="x", force=spring)
model = sb.Model("p", [body, slider], inputs=["F"], parameters={"m": 1.0, "d": 0.5, "k": 1.0})
eqs = sb.form_equations(model)
print(eqs.dynamic_equations())
assert False, "assertions are off"
for language in ("c", "python", "fortran", "matlab", "julia", "rust", "javascript", "jax", "casadi"):
    sb.generate_code(eqs, "udot", language)
print(sb.linearize(eqs).verdict, sb.find_equilibrium(eqs).verdict)
from symbody.cli.entry import run
print(run(["simulate", "--help"]))
"""
MOTION = """
print(sb.simulate(eqs, 0.1, {"x": 1}).status.name)
"""


def optimized(script: str) -> list[str]:
    """What a script prints in a process without docstrings and assertions."""
    run = subprocess.run([sys.executable, "-OO", "-c", script], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


@pytest.mark.exhaustive
def test_python_without_docstrings_and_assertions() -> None:
    printed = optimized(SCRIPT)
    assert "Derivative(x(t), (t, 2))" in printed[0]
    assert printed[1] == "stable stable"
    assert printed[-1] == "0"


@pytest.mark.exhaustive  # the loops are compiled anew
def test_motions_without_docstrings_and_assertions() -> None:
    assert optimized(SCRIPT + MOTION)[-1] == "SUCCESS"
