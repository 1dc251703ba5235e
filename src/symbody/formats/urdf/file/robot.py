"""The content of a URDF file, as data: `Robot` with its links, joints and shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.expr.graph import Constant
from symbody.formats.urdf.file.placement import HERE, FramePlacement, Numbers


@dataclass(frozen=True, slots=True)
class Shape:
    """A visual or a collision shape of a link; it has no influence on the motion.

    Attributes
    ----------
    kind : str
        ``"box"``, ``"cylinder"``, ``"sphere"``, ``"capsule"`` or ``"mesh"``.
    sizes : tuple of number
        Edges of a box; radius and length of a cylinder or capsule; radius of a sphere; scale of a mesh.
    mesh : str
        Address of the mesh as written; `find_mesh` looks for its file.
    color : (4,) number or None
        Red, green, blue, opacity in 0 to 1.
    """

    name: str
    origin: FramePlacement
    kind: str
    sizes: tuple[Constant, ...]
    mesh: str = ""
    color: tuple[Constant, ...] | None = None


@dataclass(frozen=True, slots=True)
class UrdfLink:
    """A link.

    Attributes
    ----------
    centre : FramePlacement
        Where the centre of mass is, and the axes of its inertia, from the link's frame.
    inertia : (6,) number
        Tensor entries xx, yy, zz, xy, xz, yz about the centre of mass [kg m^2].
    has_inertial : bool
        Whether the file gives mass and inertia.
    line : int
        Of the file.
    """

    name: str
    line: int
    mass: Constant = 0
    centre: FramePlacement = HERE
    inertia: tuple[Constant, ...] = (0,) * 6
    has_inertial: bool = False
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()


@dataclass(frozen=True, slots=True)
class Limit:
    """What a joint can do; kept as data [rad, m, N m, N, rad/s, m/s]."""

    lower: Constant | None
    upper: Constant | None
    effort: Constant | None
    velocity: Constant | None


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint follows another: ``q = multiplier leader + offset``."""

    leader: str
    multiplier: Constant
    offset: Constant


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A joint from a parent link to a child link, whose frame it is in."""

    name: str
    line: int
    kind: str
    parent: str
    child: str
    origin: FramePlacement
    axis: Numbers
    damping: Constant = 0
    friction: Constant = 0
    limit: Limit | None = None
    mimic: Mimic | None = None

    @property
    def moves(self) -> bool:
        """Whether it has coordinates."""
        return self.kind != "fixed"


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot as its file describes it.

    Attributes
    ----------
    where : str
        The path of the file.
    root : str
        The link that is not a child.
    links, joints : mapping of name
        In the order of the file.
    notes : tuple of str
        What was assumed, made exact, or ignored.
    """

    name: str
    where: str
    root: str
    links: Mapping[str, UrdfLink]
    joints: Mapping[str, UrdfJoint]
    notes: tuple[str, ...]
