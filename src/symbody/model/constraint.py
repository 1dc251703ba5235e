"""`ConstraintElement`: what every constraint besides the joints is."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from symbody.model.declarations.element_fields import Connection, element
from symbody.model.declarations.fields import Refusal
from symbody.model.element import Element


@element
class ConstraintElement(Element):
    """Equations that a motion fulfils beside those of the joints; each has a multiplier.

    Attributes
    ----------
    multiplier_unit : str
        Of its multipliers, "" where it depends on what users write.
    rows, holds, multiplier : str
        For the documentation: how many equations, what they say, and what a multiplier is.
    """

    kind: ClassVar[str] = "constraint"
    multiplier_unit: ClassVar[str] = ""
    rows: ClassVar[str]
    holds: ClassVar[str]
    multiplier: ClassVar[str]

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Coordinates that it brings with it."""
        return ()


@element
class FrameConstraint(ConstraintElement, Connection):
    """A condition between two frames: its multipliers are a wrench on end and its opposite on start."""

    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({"reaction": ("",)})
    on_one_body: ClassVar[Refusal | None] = Refusal(
        "model.self_constraint", what="both frames are on {value}", fix="name a frame of another body",
        why="frames of one body do not move relative to each other",
    )  # fmt: skip
