"""`Weld`: no freedom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

from symbody.model.body import Place
from symbody.model.joint import ORIGIN, Joint, Turn
from symbody.model.joints.words import Trees, take
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Weld(Joint):
    """Holds two frames together.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames that coincide.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.

    Raises
    ------
    ModelError
        With everything that is not a name or a place.
    """

    suffixes: ClassVar[tuple[str, ...]] = ()

    def __init__(self, name: str, start: Place, end: Place, tree: Trees = None) -> None:
        take(self, name, start, end, tree)

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return zero."""
        return ORIGIN
