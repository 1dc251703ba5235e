"""Each misuse of a signal has its message, with place and cure."""

from __future__ import annotations

import pytest

import symbody as sb
from symbody.model.element import Element
from tests.faults.refusals import refused, refused_model
from tests.signals.arm import arm


def codes(*parts: Element, **more: object) -> list[tuple[str, str]]:
    """Code and place of what is wrong with the arm and these parts."""
    return refused(lambda: arm(*parts, torque="0", **more))


def test_exactly_one_of_three() -> None:
    assert refused(lambda: sb.Signal("a")) == [("signal.one_of", "signal a")]
    assert refused(lambda: sb.Signal("a", 1, rate=2)) == [("signal.one_of", "signal a")]


def test_only_states_have_initial_values() -> None:
    assert refused(lambda: sb.Signal("a", "t", initial=1)) == [("signal.initial", "signal a, initial")]
    assert codes(sb.Signal("a", rate=1), initial={"a": 1}) == [("signal.initial", "model, initial.a")]


@pytest.mark.parametrize("name", ["theta", "theta_dot", "m", "V"])
def test_names_are_shared_with_all_symbols(name: str) -> None:
    assert codes(sb.Signal(name, 1), inputs=["V"])[0][0] == "names.duplicate"


def test_rates_of_states_have_names_of_their_own() -> None:
    assert codes(sb.Signal("a", rate=1), sb.Signal("a_dot", 1))[0][0] == "names.duplicate"


def test_names_are_symbols() -> None:
    assert refused(lambda: sb.Signal("my signal", 1))[0][0] == "names.not_a_symbol"
    assert refused(lambda: sb.Signal("t", 1))[0][0] == "names.reserved"


def test_rings_are_named() -> None:
    parts = [sb.Signal("a", "d + 1"), sb.Signal("d", "c"), sb.Signal("c", "2*a")]
    with pytest.raises(sb.SymbodyError, match="a -> d -> c -> a|d -> c -> a -> d|c -> a -> d -> c"):
        arm(*parts, torque="0")
    assert codes(*parts)[0][0] == "signal.loop"
    arm(sb.Signal("a", "d + 1"), sb.Signal("d", rate="a"), torque="a")  # a state breaks the ring


def test_constraints_motions_and_inertia_take_no_signals() -> None:
    signal = sb.Signal("a", rate=1)
    assert refused_model(signal, sb.Body("B", mass="a"))[0] == ("names.not_here", "body B, mass, column 1")
    ends = sb.Body("B", mass=1, frames={"P": sb.Frame()}), sb.Body("C", mass=1, frames={"P": sb.Frame()})
    rod = sb.Distance("rod", "B.P", "C.P", "a")
    assert refused_model(signal, *ends, rod)[0] == ("names.not_here", "constraint rod, value, column 1")
    equation = sb.Constraint("c", equations=["theta - a"])
    assert codes(signal, equation)[0] == ("names.not_here", "constraint c, equations[0], column 9")
    slide = sb.Prismatic("j", "ground", sb.Body("B", mass=1), coordinate="x", motion="a")
    assert refused_model(signal, slide)[0] == ("names.not_here", "joint j, motion, column 1")


def test_rates_of_signals_stand_in_no_formula() -> None:
    assert codes(sb.Signal("a", rate=1), sb.Signal("c", "a_dot"))[0] == (
        "names.not_here",
        "signal c, value, column 1",
    )


def test_unknown_names_in_signals() -> None:
    assert codes(sb.Signal("a", "thetta"))[0] == ("names.unknown", "signal a, value, column 1")


def test_text_of_an_output() -> None:
    assert refused(lambda: sb.Signal("a", output=" "))[0][0] == "model.not_a_text"


@pytest.mark.parametrize("output", ["'effort motor'", "2*'effort motor' + 1"])
def test_output_in_quotes_that_leads_back_is_refused(output: str) -> None:
    fault = refused(
        lambda: sb.form_equations(arm(sb.Signal("T", output=output), torque="T")), words="in a cycle"
    )
    assert fault[0][1] == "signal T, output"


def test_an_initial_value_without_an_integral_is_refused() -> None:
    assert refused(lambda: sb.PID("c", "theta", {"p": 1}, initial=2)) == [
        ("signal.initial", "block c, initial")
    ]


def test_zeros_in_front_of_a_numerator_are_no_degree() -> None:
    block = sb.TransferFunction("y", "-y", [0, 0.0, 1], [1, 1])
    assert [str(signal.value or signal.rate) for signal in block.signals] == [
        str(signal.value or signal.rate) for signal in sb.TransferFunction("y", "-y", [1], [1, 1]).signals
    ]
    sb.form_equations(arm(block, torque="y"))


def test_a_block_of_several_outputs_keeps_its_own_name() -> None:
    block = sb.StateSpace("y", inputs=["theta"], A=[[-1]], B=[[1]], C=[[1], [2]])
    ((code, where),) = codes(block, sb.Signal("y", "2*theta"))
    assert code == "names.duplicate" and "signal y" in where and "block y" in where
    refused(lambda: arm(block, torque="y"), words="is a block, which is not allowed here")
    assert sb.form_equations(arm(block, torque="y_2")).signal_state_names == ("y_x1",)


def test_a_controller_without_proportional_part_needs_a_time_at_its_limits() -> None:
    for gains, words in (({"i": 1}, "there is no p"), ({"p": 0, "i": 1}, "p is 0")):
        refused(lambda g=gains: sb.PID("servo", "-theta", g, limits=(-1, 1)), words=words)  # type: ignore[misc]
    zero = sb.PID("servo", "-theta", {"p": "km", "i": 1}, limits=(-1, 1))
    eqs = sb.form_equations(arm(zero, torque="servo"))
    refused(lambda: sb.compile(eqs, "xdot", {"km": 0}), words="p = km is 0, and there is no tracking")


def test_fixed_states_of_signals_are_no_question_of_equilibrium() -> None:
    eqs = sb.form_equations(arm(sb.Signal("i", rate="1 - i"), torque="i"))
    found = refused(lambda: sb.find_equilibrium(eqs, fixed={"i": 0.2}), words="is a state of a signal")
    assert found == [("equilibrium.signal", "i")]


def test_a_law_that_reads_its_own_input_names_what_leads_there() -> None:
    parts = [sb.Signal("pull", output="theta_ddot"), sb.Signal("more", "pull + 1")]
    eqs = sb.form_equations(arm(*parts, torque="F", inputs=("F",)))
    refused(
        lambda: sb.simulate(eqs, 1, inputs={"F": "2*more + theta"}), words="its formula reads more, which"
    )
