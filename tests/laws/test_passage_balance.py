"""Law: the balance T + V - W across a passage tells a motion from one that gained or lost energy there.

Damped, driven double pendulums move on and back in time. What damping and drive take and add is work, so any
stretch of a motion holds. Two motions put together, the second with speeds that another branch would have, hold
if the speeds have the same energy (all of them reversed) and change the balance by what they have more or less.
"""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.methods.closed_loops.change_point import passage_balance
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.simulation_problem import SimulationProblem

RTOL = 1e-8
SPAN = 0.5
VALUES = {"r": 0.2, "m": 1.0, "J": 0.02, "k": 3.0, "c": 0.1}
WORSE = 1e3  # what a passage may be worse than a step, which leaves at least RTOL of the energies


def double_pendulum() -> sb.EquationSet:
    """Two links on damped springs, the first one driven."""
    frames = {"near": sb.Frame(at=(0, "r", 0)), "far": sb.Frame(at=(0, "-r", 0))}
    elements: list[object] = [
        sb.Body(name, mass=mass, inertia=("J", "J", "J"), frames=frames)
        for name, mass in (("A", "m"), ("B", 1))
    ]
    elements += [
        sb.Revolute("P", "ground", "A.near", coordinate="a", torque=sb.Drive("k*sin(9*t) - c*a_dot")),
        sb.Revolute("Q", "A.far", "B.near", coordinate="b", torque=sb.Drive("-k*b - c*b_dot")),
    ]
    return sb.form_equations(sb.Model("pendulum", elements, parameters=VALUES, gravity=(0, "-9.81", 0)))


@pytest.fixture(scope="module")
def pendulum() -> sb.EquationSet:
    return double_pendulum()


def motion(
    eqs: sb.EquationSet, values: dict[str, float], state: NDArray[np.float64], start: float, end: float
) -> DenseOutput:
    """The motion from speeds, coordinates and work."""
    initial = dict(zip(("a_dot", "b_dot", "a", "b"), state.tolist(), strict=False))
    run = sb.simulate(eqs, (start, end), initial, parameters=values, rtol=RTOL)
    assert run.success and run.dense_output is not None
    # Work at the ends of steps, where alone it is asked for.
    work = np.zeros((*run.dense_output.pieces.shape[:2], 1))
    work[:, 0, 0], work[:, 1, 0] = state[-1] + run["work"][:-1], np.diff(run["work"])
    pieces = np.concatenate([run.dense_output.pieces, work], axis=2)
    return DenseOutput(run.dense_output.breaks, pieces)


def check(eqs: sb.EquationSet, seed: int) -> None:
    random = Random(seed)
    values = {name: random.uniform(0.5, 2.0) * value for name, value in VALUES.items()}
    way = random.choice([-1.0, 1.0])
    laws = input_laws(eqs.input_names, {}, (0.0, 1.0))
    problem = SimulationProblem(eqs, values, laws, mechanism_scales(eqs, values))
    start = np.array([random.uniform(-5, 5) for _ in range(4)] + [random.uniform(-9, 9)])
    first = motion(eqs, values, start, 0.0, way * SPAN)
    middle = first.breaks.size // 2
    before, after = first.breaks[[middle - random.randint(0, 1), middle + random.randint(1, 2)]].tolist()
    assert passage_balance(problem, first, before, after, RTOL).holds, seed

    end = first.at_end()
    share = random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-3, -1)
    function = problem.compile_outputs(("kinetic_energy", "potential_energy"))
    kinetic, _ = problem.evaluate(function, np.array([way * SPAN]), end[2:4, None], end[:2, None])
    for factor, gained in ((-1.0, 0.0), (np.sqrt(1.0 + share), share * kinetic[0])):
        state = np.concatenate([factor * end[:2], end[2:]])
        second = motion(eqs, values, state, way * SPAN, 2.0 * way * SPAN)
        both = DenseOutput(
            np.concatenate([first.breaks, second.breaks[1:]]), np.concatenate([first.pieces, second.pieces])
        )
        balance = passage_balance(problem, both, first.breaks[-2], second.breaks[1], RTOL)
        # A step or two lies in the passage beside what is planted.
        assert abs(balance.change - abs(gained)) < 3.0 * balance.usual, (seed, factor)
        assert balance.holds == (abs(gained) < WORSE * balance.usual), (seed, factor)
        assert balance.holds or gained, (seed, factor)
        # What is planted is a part of the energies that stands out, if the pendulum moves at all.
        assert not balance.holds or abs(share) * kinetic[0] < 0.1 or not gained, (seed, balance, gained)


def test_passages_of_pendulums(pendulum: sb.EquationSet) -> None:
    for seed in range(5):
        check(pendulum, seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(20))
def test_passages_of_many_pendulums(pendulum: sb.EquationSet, chunk: int) -> None:
    for seed in range(100 * chunk, 100 * chunk + 100):
        check(pendulum, seed)
