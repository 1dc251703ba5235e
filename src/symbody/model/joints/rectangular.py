"""`Rectangular`: two displacements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.directions import in_plane, letter_from
from symbody.model.joints.words import Reader, Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Rectangular(Joint):
    """Slides in a plane of the start frame, without turning.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose axes stay parallel.
    axis : str
        The normal, "x", "y" or "z" of start; the displacements are along the next two in cyclic order.
    coordinates : (2,) str, optional
        Names of the displacements [m]; without them ``<joint>_1`` and ``_2``.
    tree : bool, mapping or None
        Whether it is in the rotation and translation tree; None: automatic.
    force : mapping of coordinate to Drive, optional
        What acts along the displacements.
    motion : mapping of coordinate to number or formula, optional
        The displacements that are prescribed, in parameters and t [m].
    as_constraint : bool
        Whether prescribed motions become constraints instead of replacing the coordinates.

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.

    Examples
    --------
    >>> table = Rectangular("table", "ground", "Top", coordinates=["x", "y"])
    >>> [component.text for component in table.shift()]
    ['x', 'y', '0']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2")

    axis: str
    coordinates: tuple[str, ...]
    force: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str = "z",
        coordinates: Iterable[str] | None = None,
        tree: Trees = None,
        force: Mapping[str, Drive] | None = None,
        motion: Mapping[str, Value] | None = None,
        as_constraint: bool = False,
    ) -> None:
        take(
            self,
            name,
            start,
            end,
            tree,
            own=_OWN,
            axis=axis,
            coordinates=coordinates,
            force=force,
            motion=motion,
            as_constraint=as_constraint,
        )

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return the two displacements, in cyclic order after the normal."""
        first, second = (Formula.of(name) for name in self.coordinates)
        return in_plane(self.axis, first, second)


_OWN: Final[Mapping[str, Reader]] = MappingProxyType({"axis": letter_from})
