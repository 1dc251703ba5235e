"""Redundant constraints are found and named; the others are left alone."""

from __future__ import annotations

import pytest

import symbody as sb

TURN = [((1, 2, 2), 0.7)]


def four_bar(*, turned: bool) -> sb.Model:
    """A planar four-bar of spatial revolute joints; turned as a whole, its axes are no letters."""
    frames = {"o": sb.Frame(at=("-L/2", 0, 0)), "t": sb.Frame(at=("L/2", 0, 0))}
    ground = {
        "p": sb.Frame(rotate=TURN if turned else []),
        "r": sb.Frame(at=(1.0, 0, 0)),
    }
    if turned:  # the second support stands along the turned x axis
        base = sb.Body("Base", frames={"r": sb.Frame(at=(1.0, 0, 0))})
        elements: list[object] = [base, sb.Weld("w", "ground.p", base)]
        first, second = "Base", "Base.r"
    else:
        elements, first, second = [], "ground", "ground.r"
    for name, length in (("A", 0.4), ("B", 1.1), ("C", 0.9)):
        elements.append(sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), frames={
            "o": sb.Frame(at=(-length / 2, 0, 0)), "t": sb.Frame(at=(length / 2, 0, 0))}))  # fmt: skip
    assert frames
    elements += [
        sb.Revolute("J1", first, "A.o", coordinate="q1"),
        sb.Revolute("J2", "A.t", "B.o", coordinate="q2"),
        sb.Revolute("J3", second, "C.o", coordinate="q3"),
        sb.Revolute("J4", "B.t", "C.t"),
    ]
    return sb.Model("four-bar", elements, ground=ground, parameters={"L": 1})  # type: ignore[arg-type]


def test_off_plane_rows_in_axes_of_letters_are_dropped_at_once() -> None:
    eqs = sb.form_equations(four_bar(turned=False))
    assert len(eqs.multiplier_names) == 2
    assert sb.redundancy(eqs) == sb.Redundancy(1, eqs.multiplier_names, ())


def test_three_redundant_rows_in_general_axes_are_named() -> None:
    eqs = sb.form_equations(four_bar(turned=True))
    found = sb.redundancy(eqs)
    assert found.degrees_of_freedom == eqs.degrees_of_freedom == 1
    assert len(found.kept) == 2 and len(found.dropped) == len(eqs.multiplier_names) - 2


def test_of_two_equal_supports_the_first_bears_the_load() -> None:
    shaft = sb.Body("Shaft", mass=1, inertia=(1, 1, 1), frames={"far": sb.Frame(at=(0, 0, 1))})
    model = sb.Model(
        "shaft",
        [
            shaft,
            sb.Revolute("near", "ground", "Shaft", coordinate="a", tree=False),
            sb.Revolute("far", "ground.far", "Shaft.far", tree=False),
        ],
        ground={"far": sb.Frame(at=(0, 0, 1))},
    )
    eqs = sb.form_equations(model)
    found = sb.redundancy(eqs)
    assert found.degrees_of_freedom == 1 and len(found.dropped) == 5
    assert {name.split("_")[1] for name in found.kept} >= {"near"}


def test_a_tree_has_nothing_to_drop() -> None:
    eqs = sb.form_equations(
        sb.Model("t", [sb.Revolute("a", "ground", sb.Body("B", mass=1, inertia=(1, 1, 1)))])
    )
    assert sb.redundancy(eqs) == sb.Redundancy(1, (), ())


@pytest.mark.parametrize("turned", [False, True])
def test_the_four_bar_moves_and_stays_closed(turned: bool) -> None:
    eqs = sb.form_equations(four_bar(turned=turned))
    run = sb.simulate(eqs, 5.0, {"q1": 0.5, "q1_dot": 6.0}, guess={"q2": 0.5, "q3": 1.0})
    assert run.status is sb.Status.SUCCESS
    assert run["constraint_violation"].max() < 1e-9
    energy = run["energy"]
    # rtol 1e-8 a step over some hundred steps
    assert abs(energy - energy[0]).max() < 1e-5 * energy[0]
