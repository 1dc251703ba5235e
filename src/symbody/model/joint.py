"""`Joint`: what every joint answers, and what follows from it for all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Final, Literal

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.constraints.couplings import Stop
from symbody.model.declarations.arguments import ZERO, Arguments
from symbody.model.declarations.element_fields import Connection, element
from symbody.model.declarations.fields import Quantity, Refusal
from symbody.model.declarations.formula_site import Triple
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.loads.bristles import bristle_signals
from symbody.model.loads.forces import Drive
from symbody.model.loads.friction import Friction
from symbody.model.loads.gap_laws import Limits
from symbody.model.naming import make_symbol
from symbody.model.numeric_checks import NumericChecks
from symbody.model.signals.signal import Signal
from symbody.model.simple_rotation import SimpleRotation

ORIGIN: Final[Triple] = (ZERO, ZERO, ZERO)
RATES: Final = "rates"


@dataclass(frozen=True, slots=True, repr=False)
class InTrees:
    """Whether a joint is to be in the rotation tree and in the translation tree; None: automatic."""

    rotation: bool | None = None
    translation: bool | None = None

    def __repr__(self) -> str:
        choices = {"rotation": self.rotation, "translation": self.translation}
        return repr({tree: flag for tree, flag in choices.items() if flag is not None})


@dataclass(frozen=True, slots=True)
class QuasiSpeeds:
    """Speeds that are components of a velocity of end relative to start.

    For rotation the velocity is the angular velocity, for translation the rate of the position of end's
    origin as seen from start.

    Attributes
    ----------
    names : (3,) str
        The components along x, y and z.
    resolved_in : str
        The axes of the components.
    """

    names: tuple[str, str, str]
    resolved_in: Literal["start", "end"]


# Every look at a joint leads here; of a joint these never change.
@lru_cache(maxsize=4096)
def _names_after(name: str, suffixes: tuple[str, ...]) -> tuple[str, ...]:
    own = make_symbol(name)
    return tuple(f"{own}{suffix}" for suffix in suffixes)


@lru_cache(maxsize=16)
def _suffixes(count: int) -> tuple[str, ...]:
    return ("",) if count == 1 else tuple(f"_{k}" for k in range(1, count + 1))


@element
class Joint(Connection):
    """A connection of two frames; `end` moves relative to `start`.

    A concrete joint declares its arguments and states its law: the turns from start to end and the shift of
    the origin, in its coordinates. Its fields take the place of the properties below that say "nothing".
    Everything else is derived here.

    Attributes
    ----------
    letters : tuple of str
        What the documentation calls the coordinates.
    law : str
        The law in the letters of the documentation.
    """

    kind: ClassVar[str] = "joint"
    on_one_body: ClassVar[Refusal | None] = Refusal(
        "model.self_joint", what="both ends are on {value}", fix="name another body at one end",
        why="a joint connects two bodies, or a body and ground",
    )  # fmt: skip
    letters: ClassVar[tuple[str, ...]] = ()
    law: ClassVar[str] = ""

    def __str__(self) -> str:
        names = ", ".join(self.coordinates)
        return f"{type(self).__name__} {self.name}: {self.start} -> {self.end}, {names or 'rigid'}"

    def given_arguments(self) -> dict[str, Any]:
        """Return the arguments; of a joint with one coordinate what stands under its name, as it is given."""
        given = Connection.given_arguments(self)
        alone = {name for name, value in given.items() if isinstance(value, FrozenMapping)}
        if len(self.coordinates) == 1:
            given |= {name: given[name][self.coordinates[0]] for name in alone if len(given[name]) == 1}
        return given

    # The law.

    @property
    def suffixes(self) -> tuple[str, ...]:
        """What follows the joint's name in the name of each coordinate without one of its own."""
        return _suffixes(len(self.letters))

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the successive simple rotations from the start frame to the end frame."""
        return ()

    def shift(self) -> Triple:
        """Return the position of end's origin from start's, in axes of `shift_in` [m]."""
        return ORIGIN

    # What a joint may have besides.

    @property
    def coordinate(self) -> str | None:
        """The user's name for the only coordinate, or None."""
        return None

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Names of all coordinates; those without a name of their own are named after the joint."""
        own, names = self.coordinate, self.default_coordinates
        return (own,) * len(names) if own else names

    @property
    def tree(self) -> InTrees:
        """The user's choice of coordinates."""
        return InTrees()

    @property
    def constants(self) -> Mapping[str, Formula]:
        """Each constant of the law by its word."""
        fields = self.fields.items()
        return {name: getattr(self, name) for name, field in fields if isinstance(field, Quantity)}

    @property
    def shift_in(self) -> Literal["start", "end"]:
        """The axes in which the shift has its components."""
        return "start"

    @property
    def force(self) -> FrozenMapping[Drive]:
        """What acts along each driven displacement."""
        return FrozenMapping()

    @property
    def torque(self) -> FrozenMapping[Drive]:
        """What acts along each driven angle."""
        return FrozenMapping()

    @property
    def limits(self) -> FrozenMapping[Limits]:
        """The ends of each coordinate that has some."""
        return FrozenMapping()

    @property
    def motion(self) -> FrozenMapping[Formula]:
        """Each prescribed coordinate as a formula in parameters and t."""
        return FrozenMapping()

    @property
    def as_constraint(self) -> bool:
        """Whether prescribed motions become constraints instead of replacing the coordinate."""
        return False

    @property
    def armature(self) -> Mapping[str, Formula]:
        """Rotor inertia along a coordinate [kg, kg m^2]."""
        return {}

    @property
    def friction(self) -> Friction | None:
        """Dry friction along the only coordinate."""
        return None

    @property
    def quaternion(self) -> tuple[str, str, str, str] | None:
        """Names of the Euler parameters, scalar first, end to start, where they give the orientation.

        `turns` is then empty.
        """
        return None

    @property
    def speeds(self) -> str:
        """What the speeds are: ``"rates"`` of the coordinates, or components of velocities."""
        return RATES

    @property
    def speed_names(self) -> tuple[str, ...] | None:
        """The user's names of the quasi-speeds, translation first, or None."""
        return None

    @property
    def rotation_speeds(self) -> QuasiSpeeds | None:
        """The speeds of the rotation; None: the rates of its coordinates."""
        return None

    @property
    def translation_speeds(self) -> QuasiSpeeds | None:
        """The speeds of the translation; None: the rates of its coordinates."""
        return None

    # What follows.

    @property
    def default_coordinates(self) -> tuple[str, ...]:
        """The names of coordinates that the user gives none."""
        return _names_after(self.name, self.suffixes)

    @property
    def given_names(self) -> tuple[str | None, ...]:
        """The user's name for each coordinate, or None where there is none."""
        if len(self.suffixes) == 1:
            return (self.coordinate,)
        pairs = zip(self.coordinates, self.default_coordinates, strict=True)
        return tuple(None if name == default else name for name, default in pairs)

    @property
    def has_named_coordinates(self) -> bool:
        """Whether the user named every coordinate."""
        return None not in self.given_names

    @property
    def quasi_speed_names(self) -> tuple[str, ...]:
        """Names of the speeds that are not rates of coordinates, translation first."""
        both = (self.translation_speeds, self.rotation_speeds)
        return tuple(name for speeds in both if speeds is not None for name in speeds.names)

    @property
    def drives(self) -> Mapping[str, Drive]:
        """What acts along each driven coordinate."""
        return {**self.force, **self.torque}

    @property
    def compliant_limits(self) -> Mapping[str, Limits]:
        """The ends at which a force acts along the coordinate."""
        return {x: limits for x, limits in self.limits.items() if not limits.rigid}

    @property
    def loaded_coordinates(self) -> tuple[str, ...]:
        """The coordinates along which drives or limits act."""
        acting = {*self.drives, *self.compliant_limits}
        return tuple(x for x in self.coordinates if x in acting)

    @property
    def stops(self) -> tuple[Stop, ...]:
        """What rigid limits are: a stop at each end."""
        return tuple(
            Stop(f"{self.effort_name(x)} {end}", gap, restitution=limits.restitution or 0)
            for x, limits in self.limits.items()
            if limits.rigid
            for end, gap in limits.gaps(x)
        )

    @property
    def compliant_gaps(self) -> Mapping[str, bool]:
        """The gaps below which limits that are not rigid have a force, and whether each is an angle."""
        turning = self.rotation_coordinates
        return {
            gap.text: x in turning
            for x, limits in self.limits.items()
            if not limits.rigid
            for _, gap in limits.gaps(x)
        }

    def effort_name(self, coordinate: str) -> str:
        """Return the name of the effort along a coordinate: the joint, and the coordinate of several."""
        return f"{self.name} {coordinate}" if len(self.coordinates) > 1 else self.name

    @property
    def motions(self) -> Mapping[str, Formula]:
        """Each prescribed coordinate as a formula in parameters and t."""
        return self.motion

    @property
    def rotation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that turn the end frame."""
        inside = {name for turn in self.turns() for name in turn.angle.names} | set(self.quaternion or ())
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def angle_coordinates(self) -> tuple[str, ...]:
        """The rotation coordinates that are angles, no parts of a quaternion."""
        return tuple(name for name in self.rotation_coordinates if name not in (self.quaternion or ()))

    @property
    def translation_coordinates(self) -> tuple[str, ...]:
        """The coordinates that shift the end frame's origin."""
        inside = {name for component in self.shift() for name in component.names}
        return tuple(name for name in self.coordinates if name in inside)

    @property
    def coupled_coordinates(self) -> tuple[str, ...]:
        """The coordinates that turn the end frame and shift its origin, as in a screw."""
        both = set(self.translation_coordinates)
        return tuple(name for name in self.rotation_coordinates if name in both)

    @property
    def is_untwisted(self) -> bool:
        """Whether the last turn takes the first one back, so that end never turns about its shaft."""
        return len(self.turns()) == 3 and len(self.rotation_coordinates) == 2

    @property
    def locked_rotations(self) -> int:
        """Number of rotations the joint prevents."""
        return 0 if self.quaternion else 3 - len(self.rotation_coordinates)

    @property
    def locked_translations(self) -> int:
        """Number of translations the joint prevents; one tied to a rotation, as in a screw, is prevented."""
        return 3 - len(set(self.translation_coordinates) - set(self.rotation_coordinates))

    @property
    def locked_directions(self) -> int:
        """Number of directions the joint prevents."""
        return self.locked_rotations + self.locked_translations

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind: of several coordinates those with one."""
        if kind == "effort":
            driven = tuple(x for x in self.coordinates if x in self.loaded_coordinates or x in self.motions)
            return driven if len(self.coordinates) > 1 else ("",) * len(driven)
        has_friction = self.friction is not None and not self.friction.is_none
        if kind == "mode":
            return ("",) if self.friction is not None and has_friction and not self.friction.is_smooth else ()
        return ("",) if kind == "reaction" or (kind == "friction" and has_friction) else ()

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states of the bristles of its friction."""
        if self.friction is None or not self.friction.has_bristles:
            return ()
        slips = (("", f"{self.coordinates[0]}_dot"),)
        return bristle_signals(self.friction, f"{make_symbol(self.name)}_bristle", slips)

    def coordinate_path(self, word: str, coordinate: str) -> str:
        """Return where `word` stands for a coordinate: ``"torque"``, or ``"torque.theta"`` of several."""
        return word if len(self.coordinates) == 1 else f"{word}.{coordinate}"

    def drives_with_paths(self) -> Iterator[tuple[str, str, Drive]]:
        """Return each drive after its place and its coordinate."""
        for word, drives in (("force", self.force), ("torque", self.torque)):
            for coordinate, drive in drives.items():
                yield self.coordinate_path(word, coordinate), coordinate, drive

    def limits_with_paths(self) -> Iterator[tuple[str, str, Limits]]:
        """Return the limits of each coordinate after their place and the coordinate."""
        for coordinate, limits in self.limits.items():
            yield self.coordinate_path("limits", coordinate), coordinate, limits

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers that cannot be, and a choice without effect."""
        Connection.check_numbers(self, check, label)
        if self.as_constraint and not self.motion:
            check.note(f"{label}: as_constraint has no effect, because no motion is prescribed")

    def check(self, arguments: Arguments) -> None:
        """Note drives, limits and motions of coordinates that cannot have them."""
        if not (self.force or self.torque or self.motion or self.limits):
            return
        angles, displacements = self.angle_coordinates, self.translation_coordinates
        for word, keys, fitting in (
            ("force", self.force, displacements),
            ("torque", self.torque, angles),
            ("motion", self.motion, (*displacements, *angles)),
            ("limits", self.limits, (*displacements, *angles)),
        ):
            for key in keys:
                if key not in fitting:
                    _refuse_key(self, arguments, word, key, fitting)
        for name in self.limits.keys() & self.motions.keys():
            what, why = f"the motion of {name} is prescribed", "it is what it is, beyond limits too"
            fix = "remove motion or limits; a drive moves a coordinate as far as its limits let it"
            arguments.add("model.limits", self.coordinate_path("limits", name), what, why, fix)
        if not self.as_constraint:
            _check_motions(self, arguments)


def _refuse_key(joint: Joint, arguments: Arguments, word: str, key: str, fitting: Iterable[str]) -> None:
    path = joint.coordinate_path(word, key)
    if key in (joint.quaternion or ()):
        done = "limited" if word == "limits" else "driven"
        what = f"{key} is a component of a quaternion, which cannot be {done} individually"
        why = "the four components depend on each other"
        other = "write a [[constraint]] stop" if word == "limits" else "apply a [[torque]] to the body"
        fix = f'choose angles, for instance angles = "313"; or {other}'
        arguments.add("model.quaternion_component", path, what, why, fix)
    elif key in joint.coordinates:
        other = "torque" if word == "force" else "force"
        what = f"{key} is {'an angle' if word == 'force' else 'a displacement'}"
        why = "force is for displacements, torque is for angles"
        arguments.add("model.wrong_drive", path, what, why, f"write {other} instead of {word}")
    else:
        what = f"the joint has no coordinate {key!r}"
        arguments.add("model.unknown_coordinate", path, what, "", nearest(key, fitting))


def _check_motions(joint: Joint, arguments: Arguments) -> None:
    """Note prescribed coordinates whose rates are not speeds, so that they cannot leave the unknowns."""
    for names, speeds in (
        (joint.rotation_coordinates, joint.rotation_speeds),
        (joint.translation_coordinates, joint.translation_speeds),
    ):
        for name in joint.motion:
            if name in names and speeds is not None and name not in (joint.quaternion or ()):
                arguments.add(
                    "model.motion_without_rate",
                    joint.coordinate_path("motion", name),
                    f"the rate of {name} is not among the speeds of the joint",
                    f"its speeds are {', '.join(speeds.names)}",
                    'write speeds = "rates", or as_constraint = true',
                )
