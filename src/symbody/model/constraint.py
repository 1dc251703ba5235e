"""`Condition`: what every constraint beside the joints is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from symbody.model.element import Address, Element
from symbody.model.turn import Axis
from symbody.model.uses import Scope, Use, triple_uses


@dataclass(frozen=True, slots=True, init=False)
class Condition(Element):
    """Equations that a motion fulfils beside those of the joints; each has a multiplier.

    Attributes
    ----------
    multiplier_unit : str
        Of its multipliers, "" where it depends on what users write.
    """

    kind: ClassVar[str] = "constraint"
    multiplier_unit: ClassVar[str] = ""

    name: str

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Coordinates that it brings with it."""
        return ()


@dataclass(frozen=True, slots=True, init=False)
class Contact(Condition):
    """A condition between two frames: its multipliers are a wrench on end and its opposite on start.

    Attributes
    ----------
    start, end : Address
        The frames.
    """

    start: Address
    end: Address

    @property
    def directions(self) -> Mapping[str, Axis]:
        """Each direction it names, by place in the file."""
        return {}

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        for path, axis in self.directions.items():
            if not isinstance(axis, str):
                yield from triple_uses(path, axis, Scope.CONSTANT)
        yield from self.own_uses()

    def own_uses(self) -> Iterable[Use]:
        """Return where the formulas beside the directions stand."""
        return ()
