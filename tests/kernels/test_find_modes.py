"""The engine of modes on reduced problems: against all modes in rational numbers, and its rules one by one."""

from __future__ import annotations

from collections import Counter
from itertools import permutations
from random import Random

import numpy as np
import pytest
import scipy

from symbody.analysis.modes.reduced_modes import (
    ModeCandidate,
    ModeVerdict,
    Responses,
    decide,
    mode_problem,
    mode_solution,
)
from symbody.kernels.modes.find_modes import find_modes
from symbody.kernels.modes.mode_problem import BACK, BOUNDED, CONE, HOLDS, LOOSE, UNILATERAL, ModeProblem
from tests.kernels.rational_modes import draw


def fixed(offsets: list[float], matrix: list[list[float]]) -> Responses:
    """Return responses of elements whose strengths are efforts."""
    return Responses(np.array(offsets), np.array(matrix), np.zeros(0), np.zeros((0, len(offsets))))


def dry(strength: float, static: float | None = None, **more: object) -> ModeCandidate:
    return ModeCandidate(BOUNDED, sliding=strength, static=strength if static is None else static, **more)  # type: ignore[arg-type]


def test_a_thousand_problems_against_all_modes_in_rational_numbers() -> None:
    random, counts = Random(34), Counter[tuple[str, int]]()
    for _ in range(1000):
        problem = draw(random)
        n = len(problem.kinds)
        wanted, found = problem.solutions(), problem.decide(range(n))
        counts[found.verdict.name, min(len(wanted), 2)] += 1
        if found.verdict is ModeVerdict.ONE:
            ((accelerations, _),) = wanted.items()
            sizes = max(abs(found.efforts).max(), abs(found.accelerations).max(), 1.0)
            assert found.accelerations == pytest.approx(
                np.array(accelerations, dtype=float), abs=1e-8 * sizes
            )
    assert counts.keys() == {("ONE", 1), ("NONE", 0), ("TWO", 2)}
    assert min(counts.values()) > 20  # each of the three occurs


def test_permuted_elements_have_the_same_modes_and_efforts() -> None:
    random = Random(5)
    for _ in range(100):
        problem = draw(random)
        n = len(problem.kinds)
        first = problem.decide(range(n))
        if first.verdict is not ModeVerdict.ONE:
            continue
        for order in permutations(range(n)):
            other = problem.decide(order)
            assert other.verdict is ModeVerdict.ONE
            assert other.modes == tuple(first.modes[k] for k in order)
            size = 1e-9 * max(1.0, np.abs(first.efforts).max())
            assert other.efforts == pytest.approx(first.efforts[list(order)], abs=size)


def test_python_and_machine_code_give_the_same_bits() -> None:
    random = Random(9)
    for _ in range(8):
        n = random.randint(1, 4)
        rows = np.array([[random.uniform(-1, 1) for _ in range(2 * n)] for _ in range(2 * n)])
        elements = [ModeCandidate(CONE, normals=1, sliding=0.4, static=0.5) for _ in range(n)]
        reactions = np.array([[random.uniform(-0.3, 0.3) for _ in range(2 * n)] for _ in range(n)])
        offsets, loads = rows[0] * 3.0, np.array([random.uniform(-2, 2) for _ in range(n)])
        responses = Responses(offsets, rows @ rows.T, loads, reactions)
        block = mode_problem(elements, responses)
        by_python = ModeProblem(block.tolist())
        verdict = ModeVerdict(find_modes(by_python))
        python, machine = mode_solution(np.array(by_python.entries), verdict), decide(elements, responses)
        assert python.verdict is machine.verdict and python.modes == machine.modes
        assert (python.efforts == machine.efforts).all() and (python.slip == machine.slip).all()


# A contact with friction that slides: a row along the normal, a row along the tangent.
def rod(
    mu: float, angle: float, *, load: float, lifts: bool = False
) -> tuple[list[ModeCandidate], Responses]:
    """Painleve's rod: uniform, mass and half length 1, its end slides at an angle p, 1 up and 3 cos^2 p across.

    An effort N at the end and friction mu N against its motion give it the normal acceleration
    ``N (1 + 3 cos p (cos p - mu sin p)) - load``.
    """
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[1 + 3 * c * c, 3 * s * c], [3 * s * c, 1 + 3 * s * s]])
    normal = ModeCandidate(UNILATERAL, moves=lifts, mode=LOOSE if lifts else HOLDS)
    slides = ModeCandidate(BOUNDED, normals=1, sliding=mu, static=mu, moves=True, mode=LOOSE, slip=(1.0, 0.0))
    return [normal, slides], Responses(np.array([-load, 0.0]), matrix, np.zeros(1), np.array([[1.0, 0.0]]))


def test_painleves_rod_has_one_none_and_two_solutions() -> None:
    """Below mu = (1 + 3 cos^2 p) / (3 sin p cos p) one; above none under load, and two where it lifts off."""
    angle = np.arctan(2.0)
    edge = (1 + 3 * np.cos(angle) ** 2) / (3 * np.sin(angle) * np.cos(angle))
    assert edge == pytest.approx(4.0 / 3.0, rel=1e-15)  # the least of all angles
    for share, load, verdict in (
        (0.99, 1.0, ModeVerdict.ONE), (0.99, -1.0, ModeVerdict.ONE), (1.01, 1.0, ModeVerdict.NONE), (1.01, -1.0, ModeVerdict.TWO),
    ):  # fmt: skip
        elements, responses = rod(share * edge, angle, load=load)
        assert decide(elements, responses).verdict is verdict
        swapped = Responses(
            responses.offsets[::-1].copy(), responses.matrix[::-1, ::-1].copy(), responses.loads,
            responses.reactions[:, ::-1].copy(),
        )  # fmt: skip
        assert decide(elements[::-1], swapped).verdict is verdict


def test_an_element_at_rest_holds_up_to_its_static_strength() -> None:
    """With mu_static = 2 mu: what rests stays, what slips goes on with the kinetic strength."""
    for load, mode, rate in ((1.5, HOLDS, 0.0), (-1.5, HOLDS, 0.0), (2.5, LOOSE, 1.5), (-2.5, BACK, -1.5)):
        found = decide([dry(1.0, 2.0)], fixed([load], [[1.0]]))
        assert found.verdict is ModeVerdict.ONE and found.modes == (mode,)
        assert found.accelerations[0] == pytest.approx(rate, abs=1e-15)
    slides = dry(1.0, 2.0, moves=True, mode=LOOSE, slip=(1.0, 0.0))
    assert decide([slides], fixed([1.5], [[1.0]])).accelerations[0] == 0.5


def test_one_that_breaks_away_may_relieve_or_load_others() -> None:
    """Two blocks between springs: the second holds as long as the first does, and as it does not."""
    stiff = [[2.0, -1.0], [-1.0, 2.0]]
    found = decide([dry(1.0), dry(3.0)], fixed([4.0, 1.0], stiff))
    assert found.verdict is ModeVerdict.ONE and found.modes == (LOOSE, HOLDS)
    assert found.efforts == pytest.approx([-1.0, -1.0], abs=1e-14)


HINGES = [[1.0, 1.0], [1.0, 1.0]]


@pytest.mark.parametrize("swapped", [False, True])
def test_a_door_on_two_hinges_breaks_away_only_beyond_both(swapped: bool) -> None:
    """Least norm: equal shares; beyond the limit of the weak hinge the strong one bears the rest."""
    weak, strong = 1.0, 4.0
    for torque, shares in (
        (1.0, (0.5, 0.5)), (1.9, (0.95, 0.95)), (3.0, (1.0, 2.0)), (4.999, (1.0, 3.999)), (-3.0, (-1.0, -2.0)),
    ):  # fmt: skip
        limits = (strong, weak) if swapped else (weak, strong)
        found = decide([dry(x) for x in limits], fixed([torque, torque], HINGES))
        assert found.verdict is ModeVerdict.ONE and found.modes == (HOLDS, HOLDS)
        assert found.efforts == pytest.approx([-x for x in (shares[::-1] if swapped else shares)], abs=1e-8)
    found = decide([dry(weak), dry(strong)], fixed([5.001, 5.001], HINGES))
    assert found.verdict is ModeVerdict.ONE and found.modes == (LOOSE, LOOSE)
    assert found.accelerations == pytest.approx([0.001, 0.001], rel=1e-9)


def test_ropes_share_what_neither_bears_alone_and_none_pushes() -> None:
    """A load on three parallel ropes of one length, hung off its middle: shares of least norm, none negative."""
    arms = np.array([-1.0, 0.0, 1.0])
    rows = np.column_stack([np.ones(3), arms])
    for x, wanted in ((0.0, (1 / 3, 1 / 3, 1 / 3)), (0.5, (1 / 12, 1 / 3, 7 / 12)), (0.9, (0.0, 0.1, 0.9))):
        # of a plate whose responses are 1 in height and in turn: the load 1 at x
        offsets = -rows @ np.array([1.0, x])
        found = decide([ModeCandidate(UNILATERAL)] * 3, fixed(offsets.tolist(), (rows @ rows.T).tolist()))
        assert found.verdict is ModeVerdict.ONE
        assert found.efforts == pytest.approx(wanted, abs=1e-9)
        assert rows.T @ found.efforts == pytest.approx([1.0, x], abs=1e-9)


def test_many_elements_are_found_by_the_search() -> None:
    """30 dry joints with fixed strengths: the least of a quadratic function in a box, by another solver."""
    random = np.random.default_rng(3)
    for _ in range(30):
        root = random.normal(size=(40, 30))
        offsets = random.normal(size=30) * 30.0
        found = decide([dry(1.0)] * 30, fixed(offsets.tolist(), (root.T @ root).tolist()))
        target = -np.linalg.lstsq(root.T, offsets, rcond=None)[0]
        wanted = scipy.optimize.lsq_linear(root, target, (-1.0, 1.0), tol=1e-14, method="bvls").x
        assert found.verdict is ModeVerdict.ONE
        assert found.efforts == pytest.approx(wanted, abs=1e-8)


def sliding_box(mu: float, order: tuple[int, ...]) -> tuple[list[ModeCandidate], Responses]:
    """A box of 2 kg, 0.4 m by 0.3 m and 0.6 m high, that slides and spins on its lower corners, in some order."""
    edges, mass, g = np.array([0.4, 0.3, 0.6]), 2.0, 9.81
    inertia = mass / 12 * (np.sum(edges**2) - edges**2)
    corners = np.array([[1, 1, -1], [1, -1, -1], [-1, 1, -1], [-1, -1, -1]])[list(order)] * edges / 2
    slips = np.array([1.2, 1.2, 0]) + np.cross([0, 0, 0.25], corners)
    along = [[*slip[:2] / np.linalg.norm(slip[:2]), 0] for slip in slips]
    rows = np.array([
        *([*axis, *np.cross(corner, axis)] for corner in corners for axis in np.eye(3)[:2]),
        *([0, 0, 1, *np.cross(corner, [0, 0, 1])] for corner in corners),
    ])  # fmt: skip
    elements = [
        ModeCandidate(CONE, normals=1, sliding=mu, static=mu, moves=True, mode=LOOSE, slip=(x, y))
        for x, y, _ in along
    ]
    elements += [ModeCandidate(UNILATERAL)] * 4
    reactions = np.hstack([np.zeros((4, 8)), np.eye(4)])
    inverse = np.diag([*[1 / mass] * 3, *1 / inertia])
    return elements, Responses(-g * rows[:, 2], rows @ inverse @ rows.T, np.zeros(4), reactions)


def test_friction_in_corners_follows_shares_of_least_norm() -> None:
    """Any corner could bear less and its neighbors more; one that would bear less than nothing opens."""
    by_corner: dict[float, list[tuple[float, ...]]] = {0.2: [], 0.6: []}
    for mu, found in by_corner.items():
        for order in permutations(range(4)):
            solution = decide(*sliding_box(mu, order))
            assert solution.verdict is ModeVerdict.ONE
            assert solution.normals[:4].sum() == pytest.approx(2 * 9.81, rel=1e-12)
            assert solution.accelerations[8:] == pytest.approx(0, abs=1e-10)
            found.append(tuple(solution.normals[order.index(k)] for k in range(4)))
        assert np.ptp(found, axis=0) == pytest.approx(0, abs=1e-9)
    (a, b, c, d), (bears, *others) = by_corner[0.2][0], sorted(by_corner[0.6][0])
    assert min(a, b, c, d) > 0 and a + d == pytest.approx(b + c, rel=1e-12)
    assert bears == 0 and min(others) > 0
