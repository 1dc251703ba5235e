"""`Sweep`: all motions of a sweep, with what varied, how each ended, and outputs that are not stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales
from symbody.arguments import checked_arguments
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import modal_equations, switches
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.kernels.block import Counts
from symbody.notebook import Displayed
from symbody.simulation.inputs.held_law import HeldLaw, HeldRecord
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.evaluate import count_turns, evaluate_samples, formula_of_samples
from symbody.simulation.results.provenance import Provenance, provenance_of
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.simulation_problem import VIOLATIONS, Evaluator
from symbody.simulation.status import Status
from symbody.simulation.sweeps.first_states import scales_of_cases
from symbody.simulation.sweeps.records import STATUSES, CaseDetails, Records
from symbody.simulation.sweeps.sweep_job import SweepJob
from symbody.single_flight import SingleFlight

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]

# Columns of `Records.counts`.
_COLUMNS = [Counts.layout[name] for name in ("accepted", "rejected", "evaluations", "samples")]
# Columns of `Sweep.counts`.
_ACCEPTED, _REJECTED, _EVALUATIONS, _SAMPLES = range(4)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Sweep(Displayed):
    """All motions of a sweep: arrays have the cases first and time last.

    Attributes
    ----------
    t : (N,) array
        Times of the samples [s].
    x : (cases, n, N) array
        States x = (u, q); NaN where a motion did not get that far.
    cases : mapping of name to (cases,) array
        What varied, in the order of the cases.
    status : tuple of Status
        How each motion ended.
    counts : (cases, k) array of int
        Steps accepted, steps rejected, evaluations, samples.
    reached : (cases,) array
        Time up to which each motion is known [s].
    case_notes : mapping of int to str
        Remarks on single cases, such as why they failed.
    notes : tuple of str
        Remarks on all of them.
    evaluation : CaseOutputs
        Computes outputs that are not stored.
    coordinate_names, speed_names : tuple of str
        Names of the last and the first of the states.
    units : mapping of name to str
        Units of what is known.
    name : str
        Of the model.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x_dot": 1}))
    >>> result = sb.sweep(eqs, 1.0, initial={"x_dot": [1, 2, 3]}, times=[0, 1])
    >>> result["x"].shape, result["x"][:, -1].round(9)
    ((3, 2), array([1., 2., 3.]))
    """

    t: Floats
    x: Floats
    cases: Mapping[str, Floats]
    status: tuple[Status, ...]
    counts: NDArray[np.int64]
    reached: Floats
    evaluation: CaseOutputs
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    case_notes: Mapping[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = ""

    def __len__(self) -> int:
        """How many cases there are."""
        return len(self.status)

    def __repr__(self) -> str:
        names = ", ".join(self.cases) or "nothing"
        return f"Sweep({self.name}): {self.succeeded.sum()} of {len(self)} cases succeeded, {names} varied"

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the rows of `x`: speeds, coordinates, states of signals."""
        return (*self.speed_names, *self.coordinate_names, *self.evaluation.eqs.signal_state_names)

    @property
    def succeeded(self) -> NDArray[np.bool_]:
        """Which motions reached their end, or an event that stops them (cases,)."""
        return np.array([status.success for status in self.status], dtype=np.bool_)

    @property
    def success(self) -> bool:
        """Whether all were."""
        return bool(self.succeeded.all())

    @checked_arguments
    def __getitem__(self, name: str) -> Floats:
        """Return what varied (cases,), or a state or any output (cases, N), (cases, 3, N) for a vector.

        Raises
        ------
        FormulationError
            If the name is neither an output nor an expression.
        """
        if name == "t":
            return self.t
        if name in self.state_names:
            row: Floats = self.x[:, self.state_names.index(name)]
            return row
        if name in self.cases and name not in {
            law.name for law in self.evaluation.job.laws.held_laws.values()
        }:
            return self.cases[name]
        formula = formula_of_samples(name, ())
        if formula is not None:
            return evaluate_samples(formula, self._samples, self.t, (len(self), self.t.size))
        return self.evaluation.evaluate(name)

    def _ipython_key_completions_(self) -> list[str]:
        """Return what notebooks offer behind ``sweep["``: what varied, then all outputs by their kinds."""
        return ["t", *self.cases, *(each.name for each in self.evaluation.eqs.listed_outputs)]

    def _samples(self, name: str) -> Floats:
        """Return a name over all cases and times; what varied is the same at all times."""
        values = self[name]
        return values[:, np.newaxis] if values.ndim == 1 else values

    @checked_arguments
    def trajectory(self, case: int) -> Trajectory:
        """Return the motion of one case.

        Raises
        ------
        UsageError
            If there is no such case.
        """
        count = len(self)
        if not -count <= case < count:
            what = f"there is no case {case}"
            raise UsageError(Problem("sweep.case", "trajectory", what, fix=f"cases are 0 to {count - 1}"))
        case %= count
        samples = int(self.counts[case, _SAMPLES])
        n_u = len(self.speed_names)
        n = n_u + len(self.coordinate_names)
        accepted, rejected, evaluations = self.counts[case, :3].tolist()
        values = ", ".join(f"{name} = {column[case]:g}" for name, column in self.cases.items())
        note, details = self.case_notes.get(case, ""), self.evaluation.details.get(case)
        t = self.t[:samples].copy()
        if samples and self.status[case] in (Status.STOPPED, Status.CHATTERING):
            # the sample behind the last time before an event that ends the motion is the state there
            ends_before = min if self.t[-1] >= self.t[0] else max
            t[-1] = ends_before(t[-1], self.reached[case])
        return Trajectory(
            t,
            self.x[case, n_u:n, :samples],
            self.x[case, :n_u, :samples],
            self.coordinate_names,
            self.speed_names,
            self.status[case],
            Statistics(accepted, rejected, evaluations, 0.0),
            self.evaluation.evaluator(case),
            units=self.units,
            notes=(f"case {case}: {values}", *((note,) if note else ()), *self.notes),
            name=self.name,
            provenance=self.evaluation.provenance(case),
            events=() if details is None else details.events(self.state_names),
            s=self.x[case, n:, :samples],
            signal_state_names=self.evaluation.eqs.signal_state_names,
            stored={} if details is None or details.work is None else {"work": details.work},
        )

    @checked_arguments
    def to_xarray(self, *names: str) -> xarray.Dataset:
        """Return an xarray data set: `x` over (case, state, time), further outputs, what varied, status.

        ``.to_netcdf("sweep.nc")`` and ``.to_zarr("sweep.zarr", consolidated=False)`` write it to files.

        Parameters
        ----------
        *names : str
            Outputs to compute and add, numbers or vectors.

        Raises
        ------
        EnvironmentFault
            If xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            what = "xarray is not installed"
            raise EnvironmentFault(
                Problem("sweep.xarray", "to_xarray", what, fix="pip install symbody[sweep]")
            ) from None
        variables: dict[str, object] = {"x": (("case", "state", "time"), self.x)}
        for name in names:
            values = self[name]
            inner = tuple(f"axis_{k}" for k in range(values.ndim - 2))
            variables[name] = (("case", *inner, "time"), values)
        variables["status"] = (("case",), np.array([status.name for status in self.status], dtype=object))
        variables["reached"] = (("case",), self.reached)
        variables["evaluations"] = (("case",), self.counts[:, _EVALUATIONS])
        coordinates: dict[str, object] = {
            "case": np.arange(len(self)),
            "state": np.array(self.state_names, dtype=object),
            "time": ("time", self.t, {"units": "s"}),
        }
        for name, column in self.cases.items():
            taken = name in variables or name in coordinates
            coordinates[f"{name} of case" if taken else name] = ("case", column)
        return xarray.Dataset(variables, coordinates, {"model": self.name, "notes": "\n".join(self.notes)})


def sweep_result(job: SweepJob, records: Records, notes: tuple[str, ...]) -> Sweep:
    """Return the motions of a sweep from the records of its cases."""
    eqs, x = job.eqs, np.moveaxis(records.x, 1, 2)
    case_notes = {case: details.notes for case, details in records.details.items() if details.notes}
    return Sweep(
        job.times,
        x,
        job.table.columns(),
        tuple(STATUSES[code] for code in records.codes.tolist()),
        records.counts[:, _COLUMNS],
        records.reached,
        CaseOutputs(job, records.details, x),
        eqs.coordinate_names,
        eqs.speed_names,
        dict(sorted(case_notes.items())),
        notes,
        eqs.units,
        eqs.model.name,
    )


Flags = NDArray[np.bool_]
Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class _HeldAlong:
    """Held values at samples of several cases: the record of each, and which samples are its own."""

    records: tuple[tuple[HeldRecord, slice], ...]

    def current(self, name: str) -> float:
        """Return the last value."""
        return self.records[-1][0].current(name)

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return a value at the times of the samples."""
        return np.concatenate([record.values_at(name, t[own]) for record, own in self.records])


@dataclass(frozen=True, slots=True, eq=False)
class CaseOutputs:
    """What computes the outputs of all cases of a sweep.

    Attributes
    ----------
    details : mapping of case to CaseDetails
        Of cases whose equations or held values changed on the way, among others.
    x : (cases, n, N) array
        The samples.
    """

    job: SweepJob
    details: Mapping[int, CaseDetails]
    x: Floats
    _scales: SingleFlight[None, Scales] = field(default_factory=SingleFlight, repr=False)

    @property
    def eqs(self) -> EquationSet:
        """The equations."""
        return self.job.eqs

    def _find_scales(self) -> Scales:
        places = enumerate(self.eqs.coordinate_names, len(self.eqs.speed_names))
        near = {name: np.nan_to_num(self.x[:, k, 0]) for k, name in places}
        job = self.job
        return scales_of_cases(self.eqs, job.table, near, job.motion.span, job.scales)

    def evaluator(self, case: int | Places, *, has_scales: bool = True) -> Evaluator:
        """Return what computes the outputs of one case, or of one for each of some samples, in order.

        Along all of them modes change or none, and values are held or none; see `_kind`.
        """
        numbers, starts = np.unique(np.atleast_1d(case), return_index=True)
        eqs, laws, own = self.eqs, self.job.laws, list[CaseDetails]()
        if any(self._kind(int(numbers[0])) if numbers.size else ()):
            own = [self.details[k] for k in numbers.tolist()]
        places = [slice(*ends) for ends in zip(starts, [*starts[1:], None], strict=True)]
        for kind in ("held", "modes"):
            records = [record for each in own if (record := getattr(each, kind)) is not None]
            if records:
                source = _HeldAlong(tuple(zip(records, places, strict=True)))
                names = [n for n in records[0].names if kind == "modes" or n in laws.callbacks]
                laws = laws.with_held({name: HeldLaw(source, name) for name in names})
                eqs = modal_equations(eqs).eqs if kind == "modes" else eqs
        problem = replace(self.job.motion.problem, eqs=eqs, laws=laws, p=self.job.table.parameters[case])
        if has_scales:
            problem = replace(problem, scales=self._scales.get(None, self._find_scales).of_motion(case))
        return Evaluator(problem, None)

    def _kind(self, case: int) -> tuple[bool, bool]:
        """Return whether modes changed along a case, and whether values were held."""
        details = self.details.get(case)
        return details is not None and details.modes is not None, bool(details and details.held)

    def evaluate(self, name: str) -> Floats:
        """Return an output with cases first and time last."""
        x, t, n_u = self.x, self.job.times, len(self.eqs.speed_names)
        is_known: Flags = np.asarray(np.isfinite(x).all(axis=1))
        if name == "work" and {*np.nonzero(is_known)[0].tolist()} <= {*self.details}:
            return self._work(is_known)
        groups: dict[tuple[bool, bool, int], list[int]] = {}
        is_counted = name in self.eqs.wrapped_angles  # from sample to sample of each case
        for case in np.flatnonzero(is_known.any(axis=1)).tolist():
            groups.setdefault((*self._kind(case), case if is_counted else -1), []).append(case)
        whole: Floats | None = None
        for cases in groups.values() or [[]]:
            own, sample = np.nonzero(is_known[cases])
            every = np.array(cases, dtype=np.intp)[own]
            rows, at = x[every, :, sample].T, t[sample]
            evaluate = self.evaluator(every, has_scales=name in VIOLATIONS)
            values = evaluate(name, at, rows[n_u:], rows[:n_u])
            if is_counted:
                values = count_turns(evaluate, name, values, at, rows[n_u:], rows[:n_u])
            whole = np.full((len(x), *values.shape[:-1], t.size), np.nan) if whole is None else whole
            np.moveaxis(whole, -1, 1)[every, sample] = np.moveaxis(values, -1, 0)
        assert whole is not None
        return whole

    def provenance(self, case: int) -> Provenance | None:
        """Return what one case was computed from."""
        held: HeldRecord | None = self.details[case].held if case in self.details else None
        values = self.job.table.values(case)[0]
        return provenance_of(self.eqs, values, self.job.laws, held=held, switches=switches(self.eqs.formed))

    def _work(self, known: Flags) -> Floats:
        whole: Floats = np.full(known.shape, np.nan)
        for case, details in self.details.items():
            if details.work is not None:
                whole[case, : details.work.size] = details.work
        return whole
