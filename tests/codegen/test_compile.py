"""`compile` and `generate_code`: the calling convention, values and free parameters, messages, pickling."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import symbody as sb


@pytest.fixture(scope="module")
def eqs() -> sb.EquationSet:
    """A pendulum on a cart; L follows from l by a formula."""
    bob = sb.Body("Bob", mass="m", frames={"hinge": sb.Frame(at=(0, "L", 0))})
    return sb.form_equations(
        sb.Model(
            "cart",
            [
                sb.Prismatic(
                    "rail", "ground", sb.Body("Cart", mass="M"), coordinate="x", force=sb.Drive(applied="F")
                ),
                sb.Revolute("hinge", "Cart", bob["hinge"], coordinate="theta"),
            ],
            gravity=(0, "-g", 0),
            parameters={"M": 2, "m": 0.5, "L": "2*l", "l": 0.4, "g": 9.81},
            inputs=["F"],
        )
    )


def reference(q: np.ndarray, u: np.ndarray, force: float, *, length: float = 0.8) -> np.ndarray:
    """Textbook cart and pendulum (Kane & Levinson 1985, problem set 6), angles from hanging down."""
    M, m, g = 2.0, 0.5, 9.81
    s, c = np.sin(q[1]), np.cos(q[1])
    mass = np.array([[M + m, m * length * c], [m * length * c, m * length**2]])
    right = np.array([force + m * length * s * u[1] ** 2, -m * g * length * s])
    return np.linalg.solve(mass, right)


Q, U = np.array([0.3, 0.7]), np.array([-0.2, 1.1])


def test_values_of_the_model_are_defaults_and_formulas_follow(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot")
    # A 2x2 system of condition 10 in a few operations.
    assert f(0.0, Q, U, [1.5]) == pytest.approx(reference(Q, U, 1.5), rel=1e-14)
    assert f.inputs == ("t", "x", "theta", "x_dot", "theta_dot", "F")
    longer = sb.compile(eqs, "udot", parameters={"l": 0.75})
    assert longer(0.0, Q, U, [1.5]) == pytest.approx(reference(Q, U, 1.5, length=1.5), rel=1e-14)
    direct = sb.compile(eqs, "udot", parameters={"L": 1.5})
    assert direct(0.0, Q, U, [1.5]) == pytest.approx(reference(Q, U, 1.5, length=1.5), rel=1e-14)


def test_free_parameters_are_arguments_in_their_order(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot", free=["l", "M"])
    p = [0.75, 2.0]
    expected = reference(Q, U, 1.5, length=1.5)
    assert f(0.0, Q, U, [1.5], p) == pytest.approx(expected, rel=1e-13)
    assert f.bind(p)(0.0, Q, U, [1.5]) == pytest.approx(expected, rel=1e-13)
    many = f(0.0, Q, U, [1.5], np.array([[0.75, 2.0], [0.4, 2.0]]))
    assert many[1] == pytest.approx(reference(Q, U, 1.5), rel=1e-13)
    # What depends on parameters alone is not part of the function that is called again and again.
    assert f.operations < f.sequence.operation_count


def test_batches_broadcast_and_strides_do_not_matter(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot")
    rng = np.random.default_rng(1)
    q, u, r = rng.normal(size=(4, 3, 2)), rng.normal(size=(3, 2)), rng.normal(size=(4, 1, 1))
    found = f(0.0, q, u, r)
    assert found.shape == (4, 3, 2)
    for i in range(4):
        for j in range(3):
            assert (found[i, j] == f(0.0, q[i, j], u[j], r[i, 0])).all()
    wide = rng.normal(size=(5, 8))
    assert (
        f(0.0, wide[:, ::4], wide[:, 1::4], [0.0]) == f(0.0, wide[:, ::4].copy(), wide[:, 1::4].copy(), [0.0])
    ).all()
    assert f(0.0, np.asfortranarray(q), u, r) == pytest.approx(found, abs=0)
    assert f(np.zeros((4, 3)), q, u, r) == pytest.approx(found, abs=0)
    assert f(0.0, np.zeros((0, 2)), U, [0.0]).shape == (0, 2)


def test_integers_and_single_precision_are_cast(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot")
    assert (f(0, [1, 0], [0, 1], [2]) == f(0.0, [1.0, 0.0], [0.0, 1.0], [2.0])).all()
    assert f(0.0, Q.astype(np.float32), U, [0.0]).dtype == np.float64


def test_states_are_speeds_then_coordinates(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "xdot")
    x = np.concatenate([U, Q])
    assert (f.of_state(0.0, x, [1.5]) == f(0.0, Q, U, [1.5])).all()
    assert (f.of_state(0.0, x, [1.5])[2:] == U).all()
    assert eqs.state_names == ("x_dot", "theta_dot", "x", "theta")


def test_several_outputs_are_a_named_tuple_with_natural_shapes(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, ["mass_matrix", "forcing", "kinetic_energy", "2*x + theta"])
    result = f(0.0, Q, U, [0.0])
    assert result.mass_matrix.shape == (2, 2) and result.forcing.shape == (2,)
    assert result.kinetic_energy.shape == ()
    assert result[3] == pytest.approx(2 * Q[0] + Q[1], rel=1e-15)
    kinetic = 0.5 * U @ result.mass_matrix @ U
    assert result.kinetic_energy == pytest.approx(kinetic, rel=1e-14)


def test_an_output_alone_or_with_others_has_the_same_bits(eqs: sb.EquationSet) -> None:
    alone = sb.compile(eqs, "udot")
    together = sb.compile(eqs, ["kinetic_energy", "mass_matrix", "udot", "power"])
    rng = np.random.default_rng(3)
    q, u = rng.normal(size=(2, 50, 2))
    assert (alone(0.0, q, u, [0.4]) == together(0.0, q, u, [0.4]).udot).all()


def test_out_receives_the_result(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot")
    out = np.empty(2)
    assert f(0.0, Q, U, [1.5], out=out) is out
    assert (out == f(0.0, Q, U, [1.5])).all()


def test_results_of_earlier_calls_are_not_overwritten(eqs: sb.EquationSet) -> None:
    f = sb.compile(eqs, "udot")
    first = f(0.0, Q, U, [1.5])
    kept = first.copy()
    f(0.0, 2 * Q, U, [0.0])
    assert (first == kept).all()


def test_threads_may_call_at_once_and_functions_pickle(eqs: sb.EquationSet) -> None:
    f = pickle.loads(pickle.dumps(sb.compile(eqs, "udot")))
    points = np.random.default_rng(2).normal(size=(200, 4))
    expected = [f(0.0, x[:2], x[2:], [0.1]) for x in points]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda x: f(0.0, x[:2], x[2:], [0.1]), points))
    assert (np.array(found) == np.array(expected)).all()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (([0.1], U, [0.0]), "the order is (x, theta)"),
        ((Q, [0.1, 0.2, 0.3], [0.0]), "the order is (x_dot, theta_dot)"),
        ((Q, U, []), "the order is (F)"),
        ((Q, U, [0.0], [1.0]), "the order is (none)"),
        ((np.zeros((2, 2)), np.zeros((3, 2)), [0.0]), "broadcast"),
        ((Q + 1j, U, [0.0]), "complex"),
        ((np.array([None, 1.0]), U, [0.0]), "object"),
    ],
)
def test_wrong_arguments_are_named(eqs: sb.EquationSet, arguments: tuple[object, ...], word: str) -> None:
    f = sb.compile(eqs, "udot")
    with pytest.raises(sb.CompileError) as caught:
        f(0.0, *arguments)
    assert word in str(caught.value)


def test_missing_and_unknown_parameters_are_all_named_at_once() -> None:
    mass = sb.Body("Mass", mass="m")
    slider = sb.Prismatic("s", "ground", mass, coordinate="x", force=sb.Drive(stiffness="k", damping="d"))
    eqs = sb.form_equations(sb.Model("open", [slider], parameters={"m": 1, "k": None, "d": None}))
    with pytest.raises(sb.CompileError) as caught:
        sb.compile(eqs, "udot")
    assert "k, d" in str(caught.value)
    with pytest.raises(sb.CompileError) as caught:
        sb.compile(eqs, "udot", parameters={"kk": 1, "q": 2})
    assert len(caught.value.problems) == 2 and "'k'" in caught.value.problems[0].fix
    assert sb.compile(eqs, "udot", free=["k", "d"])(0.0, [1.0], [0.0], (), [4.0, 0.0])[0] == -4.0


def test_unknown_outputs_name_the_nearest(eqs: sb.EquationSet) -> None:
    with pytest.raises(sb.FormulationError, match="mass_matrix"):
        sb.compile(eqs, "mas_matrix")
    with pytest.raises(sb.FormulationError, match="'effort rail'|rail"):
        sb.compile(eqs, "effort rial")


def test_parentheses_reach_a_symbol_with_a_reserved_name() -> None:
    slider = sb.Prismatic("s", "ground", sb.Body("B", mass=1), coordinate="power")
    eqs = sb.form_equations(sb.Model("shadow", [slider]))
    f = sb.compile(eqs, ["power", "(power)"])
    assert f(0.0, [7.0], [1.0]) == (0.0, 7.0)


def test_generated_c_has_every_name_and_is_deterministic(eqs: sb.EquationSet) -> None:
    text = sb.generate_code(eqs, ["xdot"], language="c")
    assert text == sb.generate_code(eqs, ["xdot"], language="c")
    for name in ("theta_dot", "M", "g", "F"):
        assert name in text
    numbers = sb.generate_code(eqs, ["xdot"], parameters={})
    assert len(numbers) < len(text) * 2 and "9.81" not in text
    with pytest.raises(sb.CompileError, match="cobol"):
        sb.generate_code(eqs, ["xdot"], language="cobol")


def test_a_name_of_a_model_without_inputs_is_answered_by_how_to_declare_it() -> None:
    body = sb.Body("B", 1)
    eqs = sb.form_equations(sb.Model("m", [sb.Prismatic("j", "ground", body, axis="x", coordinate="x")]))
    for words in ({"inputs": {"T": 1}}, {"parameters": {"T": 1}}):
        with pytest.raises(sb.CompileError) as caught:
            sb.simulate(eqs, 1.0, **words)  # type: ignore[arg-type]
        assert "declare" in caught.value.problems[0].fix and "T" in caught.value.problems[0].fix
