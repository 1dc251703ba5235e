"""A force and a torque on any one body: six inputs, and one for each body that is 1 while it is held."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.model.body import Body
from symbody.model.loads.forces import Force, Torque
from symbody.model.model import Model

_COMPONENTS: Final = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
# Of more bodies none can be held: each makes the equations longer.
MOST_BODIES: Final = 40


@dataclass(frozen=True, slots=True)
class PointerWrench:
    """Names of inputs: components of a wrench in ground's axes [N, N m], and weights of the bodies."""

    components: tuple[str, ...]
    weights: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.components, *self.weights)


def add_pointer_wrench(eqs: EquationSet) -> tuple[EquationSet, PointerWrench | None]:
    """Return equations in the same coordinates with a wrench on any body; without it where that cannot be.

    The wrench acts at the origin of a body's axes.
    """
    model = eqs.model
    if not isinstance(model, Model) or len(model.bodies) > MOST_BODIES or not eqs.speed_names:
        return eqs, None
    word = _unused_word(eqs)
    wrench = PointerWrench(
        tuple(f"{word}_{component}" for component in _COMPONENTS),
        tuple(f"{word}_{k}" for k in range(len(model.bodies))),
    )
    loads = [
        load for body, weight in zip(model.bodies, wrench.weights, strict=True)
        for load in _loads(body, weight, wrench.components)
    ]  # fmt: skip
    pulled = Model(
        model.name, [*model.elements, *loads], model.gravity, model.parameters,
        [*model.inputs, *wrench.names], model.initial, model.ground, (), model.ground_shapes,
    )  # fmt: skip
    dependent = eqs.formed.dependent_names
    made = form_equations(
        pulled,
        tree=eqs.formed.topology.trees,
        dependent_speeds=dependent or None,
        substitute=bool(eqs.formed.coupled.rows),
    )
    same = made.state_names == eqs.state_names and len(made.multiplier_names) == len(eqs.multiplier_names)
    return (made, wrench) if same else (eqs, None)


def _loads(body: Body, weight: str, components: tuple[str, ...]) -> tuple[Force, Torque]:
    terms = [f"{weight}*{component}" for component in components]
    return (
        Force(f"{weight} force", on=body.name, vector=terms[:3]),
        Torque(f"{weight} torque", on=body.name, vector=terms[3:]),
    )


def _unused_word(eqs: EquationSet) -> str:
    """Return a word with which no name of the model begins."""
    names = [
        *eqs.parameter_names, *eqs.input_names, *eqs.state_names, *(each.name for each in eqs.model.elements),
        *(name for joint in eqs.model.joints for name in joint.coordinates),
    ]  # fmt: skip
    word = "pointer"
    while any(name.startswith(word) for name in names):
        word += "_"
    return word
