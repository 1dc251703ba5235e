"""`Trajectory`: a motion with its names, its verdict and whatever follows from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NoReturn, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.arguments import checked_arguments
from symbody.equations.outputs.output_table import OutputTable, output_table
from symbody.errors import Problem, UsageError, nearest
from symbody.model.model import Model
from symbody.model.output_arguments import make_scope
from symbody.model.output_names import (
    ACCELERATIONS,
    ENERGIES,
    INPUTS,
    MULTIPLIERS,
    POSITIONS,
    SIGNALS,
    SPEEDS,
    ListedOutput,
    is_multiplier,
    list_readable,
)
from symbody.simulation.events.events import ModeChange, Occurrence
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.archive import Path, motion_fields, not_ours, write_archive
from symbody.simulation.results.evaluate import (
    Evaluate,
    OutputEvaluator,
    count_turns,
    evaluate_samples,
    formula_of_samples,
)
from symbody.simulation.results.provenance import Provenance, record_of
from symbody.simulation.results.recomputation import Recomputation, provenance_for
from symbody.simulation.results.sample_table import SampleTable, offered_names, refuse_table_ending
from symbody.simulation.status import Status

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectory(SampleTable):
    """The samples of a motion; time is the last axis of every array.

    As in a mapping, ``in``, ``len``, iteration and ``dict(run)`` are over the names that are stored.

    Attributes
    ----------
    t : (N,) array
        Times [s]; of shape () in what `at` returns for a single time, where all others lack that axis too.
    q, u : (n_q, N), (n_u, N) arrays
        Coordinates and speeds.
    coordinate_names, speed_names : tuple of str
        The names of their rows.
    status : Status
        How the motion ended; ``status.value`` names what to try.
    statistics : Statistics
        What it cost.
    evaluate : callable, optional
        Computes outputs that are not stored, by name.
    dense_output : DenseOutput, optional
        States x = (u, q, s) between the samples.
    stored : mapping of name to array
        Further arrays with time last.
    units : mapping of name to str
        Units of what is known, such as ``run.units["effort j"]``; of frames, too, which no list holds.
    notes : tuple of str
        What the reader should know.
    name : str
        Of the model.
    events : tuple of Occurrence
        (name, t, state) of what happened, in order.
    provenance : Provenance, optional
        What it was computed from; see `model` and `parameters`.
    s : (n_s, N) array
        States of signals.
    signal_state_names : tuple of str
        The names of its rows.
    modes : tuple of ModeChange
        (t, name, mode) of joints that stick and slip, ropes and stops: the first of each, then the changes.
    mode_inputs : HeldRecord, optional
        The same as the equations read it: names of inputs, times and values, with the headings of contacts.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x_dot": 3}))
    >>> run = sb.simulate(eqs, 2.0)
    >>> run.success, run.speed_names, run.q.shape == (1, run.t.size)
    (True, ('x_dot',), True)
    >>> print(f"{run['x'][-1]:.6f} {run['0.5*2*x_dot^2'][0]:.6f} {run.at(1.0)['x']:.6f}")
    6.000000 9.000000 3.000000
    """

    t: Floats
    q: Floats
    u: Floats
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    status: Status
    statistics: Statistics
    evaluate: Evaluate | None = None
    dense_output: DenseOutput | None = None
    stored: Mapping[str, Floats] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    name: str = ""
    events: tuple[Occurrence, ...] = ()
    provenance: Provenance | None = None
    s: Floats = field(default_factory=lambda: np.zeros((0, 0)), kw_only=True)
    signal_state_names: tuple[str, ...] = field(default=(), kw_only=True)
    modes: tuple[ModeChange, ...] = field(default=(), kw_only=True)
    mode_inputs: HeldRecord | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        if not self.signal_state_names:
            object.__setattr__(self, "s", np.zeros((0, *self.t.shape)))
        rows = (
            ("q", self.q, self.coordinate_names),
            ("u", self.u, self.speed_names),
            ("s", self.s, self.signal_state_names),
        )
        for letter, array, names in rows:
            if array.shape != (len(names), *self.t.shape):
                raise ValueError(f"{letter} has shape {array.shape}, not {(len(names), *self.t.shape)}")
        for letter in ("t", "q", "u", "s"):
            object.__setattr__(self, letter, _read_only(getattr(self, letter)))
        kept = {name: _read_only(values) for name, values in self.stored.items()}
        object.__setattr__(self, "stored", kept)

    @property
    def success(self) -> bool:
        """Whether the motion reached its end, or an event that stops it."""
        return self.status.success

    @property
    def model(self) -> Model | None:
        """The mechanism that moves; None where it was not described, or by a file of an older version."""
        return None if self.provenance is None else self.provenance.model

    @property
    def parameters(self) -> dict[str, float]:
        """The value that every parameter of the model had; empty without a model."""
        return {} if self.provenance is None else self.provenance.parameters

    @property
    def held_values(self) -> HeldRecord | None:
        """The values that were held between samples, and when these were taken; None without any."""
        return None if self.provenance is None else self.provenance.held

    @property
    def names(self) -> tuple[str, ...]:
        """All names whose values are stored."""
        return ("t", *self.coordinate_names, *self.speed_names, *self.signal_state_names, *self.stored)

    def __getattr__(self, name: str) -> NoReturn:
        is_set = not name.startswith("_") and name not in type(self).__dataclass_fields__
        hint = f": run[{name!r}]" if is_set and name in self.units else ""
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}{hint}")

    @checked_arguments
    def __getitem__(self, name: str) -> Floats:
        """Return the samples of a coordinate, a speed or any output: (N,), or (3, N) for a vector.

        Raises
        ------
        UsageError
            An unknown name.
        """
        values = self._stored_values(name)
        if values is not None:
            return values
        formula = formula_of_samples(name, self.stored)
        if formula is not None:
            return evaluate_samples(formula, self.__getitem__, self.t, self.t.shape)
        if self.evaluate is None:
            raise self._unknown(name)
        samples = np.atleast_1d(self.t), *self.state_arrays()
        values = count_turns(self.evaluate, name, self.evaluate(name, *samples), *samples, self.dense_output)
        return values if self.t.ndim else values[..., 0][()]

    def _ipython_key_completions_(self) -> list[str]:
        """Return what notebooks offer behind ``run["``: what is stored, then all outputs by their kinds."""
        return offered_names(self.names, self.units, self.model if self.evaluate else None)

    @overload
    def outputs(self) -> OutputTable: ...
    @overload
    def outputs(self, name: str, /, *names: str) -> dict[str, Floats]: ...
    @checked_arguments
    def outputs(self, *names: str) -> OutputTable | dict[str, Floats]:
        """Return the samples of several outputs, computed by one function; without names, what there is.

        Parameters
        ----------
        *names : str
            Outputs, as in ``run[name]``.

        Returns
        -------
        dict of name to array, or OutputTable
            Without names a table of the outputs that can be read: names, shapes without the axis of time,
            units and what they are. It can be searched, and notebooks show it.

        Raises
        ------
        UsageError
            An unknown name.

        Examples
        --------
        >>> import symbody as sb
        >>> joint = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
        >>> eqs = sb.form_equations(sb.Model("cart", [joint], initial={"x_dot": 3}))
        >>> run = sb.simulate(eqs, 1.0, times=[0, 1])
        >>> run.outputs().search("joules kinetic").names, run.outputs().search("kinetic").names
        ((), ('kinetic_energy', 'energy'))
        >>> run.outputs("x", "kinetic_energy")
        {'x': array([0., 3.]), 'kinetic_energy': array([9., 9.])}
        """
        if not names:
            return self._output_table()
        values = {name: self._stored_values(name) for name in names}
        of_samples = {name for name in names if formula_of_samples(name, self.stored) is not None}
        missing = [name for name, array in values.items() if array is None and name not in of_samples]
        if len(missing) < 2 or not isinstance(self.evaluate, OutputEvaluator):
            return {name: self[name] for name in names}
        samples, evaluate = (np.atleast_1d(self.t), *self.state_arrays()), self.evaluate
        computed = zip(missing, evaluate.together(missing, *samples), strict=True)
        made = {
            name: count_turns(evaluate, name, array, *samples, self.dense_output) for name, array in computed
        }
        shaped = {name: array if self.t.ndim else array[..., 0][()] for name, array in made.items()}
        shaped |= {name: self[name] for name in of_samples}
        return {name: shaped[name] if array is None else array for name, array in values.items()}

    def _output_table(self) -> OutputTable:
        """Return what can be read: without a model, what is stored."""
        symbols = {
            POSITIONS: self.coordinate_names,
            SPEEDS: self.speed_names,
            SIGNALS: self.signal_state_names,
        }
        if self.model is None or self.evaluate is None:
            listed = [ListedOutput(name, title) for title, names in symbols.items() for name in names]
            listed += [ListedOutput(name, ENERGIES) for name in self.stored]
            return output_table(listed, make_scope((), (), {}), self.units, {})
        offered = offered_names((), self.units, self.model)
        known = {*self.coordinate_names, *self.speed_names, *self.signal_state_names}
        symbols[ACCELERATIONS] = tuple(
            name for name in offered if name.endswith("_ddot") and name not in known
        )
        symbols[INPUTS] = self.model.inputs
        sizes = {
            "n_u": len(self.speed_names),
            "n_q": len(self.coordinate_names),
            "n_r": len(self.model.inputs),
        }
        sizes |= {"n_s": len(self.signal_state_names), "n_x": len(self.u) + len(self.q) + len(self.s)}
        scope = self.model.output_scope
        multipliers = tuple(name for name in self.units if is_multiplier(name, scope.elements))
        symbols[MULTIPLIERS] = multipliers
        return output_table(list_readable(scope, symbols), scope, self.units, sizes)

    def _stored_values(self, name: str) -> Floats | None:
        if name == "t":
            return self.t
        for array, names in (
            (self.q, self.coordinate_names),
            (self.u, self.speed_names),
            (self.s, self.signal_state_names),
        ):
            if name in names:
                row: Floats = array[names.index(name)]
                return row
        if self.held_values is not None and name in self.held_values.names:
            return self.held_values.values_at(name, self.t)
        return self.stored.get(name)

    def state_arrays(self) -> tuple[Floats, Floats]:
        """Return q followed by s, as compiled functions take them, and u; time last."""
        positions = np.concatenate([self.q, self.s]) if self.signal_state_names else self.q
        return self._with_time(positions), self._with_time(self.u)

    def _with_time(self, array: Floats) -> Floats:
        return array if self.t.ndim else array[..., np.newaxis]

    def _unknown(self, name: str) -> UsageError:
        why = "this trajectory has stored names only; run.save(path, name) stores additional ones"
        what = f"the trajectory has no {name!r}"
        return UsageError(
            Problem("trajectory.unknown_name", repr(name), what, why, nearest(name, self.names))
        )

    @checked_arguments
    def at(self, t: ArrayLike) -> Trajectory:
        """Return the motion at other times, from the polynomial of each step.

        Its degree is 7 where the method's order is 8, and 4 where it is 5: the error between two samples has
        the order in the step, and about the size, of the error at the samples.

        Parameters
        ----------
        t : float or (M,) array
            Times within the motion [s]. For a float every array of the result lacks the time axis:
            ``run.at(0.5)["theta"]`` is a number.

        Raises
        ------
        UsageError
            Times outside the motion, or a motion computed without dense output.
        """
        times = np.asarray(t, dtype=np.float64)
        if times.ndim > 1:
            raise _time_fault("times have more than one axis", "give one time, or a list of times")
        if self.dense_output is None:
            raise _time_fault(
                "the motion between the samples was not stored", "pass the times to simulate(..., times=)"
            )
        x = self.dense_output(times)
        n_u = len(self.speed_names)
        n = n_u + len(self.coordinate_names)
        return replace(self, t=times, q=x[n_u:n], u=x[:n_u], s=x[n:], stored={})

    @property
    def energy(self) -> Floats:
        """Kinetic plus potential energy (N,) [J]."""
        return self["energy"]

    @property
    def work(self) -> Floats:
        """Work done since the start by everything that has no potential (N,) [J]."""
        stored = self.stored.get("work")  # a coordinate or a state of a signal may bear the same name
        return self["work"] if stored is None else stored

    @property
    def energy_drift(self) -> float:
        """Largest change of energy that no work accounts for [J]; it measures the integrator's error."""
        balance = np.ravel(self.energy - self.work)
        return float(np.max(np.abs(balance - balance[:1]), initial=0.0))

    @property
    def constraint_violation(self) -> Floats:
        """Largest violation of a position constraint (N,), lengths over the model's size."""
        return self["constraint_violation"]

    @property
    def velocity_violation(self) -> Floats:
        """Largest violation of a velocity constraint (N,), over the model's size times the largest speed."""
        return self["velocity_violation"]

    @checked_arguments
    def reaction(self, joint: str) -> Floats:
        """Return force [N] and moment [N m] of a joint on its end body (6, N), in the joint's start axes.

        Raises
        ------
        FormulationError
            If there is no such joint.
        """
        return self[f"reaction {joint}"]

    @checked_arguments
    def save(self, path: Path, *names: str) -> None:
        """Write the trajectory and its model to a file for `load`; outputs beside the states if named.

        Raises
        ------
        UsageError
            If the name ends as that of a table, such as ``.mat`` and ``.csv``, which other methods write.
        EnvironmentFault
            If the file cannot be written.
        """
        refuse_table_ending(path)
        stored = {**self.stored, **{name: self[name] for name in names if name not in self.names}}
        arrays = {"t": self.t, "q": self.q, "u": self.u}
        arrays |= {"s": self.s} if self.signal_state_names else {}
        arrays |= {f"stored_{k}": values for k, values in enumerate(stored.values())}
        if self.dense_output is not None:
            arrays |= {"breaks": self.dense_output.breaks, "pieces": self.dense_output.pieces}
        about: dict[str, Any] = {
            "coordinate_names": self.coordinate_names,
            "speed_names": self.speed_names,
            "signal_state_names": self.signal_state_names,
            "status": self.status.name,
            "statistics": asdict(self.statistics),
            "stored": list(stored),
            "units": dict(self.units),
            "notes": self.notes,
            "name": self.name,
            "events": [[name, t, dict(state)] for name, t, state in self.events],
        }
        if self.provenance is not None:
            about["model"], tables = record_of(self.provenance)
            arrays |= tables
        write_archive(path, arrays, about)

    @classmethod
    @checked_arguments
    def load(cls, path: Path, model: Model | None = None) -> Trajectory:
        """Read a trajectory that `save` wrote.

        Outputs that were not stored are computed by equations formed again from the model, when they are
        first read. Those that depend on an input whose law was a Python function are unknown, and so are
        forces where joints stuck, ropes were slack or stops closed.

        Parameters
        ----------
        model : Model, optional
            In place of the one in the file; files of older versions have none.

        Raises
        ------
        EnvironmentFault
            If the file cannot be opened.
        FormatError, ModelError
            If it is not a trajectory, or its model is not valid.
        UsageError
            If the motion is not one of `model`.
        """
        fields = motion_fields(path)
        try:
            run = cls(**fields)
        except ValueError as error:
            raise not_ours(path) from error
        return run if model is None and run.provenance is None else run.of_model(model)

    @checked_arguments
    def of_model(self, model: Model | None = None) -> Trajectory:
        """Return the same motion with outputs computed by equations that are formed again.

        Parameters
        ----------
        model : Model, optional
            The mechanism that moved; by default the one it has.

        Raises
        ------
        UsageError
            If the motion is not one of this model, or has none.
        """
        source = self.provenance
        if source is None:
            if model is None:
                raise _no_model()
            source = provenance_for(model, self.coordinate_names, self.speed_names)
        elif model is not None:
            source = replace(source, model=model)
        start = self.q[:, 0].tolist() if self.q.ndim == 2 and self.t.size else [0.0] * len(self.q)
        near = dict(zip(self.coordinate_names, start, strict=True))
        evaluate = Recomputation(source, self.coordinate_names, self.speed_names, near)
        return replace(self, evaluate=evaluate, provenance=source)

    def __repr__(self) -> str:
        span = f"t = {self.t.flat[0]:g} to {self.t.flat[-1]:g} s" if self.t.size else "none stored"
        name = f"{self.name!r}: " if self.name else ""
        counts = (self.t.size, "sample"), (len(self.q), "coordinate"), (len(self.u), "speed")
        samples, coordinates, speeds = (f"{n} {word}" if n == 1 else f"{n} {word}s" for n, word in counts)
        return f"<Trajectory {name}{samples} ({span}), {coordinates}, {speeds}, {self.status.name}>"

    def __str__(self) -> str:
        """Return what `repr` returns and the notes; of a motion that failed with what to try."""
        advice = [] if self.success else [f"  {self.status.value}"]
        return "\n".join([repr(self), *advice, *(f"  note: {note}" for note in self.notes)])


def _no_model() -> UsageError:
    return UsageError(
        Problem("trajectory.no_model", "run", "the motion does not contain its mechanism",
                "its file was written by an older version, or its equations were assembled by hand",
                "give model=, the model that it was computed from")
    )  # fmt: skip


def _time_fault(what: str, fix: str) -> UsageError:
    return UsageError(Problem("trajectory.at", "at", what, fix=fix))


def _read_only(array: Floats) -> Floats:
    """Return a view that refuses assignments: two names never share changes."""
    view = np.asarray(array).view()
    view.flags.writeable = False
    return view
