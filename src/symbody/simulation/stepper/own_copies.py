"""What the library's `copy` and `pickle` do with steppers, to whose numbers machine code points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NoReturn, Self

from symbody.errors import Problem, UsageError


class OwnCopies(ABC):
    """Motions that `copy.copy` and `copy.deepcopy` copy by their own method, and that are not pickled."""

    @abstractmethod
    def copy(self) -> Self:
        """Return another that goes on from here by itself."""

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Self:
        return self.copy()

    def __reduce__(self) -> NoReturn:
        kind = type(self).__name__
        raise UsageError(
            Problem("stepper.pickle", kind, f"a {kind} cannot be pickled",
            "it contains addresses of machine code",
                    "pass on the bytes of save(), and restore() them in one created with the same arguments")
        )  # fmt: skip
