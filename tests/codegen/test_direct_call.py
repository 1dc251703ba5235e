"""Calls at a single point go straight into machine code: same bits, same refusals, nothing leaks."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.direct_call import available
from tests.problems.mechanisms import equations_of, random_values, state_of
from tests.tiers import cases

needs_direct = pytest.mark.skipif(not available(), reason="objects lie otherwise in memory here")
NAMES = ("spinning_top", "slider_crank")


def ready(name: str, *outputs: str) -> tuple[sb.CompiledFunction, list[np.ndarray]]:
    """A function that has been called so often that calls go straight into machine code, and a point."""
    eqs = equations_of(name)
    state = state_of(eqs, random_values(eqs, np.random.default_rng(2)))
    f = sb.compile(eqs, outputs[0] if len(outputs) == 1 else outputs)
    point = [state.q, state.u, state.r]
    for _ in range(50):
        f(0.0, *point)
    return f, point


@needs_direct
@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "outputs", [("udot",), ("mass_matrix",), ("energy",), ("energy", "udot", "mass_matrix")]
)
def test_direct_results_are_those_of_a_batch(name: str, outputs: tuple[str, ...]) -> None:
    f, point = ready(name, *outputs)
    assert f._at_point is not None and f._at_point(0.0, *point, ()) is not None
    found = f(0.0, *point)
    batch = f(0.0, *(np.stack([x, x]) for x in point))
    for one, many in zip(*([found], [batch]) if len(outputs) == 1 else (found, batch), strict=True):
        assert one.shape == many.shape[1:] and one.dtype == np.float64
        np.testing.assert_array_equal(one, many[0])
    if len(outputs) > 1:
        assert found._fields == outputs
        np.testing.assert_array_equal(found.energy, batch.energy[0])


@needs_direct
def test_what_is_no_point_of_floats_takes_the_long_way_to_the_same_result() -> None:
    f, (q, u, r) = ready("spinning_top", "udot")
    direct, expected = f._at_point, f(0.0, q, u, r)
    assert direct is not None
    spread = np.repeat(q, 2)[::2]
    unaligned = np.frombuffer(b"\0" + u.tobytes(), dtype=np.uint8)[1:].view(np.float64)
    swapped = q.astype(q.dtype.newbyteorder())
    assert not unaligned.flags.aligned
    for others in ((0, q, u, r), (0.0, list(q), u, r), (0.0, spread, u, r), (0.0, q, unaligned, r),
                   (0.0, swapped, u, r), (np.array(0.0), q, u, r), (0.0, q.view(np.matrix)[0].A1, u, r)):  # fmt: skip
        np.testing.assert_array_equal(f(*others), expected)
    for taken in (
        (0.0, list(q), u, r),
        (0.0, spread, u, r),
        (0.0, q, unaligned, r),
        (0.0, swapped, u, r),
        (1, q, u, r),
    ):
        assert direct(*taken, ()) is None
    assert direct(0.0, q) is None
    assert direct(np.float64(0.0), q, u, r, ()) is not None


@needs_direct
def test_wrong_lengths_and_types_are_refused_as_before() -> None:
    f, (q, u, r) = ready("spinning_top", "udot")
    for wrong in (q[:-1], np.append(q, 1.0), q + 0j, np.array("a"), None, ()):
        with pytest.raises(sb.SymbodyError):
            f(0.0, wrong, u, r)
    with pytest.raises(sb.SymbodyError):
        f(0.0, q, u, np.append(r, 1.0))


@needs_direct
def test_results_are_new_arrays_and_nothing_is_kept() -> None:
    f, point = ready("spinning_top", "udot")
    first = f(0.0, *point)
    kept = first.copy()
    counts = [sys.getrefcount(x) for x in point]
    others = [f(0.0, point[0] + k, *point[1:]) for k in range(100)]
    np.testing.assert_array_equal(first, kept)
    assert first.flags.owndata and first.flags.writeable
    assert [sys.getrefcount(x) for x in point] == counts
    assert sys.getrefcount(others[3]) == sys.getrefcount(kept) + 1  # the list holds it


@needs_direct
def test_time_is_passed() -> None:
    body = sb.Body("Body", mass=2)
    rail = sb.Prismatic("rail", "ground", "Body", coordinate="x", force=sb.Drive(applied="4*t"))
    f = sb.compile(sb.form_equations(sb.Model("pushed", [body, rail])), "udot")
    nothing = np.zeros(1)
    assert [float(f(t, nothing, nothing)[0]) for t in (0.0, 0.5, 1.5, np.float64(2.5))] == [
        0.0,
        1.0,
        3.0,
        5.0,
    ]


@needs_direct
def test_what_cannot_be_solved_is_told() -> None:
    f, (q, u, r) = ready("slider_crank", "udot")
    for _ in range(2):
        with pytest.raises(sb.SymbodyError) as caught:
            f(0.0, np.full_like(q, np.nan), u, r)
        assert caught.value.problems[0].code == "numerics.singular_mass"
    assert np.isfinite(f(0.0, q, u, r)).all()


@needs_direct
def test_threads_do_not_disturb_each_other() -> None:
    f, (q, u, r) = ready("slider_crank", "udot", "energy")
    expected = [f(0.0, q + 1e-3 * k, u, r) for k in range(200)]
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda k: f(0.0, q + 1e-3 * (k % 200), u, r), range(2000)))
    for k, values in enumerate(found):
        np.testing.assert_array_equal(values.udot, expected[k % 200].udot)
        assert values.energy == expected[k % 200].energy


@pytest.fixture
def often_switched() -> Iterator[None]:
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)  # threads take turns wherever the lock is released
    yield
    sys.setswitchinterval(interval)


def pushed(*outputs: str) -> sb.CompiledFunction:
    """A function of x, and of m and f as free parameters."""
    body = sb.Body("Body", mass="m")
    rail = sb.Prismatic("rail", "ground", "Body", coordinate="x", force=sb.Drive(applied="f"))
    eqs = sb.form_equations(sb.Model("pushed", [body, rail], parameters={"m": 2, "f": 1}))
    return sb.compile(eqs, outputs, free=["m", "f"])


@needs_direct
@pytest.mark.usefixtures("often_switched")
@pytest.mark.parametrize("count", cases([501, 1000], fast=[501]))
def test_threads_with_parameters_of_their_own_get_their_own_results(count: int) -> None:
    # NumPy lets other threads run while it copies more than 500 numbers, which is how results up to 1,000 are
    # made: 4 of 100 calls gave results of another thread's parameters.
    f = pushed(*(f"{k}*f" for k in range(1, count + 1)))
    x, multiples = np.zeros(1), np.arange(1.0, count + 1.0)
    for _ in range(30):
        f(0.0, x, x, (), np.array([2.0, 1.0]))

    def wrong(force: int) -> int:
        p = np.array([2.0, force])
        found = [np.array(f(0.0, x, x, (), p)) for _ in range(100)]
        return sum(not np.array_equal(values, force * multiples) for values in found)

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(wrong, range(1, 33))) == 0


@pytest.mark.parametrize("calls", [1, 50])
def test_parameters_may_be_a_column_or_of_another_byte_order(calls: int) -> None:
    f, x = pushed("udot", "f + x"), np.zeros(1)
    table = np.array([[2.0, 40.0], [6.0, 50.0]])
    for p in (table[:, 0], np.array([2.0, 6.0]).astype(">f8"), np.array([2.0, 6.0]).astype("<f8")):
        for _ in range(calls):
            found = f(0.0, x, x, (), p)
            assert (found.udot[0], found[1]) == (3.0, 6.0)  # f/m, f + x
        np.testing.assert_array_equal(f.constants(p), f.constants([2.0, 6.0]))
        assert f.bind(p)(0.0, x, x).udot[0] == 3.0
