"""`Cartesian`: three displacements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place
from symbody.model.door import Value
from symbody.model.joint import Joint, Turn
from symbody.model.joints.words import Trees, take
from symbody.model.loads.forces import Drive
from symbody.model.table import Table
from symbody.model.uses import Triple


@final
@dataclass(frozen=True, slots=True, init=False)
class Cartesian(Joint):
    """Slides in all directions, without turning.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects, whose axes stay parallel.
    coordinates : (3,) str, optional
        Names of the displacements along x, y and z of start [m]; without them ``<joint>_1`` to ``_3``.
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
        With everything that is not a name, a place, a coordinate or a formula.

    Examples
    --------
    >>> gantry = Cartesian("gantry", "ground", "Tool", coordinates=["x", "y", "z"])
    >>> [component.text for component in gantry.shift()]
    ['x', 'y', 'z']
    """

    suffixes: ClassVar[tuple[str, ...]] = ("_1", "_2", "_3")

    coordinates: tuple[str, ...]
    force: Table[Drive]
    motion: Table[Formula]
    as_constraint: bool

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
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
            coordinates=coordinates,
            force=force,
            motion=motion,
            as_constraint=as_constraint,
        )

    def turns(self) -> tuple[Turn, ...]:
        """Return no turn."""
        return ()

    def shift(self) -> Triple:
        """Return the displacements."""
        x, y, z = (Formula.of(name) for name in self.coordinates)
        return (x, y, z)
