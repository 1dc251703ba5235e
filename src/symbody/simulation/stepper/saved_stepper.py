"""What `Stepper.save` returns: bytes that hold a stepper to the bit, and show whether they are whole.

Behind a line that names the format stands the hash of the rest: a line of JSON, then numbers of 8 bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.formation.names import Value
from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Occurrence
from symbody.simulation.motion_identity import missing_content, motion_digest
from symbody.simulation.status import Status
from symbody.simulation.stepper.step_problem import StepperSettings

Floats = NDArray[np.float64]

_FORMAT: Final = b"symbody stepper 3\n"
_DIGEST: Final = 32
_REAL: Final = np.dtype("<f8")


@dataclass(frozen=True, slots=True, eq=False)
class SavedStepper:
    """The content of saved bytes.

    Attributes
    ----------
    kind : str
        A hash of the settings; only steppers with the same take it up.
    parameters : mapping of name to number or formula
        Those that differ from the model.
    numbers, kept : arrays
        Those of the stepper, and those of its steps.
    """

    kind: str
    parameters: Mapping[str, Value]
    status: Status
    events: tuple[Occurrence, ...]
    numbers: Floats
    kept: Floats

    def to_bytes(self) -> bytes:
        """Return the content as bytes."""
        header = {
            "kind": self.kind,
            "parameters": saved_parameters(self.parameters),
            "status": self.status.name,
            "events": [[event.name, event.t, dict(event.state)] for event in self.events],
            "sizes": [self.numbers.size, self.kept.size],
        }
        values = np.concatenate([self.numbers, self.kept]).astype(_REAL)
        content = json.dumps(header).encode() + b"\n" + values.tobytes()
        return _FORMAT + sha256(content).digest() + content


def read_saved(saved: object) -> SavedStepper:
    """Return the content of saved bytes.

    Raises UsageError if these are not bytes that `Stepper.save` returned, or not all of them.
    """
    if not isinstance(saved, bytes):
        raise not_saved(f"{type(saved).__name__} is not what save() returns")
    if not saved.startswith(_FORMAT):
        raise not_saved("these bytes do not come from save() of this version")
    digest, content = saved[len(_FORMAT) :][:_DIGEST], saved[len(_FORMAT) + _DIGEST :]
    if sha256(content).digest() != digest:
        raise not_saved("the bytes were cut or changed")
    line, _, values = content.partition(b"\n")
    try:
        header, numbers = json.loads(line), np.frombuffer(values, dtype=_REAL).astype(np.float64)
        first, second = header["sizes"]
        parameters, status = dict(header["parameters"]), Status[header["status"]]
        are_plain = all(isinstance(value, str | int | float) for value in parameters.values())
        if numbers.size != first + second or not are_plain:
            raise ValueError
        events = tuple(
            Occurrence(str(name), float(t), {str(key): float(x) for key, x in state.items()})
            for name, t, state in header["events"]
        )
        return SavedStepper(str(header["kind"]), parameters, status, events, numbers[:first], numbers[first:])
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise not_saved("the bytes have a hash, but no content of a stepper") from error


def kind_of(settings: StepperSettings) -> str:
    """Return a hash of what stays the same while a stepper moves."""
    fixed = (
        settings.held, settings.integrator, settings.constraints, settings.events, settings.rtol,
        settings.atol, settings.scales, settings.max_steps, settings.fmus,
    )  # fmt: skip
    laws = {name: _law_content(law) for name, law in settings.laws.items()}
    return motion_digest(settings.eqs, laws, *fixed)


def _law_content(law: object) -> object:
    """Return a law, or its name and place where it has no content that could be compared."""
    if not missing_content(law):
        return law
    kind = type(law)
    return getattr(law, "__module__", kind.__module__), getattr(law, "__qualname__", kind.__qualname__)


def saved_parameters(parameters: Mapping[str, Value]) -> dict[str, Value]:
    """Return values of parameters as they are saved: numbers, and formulas as text."""
    return {
        name: value if isinstance(value, int | float) else str(value) for name, value in parameters.items()
    }


def other_kind() -> UsageError:
    """Return the refusal of what another kind of stepper has saved."""
    return UsageError(
        Problem("stepper.other_kind", "saved", "this was saved by a different stepper",
                "equations, inputs, events, tolerances and method have to be the same",
                "restore it in a stepper created with the same arguments")
    )  # fmt: skip


def not_saved(what: str) -> UsageError:
    """Return the refusal of bytes that are not what was saved."""
    return UsageError(
        Problem("stepper.not_saved", "saved", what, "incomplete data is not read",
                "give the bytes that save() returned")
    )  # fmt: skip
