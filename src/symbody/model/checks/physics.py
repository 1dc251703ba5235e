"""What the numbers of a model say: masses, inertias, axes and rotations that cannot be, or look odd."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Set
from typing import Final

from symbody.errors import Problem, nearest
from symbody.expr.graph import Constant
from symbody.expr.language.formula import Formula
from symbody.model.body import Body
from symbody.model.checks.symbols import Symbols
from symbody.model.element import Element
from symbody.model.inertia import is_possible_inertia, may_be_about
from symbody.model.joint import Joint
from symbody.model.numeric_checks import Domain, NumericChecks

_MASSES: Final = Domain(
    "model.negative_mass", "the mass is {value} kg", "a sign is wrong",
    "give a positive mass, or 0 for a massless body", 0.0,
)  # fmt: skip
_UNCHANGED: Final = "unphysical=True uses them unchanged (unphysical = true in a file)"


def check_element(check: NumericChecks, element: Element, label: str) -> None:
    """Check the numbers of an element."""
    if isinstance(element, Body):
        check_body(check, element, label)
    else:
        element.check_numbers(check, label)


def check_body(check: NumericChecks, body: Body, label: str) -> None:
    """Check mass, inertia and frames of a body."""
    mass = _MASSES(check, body.mass, f"{label}, mass")
    inertia = check.values(body.inertia, f"{label}, inertia")
    products = check.values(body.products, f"{label}, products")
    if inertia is not None and products is not None:
        judge = NumericChecks(check.parameters) if body.unphysical else check
        _check_inertia(judge, label, inertia, products)
        for problem in judge.problems if body.unphysical else ():
            check.note(f"{label}: {problem.what}; it is used unchanged")
        if mass is not None and mass > 0 and max(inertia) > 0:
            _check_size(check, body, label, mass, inertia, products)
    body.check_numbers(check, label)


def _check_inertia(check: NumericChecks, label: str, inertia: list[float], products: list[float]) -> None:
    if min(inertia) >= 0 and sum(map(bool, inertia)) <= 1 and not any(products):
        return  # planar: only the moment about the normal is given
    if is_possible_inertia(inertia, products):
        return
    a, b, c = inertia
    if not any(products):
        what = f"no body can have the moments {a:.12g}, {b:.12g}, {c:.12g}"
        why = "each moment must be positive and at most the sum of the other two"
        check.refuse("model.impossible_inertia", f"{label}, inertia", what, why, _inertia_cure(inertia))
        return
    flipped = is_possible_inertia(inertia, [-product for product in products])
    signs = "; with the opposite signs of the products a body would be possible" if flipped else ""
    listed = ", ".join(f"{product:g}" for product in products)
    what = f"no body can have the moments {a:g}, {b:g}, {c:g} with the products {listed}{signs}"
    why = "products are the entries xy, xz, yz of the tensor, as in URDF"
    fix = f"check values, signs, and that they refer to the centre of mass; {_UNCHANGED}"
    check.refuse("model.impossible_inertia", f"{label}, inertia", what, why, fix)


def _inertia_cure(inertia: list[float]) -> str:
    if min(inertia) < 0:
        return f"give nonnegative moments; {_UNCHANGED}"
    largest = max(inertia)
    moments = (f"{value:.12g}" if value == largest else f"at least {largest / 2:.12g}" for value in inertia)
    return f"for instance {', '.join(moments)}; {_UNCHANGED}"


def _check_size(
    check: NumericChecks, body: Body, label: str, mass: float, inertia: list[float], products: list[float]
) -> None:
    """Remark on an inertia too large or too small for the body's frames: other units, or another point."""
    found = {name: check.values(frame.at, f"{label}, frames") for name, frame in body.frames.items()}
    places = {name: place for name, place in found.items() if place is not None and any(place)}
    if not places:
        return
    gyration = math.sqrt(max(inertia) / mass) / max(math.hypot(*place) for place in places.values())
    if not 1e-3 < gyration < 1e3:
        check.note(
            f"{label}: the radius of gyration is {gyration:.2g} times the distance of the farthest frame; "
            "are lengths in m and inertias in kg m^2?"
        )
        return
    fitting = [name for name, place in places.items() if may_be_about(place, mass, inertia, products)]
    if gyration > 1 and fitting:
        check.note(
            f"{label}: the radius of gyration is {gyration:.2g} times the distance of the farthest frame; "
            f"is the inertia about the centre of mass, or about {fitting[0]}?"
        )


def value_problems(
    elements: Mapping[str, Element], values: Mapping[str, Constant], changed: Set[str]
) -> list[Problem]:
    """Return what is impossible about elements that read parameters given anew."""
    check = NumericChecks(values)
    for label, element in elements.items():
        if changed.isdisjoint(name for site in element.formula_sites() for name in site.formula.names):
            continue
        check_element(check, element, label)
    return check.problems


_WORDS: Final = ("coordinate", "rate", "speed")
_NORM: Final = 1e-6


def initial_problems(
    initial: Mapping[str, Formula], symbols: Symbols, joints: Iterable[Joint]
) -> list[Problem]:
    """Return a problem for each initial value of what has none."""
    legal = [name for name, meaning in symbols.meanings.items() if meaning.word in _WORDS]
    prescribed = {
        f"{name}{suffix}": joint
        for joint in joints
        if not joint.as_constraint
        for name in joint.motion
        for suffix in ("", "_dot")
    }
    states = [name for name, meaning in symbols.meanings.items() if meaning.word == "signal"]
    problems = []
    for name in initial:
        where = f"model, initial.{name}"
        if name in prescribed:
            problems.append(
                Problem("initial.prescribed", where,
                        f"the prescribed motion of joint {prescribed[name].name} determines {name}",
                        "a prescribed coordinate is not an unknown and starts where its motion starts",
                        "remove the initial value or the motion")
            )  # fmt: skip
        elif name in states:
            problems.append(
                Problem("signal.initial", where, f"{name} is a signal ({symbols.meanings[name].where})",
                        "the initial value of a signal with a rate is part of the signal",
                        f'write [[signal]] name = "{name}", rate = .., initial = .., or give it to simulate')
            )  # fmt: skip
        elif name not in legal:
            problems.append(
                Problem("initial.unknown", where, f"there is no coordinate, rate or speed {name!r}",
                        "initial values can be set for coordinates, their rates x_dot, and speeds",
                        nearest(name, legal))
            )  # fmt: skip
    return problems


def check_initial(check: NumericChecks, initial: Mapping[str, Formula], joints: Iterable[Joint]) -> None:
    """Check the values; four that form a quaternion must not all be zero."""
    values = {name: check.value(formula, f"model, initial.{name}") for name, formula in initial.items()}
    for joint in joints:
        names: tuple[str, ...] = joint.quaternion or ()
        numbers = [value for name in names if (value := values.get(name)) is not None]
        norm = math.hypot(*numbers) if len(numbers) == 4 else 1.0
        listed = ", ".join(names)
        if norm == 0:
            what = f"{listed} are all zero"
            why = "a quaternion of norm zero is not a rotation"
            fix = f"write 1 for {names[0]}, or leave all four out: no rotation"
            check.refuse("initial.zero_quaternion", f"model, initial.{names[0]}", what, why, fix)
        elif abs(norm - 1) > _NORM:
            check.note(f"joint {joint.name}: the initial quaternion {listed} of norm {norm:g} is normalized")
