"""Names of what equations are about, in the order of arrays."""

from __future__ import annotations

from typing import NamedTuple

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.measured_coordinates import wrapped_angles


class OrderedNames(NamedTuple):
    """Names in order.

    Attributes
    ----------
    coordinates, speeds, accelerations, signals, states : tuple of str
        Of q, u, u', s, and x, which is u, then q, then s.
    inputs, parameters : tuple of str
        Of r, and of the model.
    multipliers : tuple of str
        One a constraint.
    quaternions : tuple of tuple of str
        The four Euler parameters of each quaternion in q, scalar first.
    measured_angles : tuple of str
        Angles of cut joints.
    wrapped_angles : tuple of str
        Those of them that are measured in (-pi, pi].
    """

    coordinates: tuple[str, ...]
    speeds: tuple[str, ...]
    accelerations: tuple[str, ...]
    signals: tuple[str, ...]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    multipliers: tuple[str, ...]
    quaternions: tuple[tuple[str, ...], ...]
    measured_angles: tuple[str, ...]
    wrapped_angles: tuple[str, ...]


def names_of(formed: EquationsOfMotion) -> OrderedNames:
    """Return the names of equations."""
    q, u = (tuple(symbol.label for symbol in symbols) for symbols in (formed.q, formed.u))
    signals = tuple(symbol.name for symbol in formed.signal_states)
    labels = {formed.graph.symbol(symbol): symbol.label for symbol in formed.q}
    return OrderedNames(
        coordinates=q,
        speeds=u,
        accelerations=tuple(symbol.derivative.label for symbol in formed.u),
        signals=signals,
        states=u + q + signals,
        inputs=tuple(symbol.name for symbol in formed.inputs),
        parameters=tuple(symbol.name for symbol in formed.parameters),
        multipliers=tuple(row.name for row in formed.rows),
        quaternions=tuple(tuple(labels[k] for k in nodes) for nodes in formed.variables.quaternions),
        measured_angles=tuple(
            name
            for role in formed.joint_roles
            for name in role.joint.rotation_coordinates
            if name not in role.coordinates and role.joint.quaternion is None
        ),
        wrapped_angles=tuple(
            name
            for role in formed.joint_roles
            for name in wrapped_angles(formed.names, formed.kinematics, role)
        ),
    )


class NamedEquations:
    """Equations with names of all that has a place in an array."""

    __slots__ = ()

    @property
    def names(self) -> OrderedNames:
        """Names of all that has a place in an array."""
        raise NotImplementedError

    @property
    def quaternions(self) -> tuple[tuple[str, ...], ...]:
        """Names of the four Euler parameters of each quaternion in q, scalar first."""
        return self.names.quaternions

    @property
    def measured_angles(self) -> tuple[str, ...]:
        """Names of the angles of cut joints, which are outputs."""
        return self.names.measured_angles

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Names of those of them that are measured in (-pi, pi]: no angles of the tree add up to them."""
        return self.names.wrapped_angles

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of q in order."""
        return self.names.coordinates

    @property
    def speed_names(self) -> tuple[str, ...]:
        """Names of u in order."""
        return self.names.speeds

    @property
    def acceleration_names(self) -> tuple[str, ...]:
        """Names of u' in order: ``<coordinate>_ddot``, ``<quasi-speed>_dot``."""
        return self.names.accelerations

    @property
    def signal_state_names(self) -> tuple[str, ...]:
        """Names of the states s of signals in order."""
        return self.names.signals

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states: speeds, then coordinates, then those of signals."""
        return self.names.states

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs r in order."""
        return self.names.inputs

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of all parameters of the model."""
        return self.names.parameters

    @property
    def multiplier_names(self) -> tuple[str, ...]:
        """Names of the multipliers, one a constraint; none in a tree."""
        return self.names.multipliers
