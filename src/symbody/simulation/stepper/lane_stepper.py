"""`LaneStepper`: many motions of one mechanism that go on by one step together."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, SymbodyError, UsageError
from symbody.kernels import block as at
from symbody.kernels import stepping
from symbody.model.first_values import FirstValue
from symbody.simulation.events.events import Event, Occurrence
from symbody.simulation.inputs.input_laws import Law
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import CompiledSteps, Steps
from symbody.simulation.stepper.numbers import StepNumbers, missing_values, read_only, unknown_name
from symbody.simulation.stepper.saved_stepper import not_saved, other_kind
from symbody.simulation.stepper.side_by_side import LaneBlocks
from symbody.simulation.stepper.step_problem import StepperSettings
from symbody.simulation.stepper.stepper import OwnCopies, Stepper

Floats = NDArray[np.float64]

_MOST_NAMED: Final = 5  # lanes that broke off


class Lane(Stepper):
    """One of many steppers: its numbers lie in a row beside those of the others."""

    @property
    def numbers(self) -> StepNumbers:
        """Time, state and inputs."""
        return self._numbers

    @property
    def settings(self) -> StepperSettings:
        """What stays the same while it moves."""
        return self._settings

    @property
    def steps(self) -> Steps:
        """What takes its steps."""
        return self._steps

    def move_to(self, row: Floats) -> None:
        """Keep the numbers in a row from now on."""
        self._numbers.move_to(row)
        self._lay_out(self._numbers)
        self._steps.rebind()
        self.take_block()

    def take_block(self) -> None:
        """Step with the block that its steps have now."""
        self._go_on = self._steps.go_on

    def conclude(self, code: int) -> None:
        """Take note of how a step ended that was taken together with others.

        Raises SimulationError if the motion cannot go on.
        """
        if code == at.FINISHED:
            self._status = Status.SUCCESS
        else:
            self._end(code)


class LaneStepper(OwnCopies):
    """Motions of one mechanism, each in a lane, that advance by one step of `dt` at each call of `step`.

    It serves reinforcement learning, identification and Monte Carlo: steps of many motions by one call, where
    the compiled loop can take them several in each register of the processor. Each lane is what a `Stepper`
    with its values would be, bit for bit.

    Parameters
    ----------
    eqs : EquationSet
        The equations of motion, from `form_equations`.
    dt : float
        Length of each step [s].
    lanes : int
        How many motions there are, N.
    parameters, initial : mapping of name to number, formula, or N of them; first values also `Initial`
        As for `Stepper`, for all lanes or for each.
    inputs, integrator, constraints, events, guess, t, rtol, atol, scales, max_steps : optional
        As for `Stepper`. With events, Python functions, and where `notes` says so, lanes are stepped one
        after the other.

    Raises
    ------
    CompileError, FormulationError, UsageError, AssemblyError
        If names, values or tables make no sense, or initial values do not fit.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F"))
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], inputs=["F"]))
    >>> stepper = sb.LaneStepper(eqs, 0.1, lanes=3, initial={"x_dot": [0, 1, 2]})
    >>> stepper.step(F=[4.0, 0.0, -4.0])["x_dot"].round(9)
    array([0.2, 1. , 1.8])
    """

    _failed: dict[int, SymbodyError]  # of the last step

    @named_after(3)
    @checked_arguments
    def __init__(
        self, eqs: EquationSet, dt: float, lanes: int,
        parameters: Mapping[str, LaneValue] | None = None,
        initial: Mapping[str, FirstLaneValue] | None = None,
        inputs: Mapping[str, Law] | Iterable[str] | None = None, integrator: Integrator | None = None,
        constraints: Constraints | None = None, events: Event | Sequence[Event] = (), *,
        guess: Mapping[str, FirstValue] | None = None, t: float = 0.0, rtol: float = 1e-8,
        atol: float | None = None, scales: Mapping[str, float] | None = None, max_steps: int = 100_000,
    ) -> None:  # fmt: skip
        if isinstance(lanes, bool) or lanes < 1:
            raise UsageError(
                Problem("stepper.lanes", "lanes", f"lanes = {lanes!r} is not a number of motions", "",
                        "give 1 or more")
            )  # fmt: skip
        given = inputs if inputs is None or isinstance(inputs, Mapping | str) else list(inputs)
        each = zip(
            values_by_lane("parameters", parameters, lanes),
            values_by_lane("initial", initial, lanes),
            strict=True,
        )
        self._adopt([
            Lane(eqs, dt, own, initial=first, inputs=given, integrator=integrator, constraints=constraints,
                 events=events, guess=guess, t=t, rtol=rtol, atol=atol, scales=scales, max_steps=max_steps)
            for own, first in each
        ])  # fmt: skip

    def step(self, values: ArrayLike | None = None, /, **inputs: ArrayLike) -> Self:
        """Advance by `dt` in every lane; return this stepper.

        Parameters
        ----------
        values : (N, n_inputs) array, optional
            All inputs that steps give, in the order of `input_names`.
        **inputs : float or (N,) array
            Single ones, for all lanes or for each. Inputs keep their values for later steps.

        Raises
        ------
        UsageError
            If an input is unknown, has no value, or values that are not finite or do not fit the lanes, or a
            step leaves a table that must not be left; nothing has moved then.
        SimulationError, UsageError
            If motions cannot continue, or `simulate` rejects them. They stay at the time they reached; all
            others are at the end of the step.
        """
        if values is not None or inputs:
            for place, column in input_columns(values, inputs, self._places, len(self)):
                self._rows[:, place] = column
        self._check_inputs()
        if self._lanes[0].settings.bounded_tables:
            _raise_first(self._conclude(lambda _, lane: lane.steps.check()))
        blocks = self._blocks
        self._failed = (
            self._conclude(lambda _, lane: lane.step()) if blocks is None else self._step_together(blocks)
        )
        _raise_first(self._failed)
        return self

    def __len__(self) -> int:
        return len(self._lanes)

    @property
    def input_names(self) -> tuple[str, ...]:
        """The inputs that steps give."""
        return tuple(self._places)

    @property
    def dt(self) -> float:
        """Length of each step [s]."""
        return self._lanes[0].dt

    @property
    def t(self) -> Floats:
        """Time of each lane (N,) [s], a view that steps renew; it differs after `reset` of some."""
        return self._t

    @property
    def q(self) -> Floats:
        """The coordinates (N, n_q), a view that steps renew."""
        return self._q

    @property
    def u(self) -> Floats:
        """The speeds (N, n_u), a view that steps renew."""
        return self._u

    @property
    def x(self) -> Floats:
        """The states x = (u, q, s), (N, n_x), a view that steps renew."""
        return self._x

    @property
    def status(self) -> tuple[Status, ...]:
        """How the last step of each lane ended."""
        return tuple(lane.status for lane in self._lanes)

    @property
    def events(self) -> tuple[tuple[Occurrence, ...], ...]:
        """What happened in the last step of each lane."""
        return tuple(lane.events for lane in self._lanes)

    @property
    def parameters(self) -> tuple[dict[str, Value], ...]:
        """The values of parameters of each lane that differ from the model."""
        return tuple(lane.parameters for lane in self._lanes)

    @property
    def inputs(self) -> Floats:
        """The inputs that steps give (N, n_inputs); NaN where none was given yet."""
        values: Floats = self._rows[:, list(self._places.values())]
        return values

    @property
    def notes(self) -> tuple[str, ...]:
        """What the reader should know, also why lanes are stepped one after the other where they are."""
        alone = () if self._blocks is not None else ("lanes are stepped one after the other in Python",)
        return (*dict.fromkeys(note for lane in self._lanes for note in lane.notes), *alone)

    @checked_arguments
    def __getitem__(self, name: str) -> Floats:
        """Return a coordinate, a speed, a signal, or any output or expression at present, (N, ...)."""
        place = self._lanes[0].numbers.state_places.get(name)
        if place is not None:
            return self._rows[:, place].copy()
        return np.array([lane[name] for lane in self._lanes])

    def _ipython_key_completions_(self) -> list[str]:
        """Return what notebooks offer behind ``stepper["``: all outputs by their kinds."""
        return self._lanes[0]._ipython_key_completions_()

    def lane(self, number: int) -> Stepper:
        """Return a stepper that continues from the present state of one lane independently."""
        return self._lanes[chosen_lane(number, len(self))].copy()

    def set(self, only: ArrayLike | None = None, /, **values: LaneValue) -> Self:
        """Change values of parameters, or of inputs, in all lanes or in some; return this stepper.

        Parameters
        ----------
        only : int, sequence of int, or (N,) array of bool, optional
            The lanes to change.
        **values : number, formula, or one of them for each of these lanes
            See `Stepper.set`.
        """
        return self._change(only, values, Stepper.set)

    def reset(self, only: ArrayLike | None = None, /, **values: FirstLaneValue) -> Self:
        """Go back to the start in all lanes or in some, there with other initial values; see `set`.

        Parameters keep their values, inputs lose theirs.
        """
        return self._change(only, values, Stepper.reset)

    def copy(self) -> Self:
        """Return a stepper that continues from here independently; compiled functions are shared."""
        other = object.__new__(type(self))
        copies = [lane.copy() for lane in self._lanes]
        other._adopt([copy for copy in copies if isinstance(copy, Lane)])
        return other

    def save(self) -> bytes:
        """Return all that further steps depend on, bit for bit; see `restore`."""
        return join_saved([lane.save() for lane in self._lanes])

    @checked_arguments
    def restore(self, saved: bytes) -> Self:
        """Continue from what `save` returned, here or in another process; return this stepper.

        Raises
        ------
        UsageError
            If the bytes are damaged, or come from other equations, settings or another number of lanes;
            nothing has changed then.
        """
        parts = split_saved(saved, len(self))
        with self._unless_it_fails(range(len(self))) as lanes:
            for lane, part in zip(lanes, parts, strict=True):
                lane.restore(part)
        return self

    def __repr__(self) -> str:
        t = self._t
        return f"LaneStepper({len(self)} lanes, dt={self.dt:g}): t = {t.min():.9g} to {t.max():.9g} s"

    @property
    def _places(self) -> Mapping[str, int]:
        return self._lanes[0].numbers.places

    def _adopt(self, lanes: Sequence[Lane]) -> None:
        """Step these from now on."""
        self._lanes = tuple(lanes)
        self._rows: Floats = np.stack([lane.numbers.array for lane in lanes])
        for lane, row in zip(lanes, self._rows, strict=True):
            lane.move_to(row)
        n_u, n = lanes[0].u.size, lanes[0].u.size + lanes[0].q.size + lanes[0].s.size
        states = self._rows[:, stepping.STATE_AT :]
        self._t, self._x = read_only(self._rows[:, stepping.NOW]), read_only(states[:, :n])
        self._u, self._q = self._x[:, :n_u], self._x[:, n_u : n_u + lanes[0].q.size]
        self._failed = {}
        self._blocks: LaneBlocks | None = None
        self._settle(range(len(lanes)))

    def _settle(self, places: Iterable[int]) -> None:
        """Put the blocks of lanes that have new ones beside those of the others."""
        self._has_all_inputs = False
        compiled = [steps for lane in self._lanes if (steps := _loop_steps(lane)) is not None]
        codes = {steps.code for steps in compiled}  # what is exactly 0 in some lanes stands in their code
        if len(compiled) < len(self._lanes) or not self._x.shape[1] or len(codes) > 1:
            self._blocks = None
            for lane in self._lanes:
                lane.take_block()
            return
        blocks = self._blocks
        if (
            blocks is None
            or blocks.code not in codes
            or not all([blocks.take(place, compiled[place]) for place in places])
        ):
            self._blocks = LaneBlocks(compiled, self._rows, self._lanes[0].settings.method.tableau)
        for lane in self._lanes:
            lane.take_block()
        self._seen_until = min(steps.window_end for steps in compiled)
        self._reads_time = any(steps.reads_time for steps in compiled)

    def _check_inputs(self) -> None:
        """Check that all inputs have values; raises UsageError if one has none in some lane."""
        if self._has_all_inputs:
            return
        missing = [name for name, place in self._places.items() if np.isnan(self._rows[:, place]).any()]
        if missing:
            raise missing_values(missing)
        self._has_all_inputs = True

    def _step_together(self, blocks: LaneBlocks) -> dict[int, SymbodyError]:
        """Take a step in all lanes at once; return what is wrong with those that broke off."""
        if self._reads_time and self._t.max() + 1.5 * self.dt > self._seen_until:
            blocks = self._look_ahead(blocks)
        if blocks.step() and not self._failed:
            return {}
        codes = blocks.codes
        return self._conclude(lambda place, lane: lane.conclude(codes[place]))

    def _look_ahead(self, blocks: LaneBlocks) -> LaneBlocks:
        """Look at what depends on time alone for further steps; return the blocks that have seen it."""
        moved = []
        for place, lane in enumerate(self._lanes):
            steps = _loop_steps(lane)
            if steps is not None:
                before = steps.block
                steps.look_ahead()
                moved += [place] if steps.block is not before else []
        self._settle(moved)
        self._has_all_inputs = True
        return self._blocks or blocks

    def _conclude(self, end: Callable[[int, Lane], object]) -> dict[int, SymbodyError]:
        """End the step of each lane; return what is wrong with those that broke off."""
        failed: dict[int, SymbodyError] = {}
        for place, lane in enumerate(self._lanes):
            try:
                end(place, lane)
            except (SimulationError, UsageError) as error:
                failed[place] = in_lane(place, error)
        return failed

    def _change(self, only: ArrayLike | None, values: Mapping[str, Any], call: Callable[..., object]) -> Self:
        places = chosen_lanes(only, len(self))
        each = values_by_lane("values", values, len(places))
        with self._unless_it_fails(places) as lanes:
            for lane, own in zip(lanes, each, strict=True):
                call(lane, **own)
        return self

    @contextmanager
    def _unless_it_fails(self, places: Sequence[int]) -> Iterator[list[Lane]]:
        """Give the lanes meant; they stay what they were if what follows raises."""
        lanes = [self._lanes[place] for place in places]
        before = [lane.save() for lane in lanes]
        try:
            yield lanes
        except BaseException:
            for lane, saved in zip(lanes, before, strict=True):
                lane.restore(saved)
            raise
        finally:
            self._settle(places)


def _loop_steps(lane: Lane) -> CompiledSteps | None:
    """Return what takes the steps of a lane, if the compiled loop does so without Python."""
    steps = lane.steps
    return steps if type(steps) is CompiledSteps and not steps.calls_python else None


def _raise_first(failed: Mapping[int, SymbodyError]) -> None:
    """Raise what is wrong with the first lanes, if anything is.

    Raises SymbodyError of the kind of the first one.
    """
    errors = list(failed.values())[:_MOST_NAMED]
    if errors:
        raise type(errors[0])(*(error.problems[0] for error in errors))


LaneValue = Value | Sequence[Value] | NDArray[np.float64]
FirstLaneValue = LaneValue | FirstValue | Sequence[FirstValue]

_FORMAT: Final = b"symbody lanes 1\n"
_SIZE: Final = 8  # bytes that say how long the next part is


def values_by_lane(what: str, values: Mapping[str, Any] | None, lanes: int) -> list[dict[str, Any]]:
    """Return the values of each lane; raises UsageError if there are neither one nor as many as lanes."""
    by_lane: list[dict[str, Any]] = [{} for _ in range(lanes)]
    if values is not None and not isinstance(values, Mapping):
        values = dict.fromkeys(("",), values)  # refused with the words of a single stepper
    for name, value in (values or {}).items():
        is_each = isinstance(value, list | tuple | np.ndarray) and np.ndim(value) > 0
        each = list(value) if is_each else [value] * lanes
        if len(each) != lanes:
            raise _wrong_count(f"{what}: {name}", f"{len(each)} values", lanes)
        for own, single in zip(by_lane, each, strict=True):
            own[name] = float(single) if isinstance(single, np.number) else single
    return by_lane


def input_columns(
    values: ArrayLike | None, named: Mapping[str, ArrayLike], places: Mapping[str, int], lanes: int
) -> list[tuple[int, Floats]]:
    """Return inputs by their places among the numbers, each (N,) or one for all.

    Raises UsageError with every name that is unknown, and every value that is no finite number or does not
    fit the lanes.
    """
    problems, columns = [], []
    if values is not None:
        table = _numbers("step", values, ((lanes, len(places)),))
        columns += list(zip(places.values(), table.T, strict=True))
    for name, value in named.items():
        if name not in places:
            problems.append(
                unknown_name("input", name, places, "step() accepts inputs without a formula only")
            )
            continue
        columns.append((places[name], _numbers(name, value, ((lanes,), ()))))
    if problems:
        raise UsageError(*problems)
    return columns


def in_lane(place: int, error: SymbodyError) -> SymbodyError:
    """Return the first problem of an error as one of a lane."""
    first = error.problems[0]
    return type(error)(replace(first, where=f"lane {place}, {first.where}"))


def chosen_lanes(only: ArrayLike | None, lanes: int) -> tuple[int, ...]:
    """Return the lanes that a caller means; raises UsageError if these are no lanes."""
    if only is None:
        return tuple(range(lanes))
    try:
        array = np.atleast_1d(np.asarray(only))
    except ValueError:  # lists of several lengths
        raise _no_lanes(only, lanes) from None
    if array.dtype == np.bool_ and array.shape == (lanes,):
        return tuple(np.flatnonzero(array).tolist())
    is_fit = array.ndim == 1 and (array.dtype.kind in "iu" or not array.size)
    if not is_fit or (array < -lanes).any() or (array >= lanes).any():
        raise _no_lanes(only, lanes)
    return tuple(dict.fromkeys(int(place) % lanes for place in array))


def chosen_lane(number: ArrayLike, lanes: int) -> int:
    """Return the one lane that a caller means; raises UsageError if this is no lane, or several."""
    if not isinstance(number, int | np.integer):
        raise UsageError(
            Problem("stepper.lanes", "lanes", f"{number!r} is not a lane",
            f"there are {lanes} lanes, counted from 0",
                    f"give a number below {lanes}")
        )  # fmt: skip
    (place,) = chosen_lanes(number, lanes)
    return place


def join_saved(parts: Sequence[bytes]) -> bytes:
    """Return what single steppers have saved as one."""
    return _FORMAT + b"".join(len(part).to_bytes(_SIZE, "little") + part for part in parts)


def split_saved(saved: bytes, lanes: int) -> list[bytes]:
    """Return the parts that `join_saved` put together.

    Raises UsageError if the bytes are not whole, or those of another number of lanes.
    """
    if not saved.startswith(_FORMAT):
        raise not_saved("these bytes do not come from save() of this version")
    parts = list(_parts(saved[len(_FORMAT) :]))
    if len(parts) != lanes:
        raise other_kind()
    return parts


def _parts(content: bytes) -> Iterator[bytes]:
    while content:
        end = _SIZE + int.from_bytes(content[:_SIZE], "little")
        if len(content) < end:
            raise not_saved("the bytes were cut or changed")
        yield content[_SIZE:end]
        content = content[end:]


def _numbers(name: str, value: ArrayLike, shapes: Sequence[tuple[int, ...]]) -> Floats:
    """Return finite numbers in one of some shapes, the first of which has the lanes first."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.full(shapes[0], np.nan)
    if array.shape not in shapes:
        raise _wrong_count(name, f"an array of shape {array.shape}", shapes[0][0], shapes[0])
    if not np.isfinite(array).all():
        raise UsageError(
            Problem("stepper.input_value", name, f"{name} is not finite in every lane", "",
                    f"give finite numbers, as step({name}=values)")
        )  # fmt: skip
    return array


def _no_lanes(only: ArrayLike, lanes: int) -> UsageError:
    return UsageError(
        Problem("stepper.lanes", "lanes", f"{only!r} is not a choice of lanes",
        f"there are {lanes} lanes, counted from 0",
                f"give numbers below {lanes}, or an array of {lanes} times True or False")
    )  # fmt: skip


def _wrong_count(where: str, what: str, lanes: int, shape: tuple[int, ...] = ()) -> UsageError:
    fits = f"an array of shape {shape}" if len(shape) > 1 else f"one value, or {lanes}"
    return UsageError(
        Problem("stepper.lane_values", where, f"{lanes} lanes do not accept {what}", "", f"give {fits}")
    )
