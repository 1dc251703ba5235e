"""`FmuInput`: the law of an input that an FMU computes from samples of the motion."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError, nearest


@checked_fields
@dataclass(frozen=True, slots=True)
class FmuInput:
    """The law of an input that an FMU computes from samples of the motion, held between them.

    At each sample the FMU is given what it `reads` and takes one step; what it then has as its `output` is
    the input until the next sample. This runs foreign code: use FMUs that you trust. Several inputs by one
    FMU, which differ in their `output` alone, share one instance.

    Parameters
    ----------
    path : str or path
        An FMU of FMI 2.0 or 3.0 for co-simulation.
    output : str
        The variable of the FMU that is the input.
    reads : mapping of str to str
        What variables of the FMU are set to at each sample: outputs and expressions, as in ``run[...]``. One
        that depends on the input itself sees its value before the sample.
    step : float
        Seconds between samples.
    parameters : mapping of str to float
        What variables of the FMU are set to before it is initialized.
    is_late : bool
        Whether an output acts only when the FMU's own time has reached it, one sample later; until then the
        input is what the FMU has after its initialization.

    Raises
    ------
    UsageError
        If there is no step, or it is not positive.

    Examples
    --------
    >>> import symbody as sb
    >>> law = sb.FmuInput("controller.fmu", "torque", reads={"angle": "phi"}, step=0.01)
    >>> law.period
    0.01
    """

    path: str | os.PathLike[str]
    output: str
    reads: Mapping[str, str] = field(default_factory=dict)
    step: float | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)
    is_late: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", os.fspath(self.path))
        object.__setattr__(self, "reads", dict(self.reads))
        object.__setattr__(self, "parameters", dict(self.parameters))
        if self.step is None or not (math.isfinite(self.step) and self.step > 0.0):
            given = "no step is given" if self.step is None else f"step = {self.step!r}"
            raise UsageError(
                Problem("fmu_input.step", f"FmuInput({self.path!r})", f"{given}",
                        "an FMU computes an input once per sample and holds it constant in between",
                        "give the seconds between samples: step=0.01")
            )  # fmt: skip

    @property
    def period(self) -> float:
        """Seconds between samples."""
        assert self.step is not None
        return self.step

    @property
    def instance(self) -> tuple[object, ...]:
        """What inputs that share one instance of the FMU have in common."""
        return (
            os.fspath(self.path), tuple(self.reads.items()), self.period, tuple(self.parameters.items()),
        )  # fmt: skip


def check_fmu_inputs(inputs: Mapping[str, object], names: Sequence[str]) -> None:
    """Refuse FMUs as laws of inputs that are not there; raises UsageError with a suggestion."""
    for name, law in inputs.items():
        if isinstance(law, FmuInput) and name not in names:
            raise UsageError(
                Problem("fmu_input.unknown", f"input {name}", f"the mechanism has no input {name!r}", "",
                        nearest(name, names))
            )  # fmt: skip


def refuse_fmu_inputs(inputs: Mapping[str, object]) -> None:
    """Refuse inputs by FMUs where a motion is not computed at once; raises UsageError naming them."""
    names = [name for name, law in inputs.items() if isinstance(law, FmuInput)]
    if names:
        raise UsageError(
            Problem("fmu_input.elsewhere", ", ".join(f"input {name}" for name in names),
                    "FMUs compute inputs in simulate, sweep and Stepper only",
                    "an FMU has its own state, which continues from sample to sample",
                    "call simulate for each case, or use a Stepper")
        )  # fmt: skip
