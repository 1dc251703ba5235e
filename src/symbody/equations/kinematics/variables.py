"""The variables of a mechanism: which joint coordinates are in q, which speeds in u, and q' in terms of u."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.model.joint import Joint, QuasiSpeeds
from symbody.model.simple_rotation import SimpleRotation as JointTurn
from symbody.spatial.euler_angles import angle_rates
from symbody.spatial.euler_parameters import EulerParameters, euler_parameter_rates
from symbody.spatial.rotation import AxisRotation, compose_steps, rotation_matrix


@dataclass(frozen=True, slots=True)
class JointRole:
    """Which parts of a joint's law are in use.

    Attributes
    ----------
    in_rotation, in_translation : bool
        Whether the joint is in the tree.
    has_angles, has_displacements : bool
        Whether its rotational, its translational coordinates are known, as unknowns or as functions of time:
        in the tree always, elsewhere where a formula reads them.
    substituted : tuple of str
        The coordinates that follow from others, which couplings give.
    """

    joint: Joint
    in_rotation: bool
    in_translation: bool
    has_angles: bool
    has_displacements: bool
    substituted: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The coordinates in use."""
        inside = {
            *(self.joint.rotation_coordinates if self.has_angles else ()),
            *(self.joint.translation_coordinates if self.has_displacements else ()),
        }
        return tuple(name for name in self.joint.coordinates if name in inside)

    @property
    def prescribed_coordinates(self) -> tuple[str, ...]:
        """The coordinates in use that are functions of time; those of a cut joint make its rows move."""
        motions = self.joint.motions
        by_row = self.joint.as_constraint
        return tuple(
            name for name in self.coordinates if name in motions and not (by_row and self.is_branch(name))
        )

    def is_branch(self, coordinate: str) -> bool:
        """Return whether a coordinate belongs to a tree that the joint is in."""
        return self.in_rotation if coordinate in self.joint.rotation_coordinates else self.in_translation

    @property
    def quasi_speeds(self) -> list[tuple[QuasiSpeeds, str]]:
        """The quasi-speeds in use, each with "translation" or "rotation"."""
        speeds = []
        if self.has_displacements and self.joint.translation_speeds is not None:
            speeds.append((self.joint.translation_speeds, "translation"))
        if self.has_angles and self.joint.rotation_speeds is not None:
            speeds.append((self.joint.rotation_speeds, "rotation"))
        return speeds

    @property
    def speeds(self) -> list[Symbol]:
        """Quasi-speeds where the joint has them, else the rates of its unknown coordinates, in its order."""
        quasi = {part: speeds for speeds, part in self.quasi_speeds}
        turning = set(self.joint.rotation_coordinates)
        speeds: list[Symbol] = []
        for name in self.unknown_coordinates:
            part = quasi.get("rotation" if name in turning else "translation")
            if part is None:
                speeds.append(Symbol(name, SymbolKind.COORDINATE).derivative)
            else:
                speeds += [Symbol(own, SymbolKind.SPEED) for own in part.names]
        return list(dict.fromkeys(speeds))

    @property
    def unknown_coordinates(self) -> tuple[str, ...]:
        """The coordinates in use that are in q."""
        given = {*self.prescribed_coordinates, *self.substituted}
        return tuple(name for name in self.coordinates if name not in given)


@dataclass(frozen=True, slots=True)
class Variables:
    """Coordinates and speeds.

    Attributes
    ----------
    q, u : tuple of Symbol
        In the order of the joints.
    rates : mapping of node to node
        q' in terms of u.
    quaternions : tuple of (4,) int
        Nodes of the Euler parameters in q.
    singularities : mapping of joint name to Expr
        Where it vanishes, the angle rates do not follow from the angular velocity.
    """

    q: tuple[Symbol, ...]
    u: tuple[Symbol, ...]
    rates: Mapping[int, int]
    quaternions: tuple[tuple[int, ...], ...]
    singularities: Mapping[str, Expr]


def form_variables(names: Names, roles: Sequence[JointRole], added: Sequence[str] = ()) -> Variables:
    """Return the variables of the joints in use, then the `added` coordinates of constraints."""
    graph = names.graph
    q: list[Symbol] = []
    u: list[Symbol] = []
    rates: dict[int, int] = {}
    quaternions = []
    singular = {}
    for role in roles:
        q += [Symbol(name, SymbolKind.COORDINATE) for name in role.unknown_coordinates]
        u += role.speeds
        rates.update(_coordinate_rates(graph, role))
        for quasi, part in role.quasi_speeds:
            coordinate_rates, determinant = _rates_from_quasi_speeds(names, role.joint, quasi, part)
            rates.update(coordinate_rates)
            if determinant is not None:
                singular[role.joint.name] = determinant
        if role.has_angles and role.joint.quaternion is not None:
            quaternions.append(tuple(names.value(name).index for name in role.joint.quaternion))
    for name in added:
        coordinate = Symbol(name, SymbolKind.COORDINATE)
        q.append(coordinate)
        u.append(coordinate.derivative)
        rates[graph.symbol(coordinate)] = graph.symbol(coordinate.derivative)
    return Variables(tuple(q), tuple(u), rates, tuple(quaternions), singular)


def joint_steps(names: Names, joint: Joint) -> tuple[AxisRotation | EulerParameters, ...]:
    """Return the rotation of a joint from its start frame to its end frame, in its coordinates."""
    if joint.quaternion is None:
        return axis_rotations(names, joint.turns(), f"joint {joint.name}")
    e0, e1, e2, e3 = (names.value(name) for name in joint.quaternion)
    return (EulerParameters(e0, e1, e2, e3),)


def axis_rotations(names: Names, turns: Sequence[JointTurn], where: str) -> tuple[AxisRotation, ...]:
    """Return simple rotations of the model on the graph."""
    return tuple(
        AxisRotation(names.triple(turn.axis, where), names.expression(turn.angle, where)) for turn in turns
    )


def quasi_vector(names: Names, quasi: QuasiSpeeds) -> tuple[Expr, Expr, Expr]:
    """Return three quasi-speeds as components."""
    x, y, z = (names.value(name) for name in quasi.names)
    return (x, y, z)


def _coordinate_rates(graph: Graph, role: JointRole) -> dict[int, int]:
    """Return q' = the symbol q' for the coordinates of a joint."""
    symbols = [Symbol(name, SymbolKind.COORDINATE) for name in role.unknown_coordinates]
    return {graph.symbol(symbol): graph.symbol(symbol.derivative) for symbol in symbols}


def _rates_from_quasi_speeds(
    names: Names, joint: Joint, quasi: QuasiSpeeds, part: str
) -> tuple[dict[int, int], Expr | None]:
    """Return q' of a joint's rotation or translation in quasi-speeds, and what must not vanish."""
    graph = names.graph
    speeds = quasi_vector(names, quasi)
    steps = joint_steps(names, joint)
    if part == "translation":
        if quasi.resolved_in == "end":
            speeds = rotation_matrix(graph, compose_steps(steps)) @ speeds
        return _pair_with_coordinates(names, joint.translation_coordinates, speeds), None
    if joint.quaternion is not None:
        (parameters,) = steps
        assert isinstance(parameters, EulerParameters)
        rates = euler_parameter_rates(parameters, speeds, quasi.resolved_in)
        return _pair_with_coordinates(names, joint.quaternion, rates), None
    turns = tuple(step for step in steps if isinstance(step, AxisRotation))
    angles, determinant = angle_rates(graph, turns, speeds, quasi.resolved_in)
    return {turn.angle.index: rate.index for turn, rate in zip(turns, angles, strict=True)}, determinant


def _pair_with_coordinates(names: Names, coordinates: Sequence[str], rates: Sequence[Expr]) -> dict[int, int]:
    return {names.value(name).index: rate.index for name, rate in zip(coordinates, rates, strict=True)}
