"""Samples by name as tables: a mapping, pandas, xarray, CSV and MATLAB."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import PurePath
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.arguments import checked_arguments
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.model.model import Model
from symbody.model.output_names import (
    ACCELERATIONS,
    INPUTS,
    MULTIPLIERS,
    WRENCH,
    is_multiplier,
    list_readable,
)
from symbody.notebook import Displayed
from symbody.simulation.results.archive import Path, unwritable

if TYPE_CHECKING:
    import pandas
    import xarray

Floats = NDArray[np.float64]
ColumnNames = Literal["places", "outputs"]

_TABLES: Final[Mapping[str, str]] = {
    ".mat": "run.to_mat(path) writes MATLAB data",
    ".csv": "run.to_csv(path) writes a table",
    ".nc": "run.to_xarray().to_netcdf(path) writes NetCDF",
}
_LONGEST: Final = 63  # letters of a name in MATLAB


class SampleTable(Displayed):
    """Arrays by name over common times, of which tables are made."""

    __slots__ = ()

    t: Floats
    coordinate_names: tuple[str, ...]
    speed_names: tuple[str, ...]
    signal_state_names: tuple[str, ...]
    units: Mapping[str, str]
    notes: tuple[str, ...]
    name: str

    @property
    def names(self) -> tuple[str, ...]:
        """All names whose values are stored."""
        raise NotImplementedError

    def __getitem__(self, name: str) -> Floats:
        """Return the samples of an output."""
        raise NotImplementedError

    def __contains__(self, name: object) -> bool:
        """Whether values are stored under a name; many more outputs can be computed by it."""
        return name in self.names

    def __iter__(self) -> Iterator[str]:
        """Return the names one after the other."""
        return iter(self.names)

    def __len__(self) -> int:
        """How many names there are; ``run.t.size`` is the number of samples."""
        return len(self.names)

    def keys(self) -> tuple[str, ...]:
        """Return the names, as a mapping does."""
        return self.names

    def items(self) -> Iterator[tuple[str, Floats]]:
        """Return names with their samples, as a mapping does."""
        return ((name, self[name]) for name in self.names)

    @checked_arguments
    def columns(self, *outputs: str, names: ColumnNames = "places") -> dict[str, Floats]:
        """Return outputs as columns (N,); vectors are split into "name x", "name y", "name z".

        Parameters
        ----------
        *outputs : str
            By default all coordinates, speeds and states of signals.
        names : str
            ``"outputs"`` names the components of a reaction "reaction A Fx" to "reaction A Mz", as plots do;
            ``"places"``, the default until version 0.2, "reaction A [0]" to "reaction A [5]".
        """
        if names not in get_args(ColumnNames):
            fix = f"give {' or '.join(map(repr, get_args(ColumnNames)))}"
            what = f"names = {names!r} is not a valid choice"
            raise UsageError(Problem("trajectory.column_names", "names", what, fix=fix))
        chosen = outputs or (*self.coordinate_names, *self.speed_names, *self.signal_state_names)
        columns: dict[str, Floats] = {}
        for name in chosen:
            columns.update(_split_columns(name, np.atleast_1d(self._over_time(name)), names))
        return columns

    def _over_time(self, name: str) -> Floats:
        values = self[name]
        return values if np.ndim(self.t) else values[..., np.newaxis]

    @checked_arguments
    def to_pandas(self, *outputs: str, names: ColumnNames = "places") -> pandas.DataFrame:
        """Return `columns` as a pandas table indexed by t.

        Raises
        ------
        EnvironmentFault
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            what = "pandas is not installed"
            fix = "pip install symbody[pandas], or use run.columns()"
            raise EnvironmentFault(Problem("trajectory.pandas", "to_pandas", what, fix=fix)) from None
        index = pandas.Index(np.atleast_1d(self.t), name="t")
        return pandas.DataFrame(self.columns(*outputs, names=names), index=index)

    @checked_arguments
    def to_xarray(self, *outputs: str) -> xarray.Dataset:
        """Return an xarray data set over t, one variable an output, with units; vectors keep their axes.

        Components of reactions are ``wrench="Fx"`` .. ``"Mz"``, those of motions of frames ``xyz="x"`` ..
        ``"z"``.

        Parameters
        ----------
        *outputs : str
            By default all coordinates, speeds and states of signals.

        Raises
        ------
        EnvironmentFault
            If xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            what = "xarray is not installed"
            fix = "pip install symbody[sweep], or use run.columns()"
            raise EnvironmentFault(Problem("trajectory.xarray", "to_xarray", what, fix=fix)) from None
        variables: dict[str, object] = {}
        coordinates: dict[str, object] = {"t": ("t", np.atleast_1d(self.t), {"units": "s"})}
        for name in outputs or (*self.coordinate_names, *self.speed_names, *self.signal_state_names):
            values = self._over_time(name)
            axes = _axis_names(name, values.shape[:-1])
            variables[name] = ((*axes, "t"), values, {"units": self.units.get(name, "")})
            coordinates |= {axis: (axis, list(_COMPONENTS[axis])) for axis in axes if axis in _COMPONENTS}
        return xarray.Dataset(variables, coordinates, {"model": self.name, "notes": "\n".join(self.notes)})

    @checked_arguments
    def to_csv(self, path: Path, *outputs: str, names: ColumnNames = "places") -> None:
        """Write t and `columns` as comma separated text whose numbers read back exactly.

        Raises
        ------
        EnvironmentFault
            If the file cannot be written.
        """
        columns = {"t": np.atleast_1d(self.t), **self.columns(*outputs, names=names)}
        try:
            with open(path, "w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file)
                writer.writerow(columns)
                writer.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
        except OSError as error:
            raise unwritable(path, error) from error

    @checked_arguments
    def to_mat(self, path: Path, *outputs: str) -> None:
        """Write t and outputs as MATLAB data, a column a variable, for ``load`` of MATLAB and Octave.

        Letters that names in MATLAB cannot have become ``_``; the cell arrays ``names`` and ``units`` say
        what each of ``variables`` is.

        Parameters
        ----------
        *outputs : str
            By default all coordinates, speeds and states of signals.

        Raises
        ------
        EnvironmentFault
            If the file cannot be written.
        """
        columns = {"t": np.atleast_1d(self.t), **self.columns(*outputs, names="outputs")}
        variables = matlab_names(list(columns), taken=("names", "units", "variables"))
        about = {
            "names": _cells(list(columns)),
            "units": _cells(["s", *(self.units.get(name, "") for name in list(columns)[1:])]),
            "variables": _cells(variables),
        }
        data = {name: values[:, np.newaxis] for name, values in zip(variables, columns.values(), strict=True)}
        try:
            with open(path, "wb") as file:
                scipy.io.savemat(file, {**data, **about}, long_field_names=True)
        except OSError as error:
            raise unwritable(path, error) from error


# Axes of xarray data sets whose places have names.
_COMPONENTS: Final[Mapping[str, Sequence[str]]] = {"wrench": WRENCH, "xyz": ("x", "y", "z")}


def refuse_table_ending(path: Path) -> None:
    """Refuse to write a trajectory to a file whose name ends as that of a table.

    Raises UsageError with the method that writes such a table.
    """
    ending = PurePath(path).suffix.lower()
    if ending in _TABLES:
        what = f"the ending {ending} does not match the format of the file"
        why = "save writes an npz archive for load"
        fix = (
            f"{_TABLES[ending]}; to read it with Trajectory.load, name it for instance "
            f"{PurePath(path).stem}.npz"
        )
        raise UsageError(Problem("trajectory.ending", str(path), what, why, fix))


def _axis_names(name: str, sizes: Sequence[int]) -> list[str]:
    """Return a name for each axis of an output: by what it is, else by its size."""
    if name.startswith("reaction ") and sizes == (len(WRENCH),):
        return ["wrench"]
    is_spatial = name.startswith("frame ") and set(sizes) == {3}
    words = ["xyz" if is_spatial else f"axis of {size}" for size in sizes]
    ends = ["", "1"] if is_spatial else ["", ", second"]
    return [word + end for word, end in zip(words, ends, strict=False)]


def offered_names(stored: Iterable[str], units: Iterable[str], model: Model | None) -> list[str]:
    """Return what notebooks offer as names: what is stored, then all outputs of the model by their kinds.

    Parameters
    ----------
    units : iterable of str
        Names with a unit, accelerations and multipliers among them.
    """
    names = dict.fromkeys(stored)
    if model is not None:
        scope, listed = model.output_scope, [*units]
        accelerations = [name for name in listed if name.isidentifier() and name.endswith("_ddot")]
        multipliers = [name for name in listed if is_multiplier(name, scope.elements)]
        symbols = {ACCELERATIONS: accelerations, INPUTS: model.inputs, MULTIPLIERS: multipliers}
        names |= dict.fromkeys(each.name for each in list_readable(scope, symbols))
    return [*names]


def matlab_names(names: Sequence[str], taken: Sequence[str] = ()) -> list[str]:
    """Return names as MATLAB can have them, all different.

    >>> matlab_names(["x", "reaction A Fx", "reaction A_Fx", "_1"])
    ['x', 'reaction_A_Fx', 'reaction_A_Fx_2', 'v_1']
    """
    result: list[str] = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
        plain = (plain if plain[:1].isalpha() else f"v{plain}")[:_LONGEST]
        candidate, k = plain, 2
        while candidate in (*result, *taken):
            candidate, k = f"{plain[: _LONGEST - 4]}_{k}", k + 1
        result.append(candidate)
    return result


def _cells(texts: Sequence[str]) -> NDArray[np.object_]:
    return np.array([*texts, None], dtype=object)[:-1]


def _split_columns(name: str, values: Floats, names: ColumnNames) -> Iterator[tuple[str, Floats]]:
    """Yield one column after the other of an output with time last."""
    shape = values.shape[:-1]
    if names == "outputs" and name.startswith("reaction ") and shape == (len(WRENCH),):
        yield from ((f"{name} {word}", column) for word, column in zip(WRENCH, values, strict=True))
        return
    is_spatial = all(size == 3 for size in shape) or (name.startswith("slip ") and shape == (2,))
    letters = "xyz" if is_spatial else ""
    for place in product(*map(range, shape)):
        suffix = "".join(letters[k] for k in place) if letters else str(list(place))
        yield f"{name} {suffix}" if place else name, values[place]
