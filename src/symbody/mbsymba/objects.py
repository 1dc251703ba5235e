"""Frames, points, vectors, bodies, forces, constraints as scripts see them: values that print themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from symbody.equations.by_hand.mechanism import PlacedBody, PlacedConstraint, PlacedForce, PlacedTorque
from symbody.errors import FrameError, Problem
from symbody.expr.expression import Expr, common_graph
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.sympy.sympy_writer import SympyExpr, SympyMatrix, is_matrix
from symbody.mbsymba.workplace import WORKPLACE, to_expressions, to_sympy_expressions
from symbody.spatial.placed import PlacedFrame, PlacedPoint, PlacedVector, Shift, homogeneous
from symbody.spatial.rotation import DirectionCosines


def marks(values: Sequence[Expr]) -> tuple[tuple[int, int], ...]:
    """Return what equal expressions have in common, whatever their form."""
    graph, nodes = common_graph(values)
    signs = fingerprints(graph, list(graph.reachable(nodes)))
    return tuple(signs[node] for node in nodes)


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """Anything that prints itself as a table."""

    obj: ClassVar[str] = ""

    def lines(self) -> list[str]:
        """Return the table, line by line."""
        raise NotImplementedError

    def __str__(self) -> str:
        return "\n".join([self.obj, *(f"  {line}" for line in self.lines())])

    def __repr__(self) -> str:
        return str(self)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FRAME(Shown):
    """A frame: the 4 x 4 matrix that takes coordinates in it to coordinates in ground.

    ``F * G`` is G placed in F; ``F * column`` and ``F * POINT`` take coordinates in F to ground.
    """

    obj: ClassVar[str] = "FRAME"
    _op_priority: ClassVar[float] = 100.0

    placed: PlacedFrame

    @property
    def matrix(self) -> SympyMatrix:
        """The homogeneous matrix."""
        rows = homogeneous(self.placed, WORKPLACE.graph)
        return SympyMatrix(4, 4, to_sympy_expressions([entry for row in rows for entry in row]))

    def __mul__(self, other: FRAME | POINT | VECTOR | SympyMatrix) -> FRAME | POINT | VECTOR | SympyMatrix:
        if isinstance(other, FRAME):
            return FRAME(self.placed * other.placed)
        if isinstance(other, POINT):
            return POINT(PlacedPoint(PlacedFrame(), self.placed.place(other.placed.coordinates)))
        if isinstance(other, VECTOR):
            return VECTOR(PlacedVector(PlacedFrame(), self.placed.rotate(other.placed.components)))
        if is_matrix(other):
            return _times(self, other)
        return NotImplemented

    __matmul__ = __mul__

    def __rmul__(self, other: SympyMatrix) -> FRAME:
        return FRAME(frame_of_matrix(other) * self.placed) if is_matrix(other) else NotImplemented

    def __eq__(self, other: object) -> bool:
        return isinstance(other, FRAME) and marks(_entries(self)) == marks(_entries(other))

    def __hash__(self) -> int:
        return hash(marks(_entries(self)))

    def lines(self) -> list[str]:
        """Return the matrix, row by row."""
        return [str(row) for row in self.matrix.tolist()]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class POINT(Shown):
    """A point by its coordinates in a frame."""

    obj: ClassVar[str] = "POINT"

    placed: PlacedPoint

    @property
    def frame(self) -> FRAME:
        """The frame."""
        return FRAME(self.placed.frame)

    @property
    def coords(self) -> SympyMatrix:
        """The coordinates, then 1."""
        return SympyMatrix([*to_sympy_expressions(self.placed.coordinates), 1])

    def __sub__(self, other: POINT) -> VECTOR:
        there = self.placed.express_in(other.placed.frame).coordinates
        x, y, z = (a - b for a, b in zip(there, other.placed.coordinates, strict=True))
        return VECTOR(PlacedVector(other.placed.frame, (x, y, z)))

    def __add__(self, other: VECTOR) -> POINT:
        here = other.placed.express_in(self.placed.frame).components
        x, y, z = (a + b for a, b in zip(self.placed.coordinates, here, strict=True))
        return POINT(PlacedPoint(self.placed.frame, (x, y, z)))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, POINT) and marks(self.placed.position) == marks(other.placed.position)

    def __hash__(self) -> int:
        return hash(("POINT", marks(self.placed.position)))

    def lines(self) -> list[str]:
        """Return coordinates and frame."""
        return [f"coords = {list(self.coords)}", *_in_frame(self.frame)]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class VECTOR(Shown):
    """A vector by its components in a frame; ``+ - *`` and comparisons are those of vectors."""

    obj: ClassVar[str] = "VECTOR"
    _op_priority: ClassVar[float] = 100.0

    placed: PlacedVector

    @property
    def frame(self) -> FRAME:
        """The frame."""
        return FRAME(self.placed.frame)

    @property
    def comps(self) -> SympyMatrix:
        """The components, then 0."""
        return SympyMatrix([*to_sympy_expressions(self.placed.components), 0])

    def __add__(self, other: VECTOR) -> VECTOR:
        return VECTOR(self.placed + other.placed) if isinstance(other, VECTOR) else NotImplemented

    def __sub__(self, other: VECTOR) -> VECTOR:
        return self + -other

    def __neg__(self) -> VECTOR:
        return VECTOR(-self.placed)

    def __mul__(self, factor: SympyExpr | float) -> VECTOR:
        return VECTOR(self.placed * to_expressions([factor])[0])

    __rmul__ = __mul__

    def __truediv__(self, divisor: SympyExpr | float) -> VECTOR:
        return VECTOR(self.placed * (1 / to_expressions([divisor])[0]))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, VECTOR) and marks(self.placed.in_ground) == marks(other.placed.in_ground)

    def __hash__(self) -> int:
        return hash(("VECTOR", marks(self.placed.in_ground)))

    def lines(self) -> list[str]:
        """Return components and frame."""
        return [f"comps = {list(self.comps)}", *_in_frame(self.frame)]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class BODY(Shown):
    """A rigid body; each one made is another."""

    obj: ClassVar[str] = "BODY"

    placed: PlacedBody
    serial: int

    @property
    def frame(self) -> FRAME:
        """The frame in which the centre of mass was given; the body's axes."""
        return FRAME(self.placed.centre.frame)

    @property
    def mass(self) -> SympyExpr:
        """The mass."""
        return to_sympy_expressions([self.placed.mass])[0]

    @property
    def inertia(self) -> SympyMatrix:
        """The inertia tensor about the centre of mass."""
        return SympyMatrix(3, 3, to_sympy_expressions([entry for row in self.placed.tensor for entry in row]))

    def lines(self) -> list[str]:
        """Return mass, inertia, centre of mass and frame."""
        centre = POINT(self.placed.centre)
        name = [f"name = {self.placed.name}"] if self.placed.name else []
        inertia = [f"mass = {self.mass}", f"inertia = {self.inertia.tolist()}"]
        return [
            *name,
            *inertia,
            *(f"CoM {line}" if k == 0 else line for k, line in enumerate(centre.lines())),
        ]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LOAD(Shown):
    """A force or torque on a body; each one made is another."""

    placed: PlacedForce | PlacedTorque
    serial: int

    @property
    def vector(self) -> VECTOR:
        """The force or torque as a vector."""
        return VECTOR(self.placed.vector)

    @property
    def comps(self) -> SympyMatrix:
        """The components, then 0."""
        return self.vector.comps

    def lines(self) -> list[str]:
        """Return components and frame."""
        return self.vector.lines()


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class FORCE(LOAD):
    """A force on a body."""

    obj: ClassVar[str] = "FORCE"

    placed: PlacedForce

    @property
    def point(self) -> POINT:
        """Where it acts."""
        return POINT(self.placed.point)

    def lines(self) -> list[str]:
        """Return components, frame and point."""
        return [*self.vector.lines(), f"at coords = {list(self.point.coords)} of its frame"]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TORQUE(LOAD):
    """A torque on a body."""

    obj: ClassVar[str] = "TORQUE"

    placed: PlacedTorque


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CONSTRAINT(Shown):
    """Expressions that vanish, each with its multiplier; each one made is another."""

    obj: ClassVar[str] = "CONSTRAINT"

    placed: PlacedConstraint
    serial: int

    @property
    def exprs(self) -> list[SympyExpr]:
        """What vanishes."""
        return to_sympy_expressions(self.placed.values)

    def lines(self) -> list[str]:
        """Return each equation with its multiplier."""
        pairs = zip(self.exprs, self.placed.multipliers, strict=True)
        return [f"{value} = 0, multiplier {name}(t)" for value, name in pairs]


OBJECT: TypeAlias = BODY | FORCE | TORQUE | CONSTRAINT


def frame_of_matrix(matrix: SympyMatrix) -> PlacedFrame:
    """Return the frame of a 4 x 4 matrix, for instance of natural coordinates.

    Raises
    ------
    FrameError
        If it is not a matrix of a frame.
    """
    if matrix.shape != (4, 4) or list(matrix.row(3)) != [0, 0, 0, 1]:
        raise FrameError(
            Problem("mbsymba.not_a_frame_matrix", "frame", f"the matrix is {matrix.rows} x {matrix.cols}, "
                    f"its last row {list(matrix.row(-1))}",
                    "a frame is a 4 x 4 matrix with the last row 0, 0, 0, 1",
                    "put the axes in the first three columns and the origin in the fourth")
        )  # fmt: skip
    a = to_expressions(matrix)
    r, R = (a[3], a[7], a[11]), ((a[0], a[1], a[2]), (a[4], a[5], a[6]), (a[8], a[9], a[10]))
    turn = DirectionCosines(R)
    return PlacedFrame((Shift(r),) if turn.is_identity else (Shift(r), turn))


def _times(frame: FRAME, matrix: SympyMatrix) -> FRAME | SympyMatrix:
    """Return a frame times a column of four, or times the matrix of a frame."""
    if matrix.shape == (4, 4):
        return FRAME(frame.placed * frame_of_matrix(matrix))
    if matrix.shape != (4, 1) or matrix[3] not in (0, 1):
        raise FrameError(
            Problem("mbsymba.not_a_column", "frame * column", f"the column is {list(matrix)}",
                    "coordinates of a point are x, y, z, 1; components of a vector x, y, z, 0",
                    "give four rows")
        )  # fmt: skip
    x, y, z = to_expressions(matrix[:3])
    here = (x, y, z)
    there = frame.placed.place(here) if matrix[3] == 1 else frame.placed.rotate(here)
    return SympyMatrix([*to_sympy_expressions(there), matrix[3]])


def _entries(frame: FRAME) -> list[Expr]:
    return [entry for row in homogeneous(frame.placed, WORKPLACE.graph) for entry in row]


def _in_frame(frame: FRAME) -> list[str]:
    if not frame.placed.steps:
        return ["frame = ground"]
    first, *others = frame.lines()
    return [f"frame = {first}", *(f"        {line}" for line in others)]
