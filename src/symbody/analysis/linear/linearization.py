"""`Linearization`: linear equations of small deviations, with names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.linear.modes import Modes, Spectrum, spectrum
from symbody.analysis.state import State
from symbody.arguments import checked_arguments
from symbody.errors import AssemblyError, EnvironmentFault, Problem, number_in_words
from symbody.notebook import Displayed
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]


class LinearMatrices(NamedTuple):
    """The matrices of ``x' = A x + B r``, ``y = C x + D r``."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Linearization(Displayed):
    """``x' = A x + B r``, ``y = C x + D r`` for deviations from a motion; unpacks as A, B, C, D.

    Attributes
    ----------
    A, B, C, D : arrays
        (n, n), (n, n_r), (n_y, n), (n_y, n_r); x are independent speeds, then independent
        coordinates, then the states of signals.
    state_names, input_names, output_names : tuple of str
        Names of the quantities that x, r, y are deviations of. The rotation vector of a quaternion's joint
        from its attitude in that motion is ``<joint>_rx, _ry, _rz`` [rad], in its end axes there, which turn
        with it.
    affine : (n,) array
        Rates of the states in that motion itself; 0 at an equilibrium or in a stationary motion.
    is_stationary : bool
        Whether that motion is stationary, up to rounding.
    at : State
        The state.
    notes : tuple of str
        Choices that were made, and limits of the result.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(stiffness=8))
    >>> linear = sb.linearize(sb.form_equations(sb.Model("oscillator", [rail])))
    >>> linear.state_names, linear.A.tolist()
    (('x_dot', 'x'), [[0.0, -4.0], [1.0, 0.0]])
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    state_names: tuple[str, ...]
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    affine: Floats
    is_stationary: bool
    at: State = field(repr=False)
    notes: tuple[str, ...] = ()
    # Names of everything that follows from x, and how; speeds among the states; error of A in eps.
    _recovered: tuple[str, ...] = field(default=(), repr=False)
    _recovery: Floats = field(default_factory=lambda: np.zeros((0, 0)), repr=False)
    _speeds: int = field(default=0, repr=False)
    _noise: float = field(default=1.0, repr=False)
    # Made on first request, a pure function of A.
    _spectrum: SingleFlight[None, Spectrum] = field(default_factory=SingleFlight, repr=False)

    def __repr__(self) -> str:
        counts = (self.state_names, "state"), (self.input_names, "input"), (self.output_names, "output")
        sizes = ", ".join(number_in_words(len(names), word) for names, word in counts)
        return (
            f"Linearization of {self.at.eqs.model.name!r} at t = {self.at.t:.6g} s: {self.verdict}, {sizes}"
        )

    def __str__(self) -> str:
        """Return what `repr` returns with a table of the modes."""
        return f"{self!r}\n{self.modes}"

    def __iter__(self) -> Iterator[Floats]:
        """Return A, B, C, D one after the other."""
        return iter(self.state_space)

    @property
    def state_space(self) -> LinearMatrices:
        """The matrices as a named tuple."""
        return LinearMatrices(self.A, self.B, self.C, self.D)

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Eigenvalues of A [1/s], the fastest growing first."""
        return np.array([mode.eigenvalue for mode in self.modes], dtype=np.complex128)

    @property
    def modes(self) -> Modes:
        """Eigenvalues with frequency, damping ratio, time constant and shape, the fastest growing first."""
        return self._computed_spectrum.modes

    @property
    def verdict(self) -> str:
        """The verdict of the linear equations on small deviations.

        "stable": all die out. "unstable": some grow. "drifting": a coordinate can be displaced without being
        driven back. "marginal": some neither grow nor die out, and linear equations alone do not show what
        the full ones do.
        """
        return self._computed_spectrum.verdict

    @property
    def _computed_spectrum(self) -> Spectrum:
        coordinates = len(self.state_names) - self._speeds
        return self._spectrum.get(None, lambda: spectrum(self.A, self.state_names, coordinates, self._noise))

    @checked_arguments
    def recover(self, deviations: Mapping[str, float] | ArrayLike) -> dict[str, Floats]:
        """Return the deviations of all speeds, coordinates and signals, dependent ones too, by name.

        Parameters
        ----------
        deviations : mapping of name to float, or (n, ...) array
            Of the states; those not named are 0. Cyclic coordinates keep their values at the state.

        Raises
        ------
        AssemblyError
            If a name is not a state, or the length is wrong.
        """
        names = self.state_names
        if isinstance(deviations, Mapping):
            unknown = [name for name in deviations if name not in names]
            x = np.array([deviations.get(name, 0.0) for name in names])
        else:
            x = np.asarray(deviations, dtype=float)
            unknown = [] if x.shape[:1] == (len(names),) else [f"shape {x.shape}"]
        if unknown:
            raise AssemblyError(
                Problem("linearize.deviations", ", ".join(unknown), "these are not deviations of the states",
                        "", f"the states are {', '.join(names)}")
            )  # fmt: skip
        recovered = np.tensordot(self._recovery, x, axes=1)
        return dict(zip(self._recovered, recovered, strict=True))

    def to_control(self) -> Any:
        """Return a ``control.StateSpace`` of the package python-control, with all names.

        Without outputs the states are the outputs. The affine term is not part of it.

        Raises
        ------
        EnvironmentFault
            If python-control is not installed.
        """
        try:
            control = import_module("control")
        except ModuleNotFoundError as error:
            raise EnvironmentFault(
                Problem("linearize.no_control", "to_control", "the package control is not installed",
                        str(error), "pip install symbody[control]")
            ) from error  # fmt: skip
        C, D, outputs = self.C, self.D, self.output_names
        if not outputs:
            C, D = np.eye(len(self.A)), np.zeros((len(self.A), self.B.shape[1]))
            outputs = self.state_names
        return control.ss(
            self.A, self.B, C, D,
            states=list(self.state_names), inputs=list(self.input_names), outputs=list(outputs),
        )  # fmt: skip
