"""Laws of signals on random mechanisms: names change nothing, neither does what is only looked at.

Signals added at random change no acceleration; a formula split into signals at its brackets compiles to the same
text; signals in another order and under other names give the same rates.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.model import resolve_parameters
from symbody.model.element import Element
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.evaluation import arguments
from tests.laws.mechanisms import random_mechanism
from tests.laws.rotations import Array
from tests.laws.tally import chunks, name_of
from tests.tiers import cases

# What is defined for any operand; a divisor is kept away from 0.
_ONE = ("sin({a})", "cos({a})", "tanh({a})", "-({a})", "({a})/(2 + ({b})^2)")
_TWO = ("({a}) + ({b})", "({a})*({b})", "({a}) - ({b})", "min({a}, ({b}))", "if(({a}) > ({b}), ({a}), ({b}))")


def formula(rng: random.Random, words: list[str], depth: int) -> str:
    """A formula in some names, its parts in brackets."""
    if depth == 0:
        return rng.choice([*words, "t", f"{rng.uniform(-2, 2):.3f}"])
    a, b = (formula(rng, words, depth - 1) for _ in range(2))
    return rng.choice(_ONE + _TWO).format(a=a, b=b)


def split(text: str, rng: random.Random, number: int) -> tuple[str, list[sb.Signal]]:
    """The formula with some bracketed parts named, and the signals that they are."""
    signals: list[sb.Signal] = []
    for k in range(number):
        places = [i for i, c in enumerate(text) if c == "(" and (i == 0 or not text[i - 1].isalnum())]
        if not places:
            break
        start = rng.choice(places)
        depth, end = 1, start + 1
        while depth:
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        signals.append(sb.Signal(f"part_{k}", text[start + 1 : end - 1]))
        text = f"{text[:start]}(part_{k}){text[end:]}"
    return text, signals


def with_parts(model: sb.Model, *parts: Element) -> sb.Model:
    """The model with further elements."""
    elements = (*model.elements, *parts)
    return sb.Model(
        model.name, elements, model.gravity, model.parameters, model.inputs, model.initial, model.ground
    )


def words_of(model: sb.Model) -> list[str]:
    """Names that loads may read."""
    eqs = sb.form_equations(model)
    return [*eqs.coordinate_names, *eqs.speed_names, *eqs.input_names]


def load(text: str, model: sb.Model) -> Element:
    """A force of a formula on the last body."""
    return sb.Force("drawn", model.bodies[-1].name, (0, text, 0))


def rates(model: sb.Model, state: State, signals: dict[str, float]) -> dict[str, float]:
    """x' by name, by compiled code."""
    eqs = sb.form_equations(model)
    if eqs.multiplier_names:
        eqs = eqs.for_values({name: float(x) for name, x in resolve_parameters(model).items()})
    s = [signals[name] for name in eqs.signal_state_names]
    t, q, u, r = arguments(eqs, state)
    values: Array = sb.compile(eqs, "xdot")(t, q, u, r, s=s) if s else sb.compile(eqs, "xdot")(t, q, u, r)
    return dict(zip(eqs.state_names, values.tolist(), strict=True))


def check_added(seed: int) -> None:
    """Signals that nothing but signals reads: the mechanism has the same rates, bit for bit."""
    model, state = build_model(random_mechanism(seed)), consistent_state(random_mechanism(seed))
    rng, words = random.Random(seed), words_of(model)
    outputs = ["kinetic_energy", "power", *(f"frame v {body.name} ground ground x" for body in model.bodies)]
    outputs += [f"{name.removesuffix('_dot')}_ddot" for name in words if name.endswith("_dot")]
    read = sb.Signal("looked", output=rng.choice(outputs))
    value = sb.Signal("value", formula(rng, [*words, "looked"], 2))
    follower = sb.Signal("follower", rate=f"({formula(rng, [*words, 'value'], 2)}) - follower", initial=0.5)
    bare = rates(model, state, {})
    more = rates(with_parts(model, follower, value, read), state, {"follower": 0.5})
    assert {name: more[name] for name in bare} == bare


def check_split(seed: int) -> None:
    """A formula split at its brackets: the same text in C."""
    model = build_model(random_mechanism(seed))
    rng = random.Random(seed)
    text = formula(rng, words_of(model), 4)
    parted, signals = split(text, rng, 4)
    rng.shuffle(signals)
    one, two = (
        sb.form_equations(with_parts(model, *parts))
        for parts in ((load(text, model),), (*signals, load(parted, model)))
    )
    assert sb.generate_code(two, "xdot", "c", parameters={}) == sb.generate_code(
        one, "xdot", "c", parameters={}
    )


def check_names(seed: int) -> None:
    """Other names and another order of states and values: the same rates."""
    model, state = build_model(random_mechanism(seed)), consistent_state(random_mechanism(seed))
    rng, words = random.Random(seed), words_of(model)
    texts = {f"state_{k}": formula(rng, [*words, "state_0", "state_1", "state_2"], 2) for k in range(3)}
    value = formula(rng, [*words, *texts], 3)
    values = {name: rng.uniform(-1, 1) for name in texts}
    other = {"state_0": "zeta", "state_1": "alpha", "state_2": "mu", "value": "b_value"}

    def parts(name: dict[str, str], order: Iterable[int]) -> list[Element]:
        def said(text: str) -> str:
            for old, new in name.items():
                text = text.replace(old, new)
            return text

        listed: list[Element] = [sb.Signal(name[key], rate=said(text)) for key, text in texts.items()]
        listed += [sb.Signal(name["value"], said(value)), load(name["value"], model)]
        return [listed[k] for k in order]

    same = {key: key for key in other}
    one = rates(with_parts(model, *parts(same, range(5))), state, values)
    two = rates(
        with_parts(model, *parts(other, (4, 2, 3, 0, 1))),
        state,
        {other[key]: x for key, x in values.items()},
    )
    found, wanted = (
        [given[name] for name in sorted(given)]
        for given in (two, {other.get(n, n): x for n, x in one.items()})
    )
    # Sums are in the order in which names come; conditions of random mechanisms stay below a million.
    np.testing.assert_allclose(found, wanted, rtol=1e-8, atol=1e-10 * np.abs(wanted).max())


LAWS = (check_added, check_split, check_names)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", cases([1, 11], fast=[1]))
def test_signals_change_nothing(law: object, seed: int) -> None:
    law(seed)  # type: ignore[operator]


@pytest.mark.exhaustive
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seeds", chunks(60), ids=name_of)
def test_signals_change_nothing_often(law: object, seeds: range) -> None:
    for seed in seeds:
        law(seed)  # type: ignore[operator]
