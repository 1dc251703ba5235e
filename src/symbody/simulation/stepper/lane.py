"""One lane of a `LaneStepper`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from symbody.kernels import block as at
from symbody.simulation.native.runge_kutta import Tableau
from symbody.simulation.status import Status
from symbody.simulation.stepper.compiled_steps import CompiledSteps
from symbody.simulation.stepper.stepper import Stepper

Floats = NDArray[np.float64]


class Lane(Stepper):
    """One of many steppers: its numbers lie in a row beside those of the others."""

    def move_to(self, row: Floats) -> None:
        """Keep the numbers in a row from now on."""
        self._numbers.move_to(row)
        missing = self._missing
        self._lay_out(self._numbers)
        self._missing = missing
        self._steps.rebind()
        self.take_block()

    @property
    def numbers(self) -> Floats:
        """Time, state and inputs."""
        return self._numbers.array

    @property
    def loop_steps(self) -> CompiledSteps | None:
        """What takes its steps, if the compiled loop does so without Python."""
        steps = self._steps
        return steps if type(steps) is CompiledSteps and not steps.calls_python else None

    @property
    def tableau(self) -> Tableau:
        """The method of the compiled loop."""
        return self._settings.method.tableau

    def take_block(self) -> None:
        """Step with the block that its steps have now."""
        self._go_on = self._steps.go_on

    @property
    def held_places(self) -> dict[str, int]:
        """Where the inputs that steps give stand among the numbers."""
        return self._places

    @property
    def state_places(self) -> dict[str, int]:
        """Where time and states stand among the numbers."""
        return self._state_places

    def begin(self) -> None:
        """Take note that all inputs have values."""
        self._missing.clear()

    @property
    def is_bounded(self) -> bool:
        """Whether steps may leave tables that must not be left."""
        return bool(self._settings.bounded_tables)

    def check(self) -> None:
        """Refuse a step that must not be taken, before anything moves.

        Raises
        ------
        UsageError
            See above.
        """
        self._steps.check()

    def conclude(self, code: int) -> None:
        """Take note of how a step ended that was taken together with others.

        Raises
        ------
        SimulationError
            If the motion cannot go on.
        """
        if code == at.FINISHED:
            self._status = Status.SUCCESS
        else:
            self._end(code)
