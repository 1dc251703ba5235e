"""What is refused, with the cause and the cure; and that a thread's graph does not outlive its objects."""

from __future__ import annotations

import gc
import threading
import weakref
from collections.abc import Callable

import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from symbody.mbsymba.workplace import WORKPLACE

th, s, lam = dynamicsymbols("theta s lambda1")
m, L = sp.symbols("m L")
RF = mb.rotate("Z", th)


def bob(name: str = "") -> mb.BODY:
    return mb.make_BODY(mb.make_POINT(RF, L, 0, 0), m, name=name)


B = bob()
P = mb.origin(RF)
CASES: dict[str, tuple[str, Callable[[], object]]] = {
    "a frame that is a number": ("mbsymba.wrong_kind", lambda: mb.make_POINT(3, 1, 2, 0)),
    "a point that is a vector": ("mbsymba.wrong_kind", lambda: mb.join_points(P, mb.uvec_X(RF))),
    "a vector that is a point": ("mbsymba.wrong_kind", lambda: mb.dot_prod(P, mb.uvec_X(RF))),
    "a body that is a frame": ("mbsymba.wrong_kind", lambda: mb.make_FORCE(RF, 1, 0, 0, P, RF)),
    "an axis": ("mbsymba.axis", lambda: mb.rotate("W", th)),
    "a null axis": ("mbsymba.null_axis", lambda: mb.rotate(mb.make_VECTOR(RF, 0, 0, 0), th)),
    "a matrix": ("mbsymba.not_a_frame_matrix", lambda: mb.origin(sp.eye(3))),
    "a last row": ("mbsymba.not_a_frame_matrix", lambda: mb.origin(sp.Matrix(4, 4, range(16)))),
    "a column": ("mbsymba.not_a_column", lambda: RF * sp.Matrix([1, 2, 0])),
    "too few arguments": ("mbsymba.arguments", lambda: mb.make_FORCE(RF, 1, 0, 0, P)),
    "too many arguments": ("mbsymba.arguments", lambda: mb.make_TORQUE(RF, 1, 0, 0, B, None, 3)),
    "a vector among the objects": ("mbsymba.not_an_object", lambda: mb.newton_equations([B, mb.uvec_X(RF)])),
    "an expression as objects": ("mbsymba.wrong_kind", lambda: mb.newton_equations(th)),
    "multipliers": ("mbsymba.multipliers", lambda: mb.make_CONSTRAINT([th, s], [lam])),
    "a multiplier that is a symbol": ("mbsymba.not_a_function", lambda: mb.make_CONSTRAINT(th, m)),
    "a rate as coordinate": ("mbsymba.not_a_function", lambda: mb.lagrange_equations(B, [th.diff()])),
    "a product as unknown": ("mbsymba.not_a_variable", lambda: mb.GenerateMatrix([th * m], [th * m])),
    "not linear": ("expression.not_linear", lambda: mb.GenerateMatrix([th**2], [th])),
    "not of first order": ("by_hand.not_first_order", lambda: mb.state_space([th.diff().diff()], None, [th])),
    "diff of a point": ("mbsymba.diff", lambda: mb.diff(P, dynamicsymbols._t)),
    "no body": ("by_hand.no_body", lambda: mb.lagrange_equations([mb.make_CONSTRAINT(th, lam)], [th])),
    "a body twice": ("by_hand.body_twice", lambda: mb.lagrange_equations([B, B], [th])),
    "a name twice": ("by_hand.body_name", lambda: mb.equation_set([bob("b"), bob("b")], [th])),
    "a force twice": ("by_hand.load_twice", lambda: mb.lagrange_equations([B, *[mb.make_TORQUE(RF, 0, 0, 1, B)] * 2], [th])),
    "a force on no body of these": ("by_hand.stray_load", lambda: mb.lagrange_equations([B, mb.make_TORQUE(RF, 0, 0, 1, bob())], [th])),
    "a multiplier twice": ("by_hand.multiplier_twice", lambda: mb.lagrange_equations([B, mb.make_CONSTRAINT(th, lam), mb.make_CONSTRAINT(th, lam)], [th])),
    "a coordinate that does not occur": ("by_hand.unknown_coordinate", lambda: mb.lagrange_equations(B, [th, s])),
    "a coordinate twice": ("by_hand.coordinate_twice", lambda: mb.equation_set(B, [th, th])),
    "a coordinate left out": ("by_hand.missing_coordinate", lambda: mb.equation_set(mb.make_BODY(mb.make_POINT(RF, s, 0, 0), m), [th])),
    "a multiplier in a force": ("by_hand.multiplier_in_load", lambda: mb.equation_set([B, mb.make_CONSTRAINT(th, lam), mb.make_TORQUE(RF, 0, 0, lam, B)], [th])),
    "an unknown reaction": ("by_hand.unknown_reaction", lambda: mb.equation_set(B, [th], reactions=[s])),
    "an unknown parameter": ("by_hand.unknown_parameter", lambda: mb.equation_set(B, [th], parameters={"k": 1})),
    "not affine in the rates": ("equations.nonlinear_in_speeds", lambda: mb.equation_set([B, mb.make_CONSTRAINT(th.diff() ** 2 - 1, lam)], [th])),
    "a constraint on nothing": ("by_hand.never_closed", lambda: mb.equation_set([B, mb.make_CONSTRAINT(L - 1, lam)], [th])),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_it_is_refused(case: str) -> None:
    code, act = CASES[case]
    with pytest.raises(sb.SymbodyError) as caught:
        act()
    problem = caught.value.problems[0]
    assert problem.code == code and problem.what and problem.fix


def test_a_constraint_that_always_holds_is_dropped_with_a_note() -> None:
    always = mb.make_CONSTRAINT(sp.sin(th) ** 2 + sp.cos(th) ** 2 - 1, lam)
    eqs = mb.equation_set([B, always], [th])
    assert eqs.multiplier_names == () and any("holds identically" in note for note in eqs.notes)


def test_planar_bodies_without_izz_are_warned_of() -> None:
    with pytest.warns(UserWarning, match="0, 0, Izz"):
        mb.make_BODY(RF, m, 0, L)


def test_objects_of_a_set_come_in_the_order_they_were_made() -> None:
    b1, b2 = bob(), bob()
    assert [body.name for body in mb.equation_set({b2, b1}, [th]).model.bodies] == ["body1", "body2"]
    first = mb.lagrange_equations({b1, b2}, [th])
    assert list(first) == list(mb.lagrange_equations([b2, b1], [th]))


def test_gravity_belongs_to_a_thread() -> None:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -L, 0))
    found = []
    thread = threading.Thread(target=lambda: found.append(mb.gravitational_energy(bob())))
    thread.start()
    thread.join()
    mine = mb.gravitational_energy(bob())
    mb.set_gravity(None)
    assert found == [0] and mine != 0


def test_objects_of_two_threads_mix() -> None:
    made: list[mb.POINT] = []
    thread = threading.Thread(target=lambda: made.append(mb.make_POINT(mb.rotate("Z", th), L, 0, 0)))
    thread.start()
    thread.join()
    v = mb.join_points(made[0], mb.make_POINT(RF, L, 1, 0))
    assert mb.comp_XYZ(v) == [0, 1, 0] and mb.make_BODY(made[0], m).frame == RF
    (found,) = mb.lagrange_equations([mb.make_BODY(made[0], m), bob()], [th])
    assert sp.simplify(found - 2 * m * L**2 * th.diff().diff()) == 0


@pytest.mark.exhaustive
def test_the_graph_of_a_thread_goes_with_its_objects() -> None:
    graphs: list[weakref.ref[object]] = []

    def work() -> None:
        for _ in range(3):
            P = mb.make_POINT(mb.rotate("Z", th), L, 0, 0)
            mb.velocity(P)
            graphs.append(weakref.ref(WORKPLACE.graph))
            del P
            gc.collect()

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert len(graphs) == 3 and all(graph() is None for graph in graphs)
