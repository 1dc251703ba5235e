"""A tree of frames, each in its parent, and the rotation between any two along the tree.

A `FrameTree` follows from a model and a choice of trees; another choice makes another FrameTree.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from symbody.errors import FrameError, Problem, nearest
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.spatial.matrix import Matrix3
from symbody.spatial.rotation import Rotation
from symbody.spatial.step_products import StepProducts, Word, backwards

Path = tuple[str, ...]
ROOT = "ground"


@dataclass(frozen=True, slots=True)
class FramePlace:
    """Where a frame stands.

    Attributes
    ----------
    parent : str
        The root is its own parent.
    depth : int
        Number of frames between this one and the root, the root included.
    orientation_frame : str
        Frame nearest the root that has the same orientation by construction.
    word : tuple of int
        Steps from the parent's axes.
    """

    parent: str
    depth: int
    orientation_frame: str
    word: Word


@dataclass(frozen=True, slots=True)
class FrameTree:
    """Orientation of every frame in its parent.

    Attributes
    ----------
    parents : mapping of frame to (parent, rotation from parent to frame)
        The root, "ground", is not a key. Frames may be added later, never changed.
    """

    graph: Graph
    parents: dict[str, tuple[str, Rotation]]
    # Results kept for the next call. Each follows from the entries of `parents` on its way to the
    # root, and those stay, so none can go stale.
    _places: dict[str, FramePlace] = field(default_factory=dict, init=False, compare=False, repr=False)
    _matrices: dict[tuple[str, str], Matrix3[Expr]] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )
    _products: StepProducts = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_products", StepProducts(self.graph))
        self._places[ROOT] = FramePlace(ROOT, 0, ROOT, ())

    def place(self, frame: str) -> FramePlace:
        """Return where a frame stands.

        Raises
        ------
        FrameError
            If the frame is unknown, or stands in itself by way of others.
        """
        place = self._places.get(frame)
        return self._enter(frame) if place is None else place

    def path(self, frame: str) -> Path:
        """Return the frames from `frame` to the root."""
        steps = [frame]
        for _ in range(self.depth(frame)):
            steps.append(self._places[steps[-1]].parent)
        return tuple(steps)

    def rotation(self, a: str, b: str) -> Rotation:
        """Return the rotation from frame `a` to frame `b` along the tree."""
        return self._products.rotation(self._word(a, b))

    def matrix(self, a: str, b: str) -> Matrix3[Expr]:
        """Return ``R_ab``: components in `b` to components in `a`."""
        matrix = self._matrices.get((a, b))
        if matrix is None:
            matrix = self._products.matrix(self._word(a, b))
            self._matrices[(a, b)] = matrix
            self._matrices[(b, a)] = matrix.T
        return matrix

    def is_parallel(self, a: str, b: str) -> bool:
        """Return whether several turns lead from frame `a` to frame `b`, all about parallel axes."""
        if len(self._word(a, b)) != 1:
            return False
        turning = 0
        while a != b:
            deeper = a if self.place(a).depth >= self.place(b).depth else b
            place = self._places[deeper]
            turning += len(place.word)
            a, b = (place.parent, b) if deeper == a else (a, place.parent)
        return turning > 1

    def orientation_frame(self, frame: str) -> str:
        """Return the frame nearest the root that has the same orientation by construction."""
        return self.place(frame).orientation_frame

    def depth(self, frame: str) -> int:
        """Return how many frames lie between `frame` and the root."""
        return self.place(frame).depth

    def _word(self, a: str, b: str) -> Word:
        """Return the steps from `a` to `b`, merged in the order from the frame nearer the root."""
        place_a, place_b = self.place(a), self.place(b)
        if (place_a.depth, a) > (place_b.depth, b):
            return backwards(self._word(b, a))
        up: list[int] = []
        down: list[Word] = []
        while a != b:
            if place_a.depth >= place_b.depth:
                up.extend(backwards(place_a.word))
                a = place_a.parent
                place_a = self._places[a]
            else:
                down.append(place_b.word)
                b = place_b.parent
                place_b = self._places[b]
        for word in reversed(down):
            up.extend(word)
        return self._products.merge_codes(up)

    def _enter(self, frame: str) -> FramePlace:
        """Enter the places of a frame and of all it stands in."""
        missing = [frame]
        while missing[-1] in self.parents and missing[-1] not in self._places:
            if len(missing) > len(self.parents):
                raise _circle(frame)
            missing.append(self.parents[missing[-1]][0])
        ancestor = missing.pop()
        if ancestor not in self._places:
            raise _unknown_frame(ancestor, frame, [ROOT, *self.parents])
        place = self._places[ancestor]
        for name in reversed(missing):
            parent, rotation = self.parents[name]
            word = self._products.merge_codes(self._products.word(rotation))
            place = FramePlace(parent, place.depth + 1, name if word else place.orientation_frame, word)
            self._places[name] = place
        return place


def _unknown_frame(name: str, frame: str, frames: list[str]) -> FrameError:
    why = "" if name == frame else f"frame {frame!r} is defined in it"
    return FrameError(
        Problem("frame.unknown", frame, f"there is no frame {name!r}", why, nearest(name, frames))
    )


def _circle(frame: str) -> FrameError:
    return FrameError(
        Problem("frame.circle", frame, f"frame {frame!r} never leads to {ROOT!r}",
                "the frames it is defined in form a cycle",
                "define one of them in 'ground', or in a frame that is connected to ground")
    )  # fmt: skip
