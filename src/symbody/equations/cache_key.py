"""The key under which results of equations are stored, and equations that are formed on first use.

The results of a model, a formulation and this package are the same in every process. Where a later result,
such as a sequence, is on the disk, the equations themselves are formed only for another output.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.util import find_spec
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.model.content import content_bytes
from symbody.model.model import Model
from symbody.single_flight import SingleFlight, once
from symbody.storage import folder, load_stored, store

# The folders and files whose code forms equations and sequences, and the version of SymPy, which changes
# them, too: a file, as `importlib.metadata` takes longer to load than all of this to be hashed.
_ROOMS: Final = ("expr", "spatial", "manifold", "kernels", "model", "graph", "equations")
_FILES: Final = ("arguments.py", "tolerances.py")
_VERSION: Final = ("sympy", "release.py")


@dataclass(frozen=True, slots=True)
class DeferredEquations:
    """Equations that are formed on first use."""

    form: Callable[[], EquationsOfMotion]
    _result: SingleFlight[None, EquationsOfMotion] = field(default_factory=SingleFlight, repr=False)

    @property
    def equations(self) -> EquationsOfMotion:
        """The equations; all threads get the same."""
        return self._result.get(None, self.form)

    @property
    def are_formed(self) -> bool:
        """Whether they have been used."""
        return self._result.peek(None) is not None


def identity(model: Model, *choices: object) -> bytes:
    """Return a hash of all that equations follow from; empty if it cannot be computed.

    It cannot if classes or functions of a user's own take part, and it is not if nothing is stored.
    """
    sources = _sources() if folder() is not None else b""
    content = content_bytes(model, choices) if sources else b""
    return sha256(sources + content).digest() if content else b""


def load_notes(equations: bytes) -> tuple[str, ...] | None:
    """Return the notes of equations that an earlier process formed without an error, else None."""
    found = load_stored(_key(equations)) if equations else None
    return None if found is None else tuple(json.loads(found))


def store_notes(equations: bytes, notes: tuple[str, ...]) -> None:
    """Keep the notes of equations for the next process."""
    if equations and load_stored(_key(equations)) is None:
        store(_key(equations), json.dumps(notes).encode())


def _key(equations: bytes) -> bytes:
    return b"notes\n" + equations


@once
def _sources() -> bytes:
    """Return a hash of the files whose code forms equations; empty if they cannot be read."""
    package = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    sympy = find_spec(_VERSION[0])
    if sympy is None or not sympy.origin:
        return b""
    digest = sha256(sys.version.encode())
    with open(os.path.join(os.path.dirname(sympy.origin), _VERSION[1]), "rb") as file:
        digest.update(file.read())
    for name in _FILES:
        path = os.path.join(package, name)
        if not os.path.isfile(path):
            return b""
        with open(path, "rb") as file:
            digest.update(sha256(file.read()).digest())
    count = 0
    for room in _ROOMS:
        for place, folders, files in os.walk(os.path.join(package, room)):
            folders.sort()
            for name in sorted(files):
                if name.endswith(".py"):
                    with open(os.path.join(place, name), "rb") as file:
                        digest.update(sha256(file.read()).digest())
                    count += 1
    return digest.digest() if count else b""
