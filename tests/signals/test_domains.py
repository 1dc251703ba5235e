"""Every argument of every block has a domain, judged alike for literals and for all ways to give parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import pytest

import symbody as sb
from symbody.model.signals.block import SignalBlock

Make = Callable[[Any], sb.Signal | SignalBlock]


class Case(NamedTuple):
    """A block with one argument open, what that may be, and what it may not be."""

    argument: str
    make: Make
    good: float
    bad: tuple[float, ...]
    code: str = "block.domain"


def _finite(argument: str, make: Make) -> Case:
    """An argument that may be any number: the logarithm of what is given is none."""
    return Case(argument, lambda v: make(f"log({v})"), 0.5, (-1.0,), "model.not_finite")


def _lag(**given: Any) -> sb.FirstOrder:
    return sb.FirstOrder("y", **{"input": "x", "time": 1, **given})


def _motor(**given: Any) -> sb.DCMotor:
    usual = {"voltage": "1", "speed": "x_dot", "resistance": 1, "inductance": 1, "constant": 1}
    return sb.DCMotor("y", **{**usual, **given})


def _pid(gains: dict[str, Any] | None = None, **given: Any) -> sb.PID:
    usual = {"p": 2, "i": 1, "d": 1, "filter": 0.1}
    return sb.PID("y", **{"input": "x", "gains": usual | (gains or {}), **given})


def _limit(**given: Any) -> sb.RateLimit:
    return sb.RateLimit("y", **{"input": "x", "rise": 1, "time": 0.1, **given})


def _relay(**given: Any) -> sb.Hysteresis:
    return sb.Hysteresis("y", **{"input": "x", "lower": 0, "upper": 1, "sample": 0.1, **given})


def _ratio(**given: Any) -> sb.TransferFunction:
    return sb.TransferFunction("y", **{"input": "x", "numerator": [1], "denominator": [1, 1], **given})


def _matrices(**given: Any) -> sb.StateSpace:
    usual = {"inputs": ["x"], "A": [[-1]], "B": [[1]], "C": [[1]], "D": [[0]]}
    return sb.StateSpace("y", **{**usual, **given})


CASES = [
    Case("sample", lambda v: sb.Signal("y", "x", sample=v), 0.1, (0.0, -0.1), "signal.sample"),
    _finite("input", lambda v: _lag(input=v)),
    Case("time", lambda v: _lag(time=v), 0.1, (0.0, -1.0)),
    _finite("gain", lambda v: _lag(gain=v)),
    _finite("initial", lambda v: _lag(initial=v)),
    _finite("voltage", lambda v: _motor(voltage=v)),
    _finite("speed", lambda v: _motor(speed=v)),
    Case("resistance", lambda v: _motor(resistance=v), 0.0, (-1.0,)),
    Case("inductance", lambda v: _motor(inductance=v), 0.1, (0.0, -1.0)),
    _finite("constant", lambda v: _motor(constant=v)),
    _finite("initial", lambda v: _motor(initial=v)),
    _finite("input", lambda v: sb.Delay("y", v, 0.1)),
    Case("time", lambda v: sb.Delay("y", "x", v), 0.1, (0.0, -1.0)),
    _finite("input", lambda v: _pid(input=v)),
    _finite("gains.p", lambda v: _pid({"p": v})),
    _finite("gains.i", lambda v: _pid({"i": v})),
    _finite("gains.d", lambda v: _pid({"d": v})),
    Case("gains.filter", lambda v: _pid({"filter": v}), 0.1, (0.0, -1.0)),
    Case("gains.filter", lambda v: _pid({"filter": v}, sample=0.1), 0.0, (-1.0,)),
    Case("limits", lambda v: _pid(limits=(v, 1), tracking=1), 1.0, (1.5,), "block.limits"),
    Case("limits", lambda v: _pid(limits=(-1, v), tracking=1), 1.0, (-1.5,), "block.limits"),
    Case("tracking", lambda v: _pid(limits=(-1, 1), tracking=v), 0.1, (0.0, -1.0)),
    Case("gains", lambda v: _pid({"p": v}, limits=(-1, 1)), 1.0, (-1.0,), "block.tracking"),
    Case("gains", lambda v: _pid({"i": v}, limits=(-1, 1)), 1.0, (-1.0,), "block.tracking"),
    _finite("initial", lambda v: _pid(initial=v)),
    Case("sample", lambda v: _pid(sample=v), 0.1, (0.0, -1.0), "signal.sample"),
    _finite("input", lambda v: _limit(input=v)),
    Case("rise", lambda v: _limit(rise=v), 0.0, (-1.0,)),
    Case("fall", lambda v: _limit(fall=v), 0.0, (-1.0,)),
    Case("time", lambda v: _limit(time=v), 0.1, (0.0, -1.0)),
    _finite("initial", lambda v: _limit(initial=v)),
    Case("sample", lambda v: _limit(time=None, sample=v), 0.1, (0.0, -1.0), "signal.sample"),
    _finite("input", lambda v: _relay(input=v)),
    Case("lower", lambda v: _relay(lower=v), 1.0, (2.0,), "block.thresholds"),
    Case("lower", lambda v: _relay(upper=v), 0.0, (-1.0,), "block.thresholds"),
    _finite("low", lambda v: _relay(low=v)),
    _finite("high", lambda v: _relay(high=v)),
    _finite("initial", lambda v: _relay(initial=v)),
    Case("sample", lambda v: _relay(sample=v), 0.1, (0.0, -1.0), "signal.sample"),
    _finite("input", lambda v: _ratio(input=v)),
    _finite("numerator[0]", lambda v: _ratio(numerator=[v])),
    Case("denominator[0]", lambda v: _ratio(denominator=[v, 1]), 1.0, (0.0,), "block.no_polynomial"),
    _finite("denominator[1]", lambda v: _ratio(denominator=[1, v])),
    Case("sample", lambda v: _ratio(sample=v), 0.1, (0.0, -1.0), "signal.sample"),
    _finite("inputs[0]", lambda v: _matrices(inputs=[v])),
    _finite("A[0][0]", lambda v: _matrices(A=[[v]])),
    _finite("B[0][0]", lambda v: _matrices(B=[[v]])),
    _finite("C[0][0]", lambda v: _matrices(C=[[v]])),
    _finite("D[0][0]", lambda v: _matrices(D=[[v]])),
    _finite("initial[0]", lambda v: _matrices(initial=[v])),
    Case("sample", lambda v: _matrices(sample=v), 0.1, (0.0, -1.0), "signal.sample"),
]
# Decided when the block is written down: `order` is a whole number, a sampled delay a number of samples.
LITERAL = {("Delay", "order"), ("Delay", "sample")}


def names_of(case: Case) -> tuple[str, str]:
    return type(case.make(case.good)).__name__, case.argument


def model(case: Case, value: float) -> sb.Model:
    cart = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", force=sb.Drive(applied="-x"))
    return sb.Model("bench", [cart, case.make("k")], parameters={"k": value})


def check(problem: sb.SymbodyError | str, case: Case) -> None:
    text = str(problem)
    assert case.code in text, text
    assert f"{'signal' if 'Signal' in names_of(case) else 'block'} y, {case.argument}" in text, text
    assert "fix: " in text


def test_every_argument_of_every_block_stands_in_the_list() -> None:
    seen = {(kind, argument.partition(".")[0].partition("[")[0]) for kind, argument in map(names_of, CASES)}
    seen |= LITERAL | {("Hysteresis", "upper")}
    for kind in SignalBlock.__subclasses__():
        for name in kind.fields:
            assert name == "name" or (kind.__name__, name) in seen, (kind.__name__, name)


@pytest.mark.parametrize("case", CASES, ids=[f"{k}-{case.argument}" for k, case in enumerate(CASES)])
def test_a_value_outside_is_refused_however_it_comes(case: Case) -> None:
    eqs = sb.form_equations(model(case, case.good))
    assert sb.simulate(eqs, 0.01).t[0] == 0.0
    for bad in case.bad:
        with pytest.raises(sb.SymbodyError) as literal:
            sb.form_equations(sb.Model("bench", [*model(case, case.good).elements[:2], case.make(bad)]))
        if case.code != "model.not_finite":  # of numbers the parser says that they have no logarithm
            check(literal.value, case)
        with pytest.raises(sb.SymbodyError) as parameter:
            sb.form_equations(model(case, bad))
        check(parameter.value, case)
        with pytest.raises(sb.SymbodyError) as override:
            sb.simulate(eqs, 0.01, parameters={"k": bad})
        check(override.value, case)
        sweep = sb.sweep(eqs, 0.01, {"k": [case.good, bad]}, times=[0.0, 0.01])
        assert sweep.status[1] is sb.Status.NOT_STARTED
        check(sweep.case_notes[1], case)
        stepper = sb.Stepper(eqs, 0.01, inputs=[])
        with pytest.raises(sb.SymbodyError) as later:
            stepper.set(k=bad)
        check(later.value, case)
