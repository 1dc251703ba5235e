"""A tree of frames: who stands in whom, and the rotation between any two along the tree.

Frames remember nothing. A `FrameTree` is a value made from a model and a choice of trees; another
choice makes another FrameTree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symbody.errors import FrameError, Problem, nearest
from symbody.expr.graph import Graph
from symbody.vectors.rotation import Matrix, Rotation, rotation_matrix

Path = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class FrameTree:
    """Orientation of every frame in its parent.

    Attributes
    ----------
    parents : mapping of frame to (parent, rotation from parent to frame)
        The root, "ground", is not a key.
    """

    graph: Graph
    parents: Mapping[str, tuple[str, Rotation]]
    # Results already formed; a pure function of the fields above, so it cannot go stale.
    _matrices: dict[tuple[str, str], Matrix] = field(default_factory=dict, compare=False, repr=False)

    def path(self, frame: str) -> Path:
        """Return the frames from `frame` to the root.

        Raises
        ------
        FrameError
            If the frame is unknown.
        """
        steps = [frame]
        while steps[-1] in self.parents:
            steps.append(self.parents[steps[-1]][0])
        if len(steps) == 1 and frame != "ground":
            known = ["ground", *self.parents]
            raise FrameError(
                Problem("frame.unknown", frame, f"there is no frame {frame!r}", "", nearest(frame, known))
            )
        return tuple(steps)

    def rotation(self, a: str, b: str) -> Rotation:
        """Return the rotation from frame `a` to frame `b` along the tree."""
        up_a, up_b = self.path(a), self.path(b)
        shared = set(up_b)
        turning = next(frame for frame in up_a if frame in shared)
        result = Rotation()
        for frame in up_a[: up_a.index(turning)]:
            result = result.then(self.parents[frame][1].inverse)
        for frame in reversed(up_b[: up_b.index(turning)]):
            result = result.then(self.parents[frame][1])
        return result

    def matrix(self, a: str, b: str) -> Matrix:
        """Return ``R_ab``: components in `b` to components in `a`."""
        found = self._matrices.get((a, b))
        if found is None:
            found = rotation_matrix(self.graph, self.rotation(a, b))
            self._matrices[(a, b)] = found
        return found

    def home(self, frame: str) -> str:
        """Return the frame nearest the root that has the same orientation by construction."""
        while frame in self.parents and not self.parents[frame][1].turns:
            frame = self.parents[frame][0]
        return frame

    def depth(self, frame: str) -> int:
        """Return how many frames lie between `frame` and the root."""
        return len(self.path(frame)) - 1
