"""`Provenance`: what a motion was computed from, in the words of the model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.graph.trees import Trees
from symbody.model.model import Model, resolve_parameters
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.inputs.input_laws import InputLaws
from symbody.simulation.inputs.tables import Table


@dataclass(frozen=True, slots=True, eq=False)
class Provenance:
    """What a motion was computed from.

    Attributes
    ----------
    model : Model
        The mechanism.
    given : mapping of name to number or formula
        Parameters that override the model's.
    trees : Trees
        The joints that give the coordinates.
    dependent_speeds : tuple of str
        Speeds that were eliminated.
    inputs : mapping of name to formula
        Laws of inputs in time, states and parameters.
    tables : mapping of name to Table
        Laws of inputs that are tables.
    switches : bool
        Whether the equations change on the way, by sticking joints, slack ropes or open stops.
    held : HeldRecord, optional
        Values that were held between samples.
    substitutes : bool
        Whether coordinates that couplings give were substituted.
    """

    model: Model
    given: Mapping[str, Value]
    trees: Trees
    dependent_speeds: tuple[str, ...] = ()
    inputs: Mapping[str, Value] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    switches: bool = False
    held: HeldRecord | None = None
    substitutes: bool = False

    @property
    def parameters(self) -> dict[str, float]:
        """The value of every parameter."""
        return {name: float(value) for name, value in resolve_parameters(self.model, self.given).items()}

    @property
    def missing_inputs(self) -> tuple[str, ...]:
        """Inputs whose law was a Python function."""
        return tuple(
            name for name in self.model.inputs if name not in self.inputs and name not in self.tables
        )


def provenance_of(
    eqs: EquationSet,
    given: Mapping[str, Value],
    laws: InputLaws,
    tables: Mapping[str, Table] | None = None,
    *,
    held: HeldRecord | None = None,
    switches: bool = False,
) -> Provenance | None:
    """Return what a motion of these equations is computed from; nothing for mechanisms placed by hand.

    Parameters
    ----------
    tables : mapping of name to Table
        Laws of inputs beside those of `laws`.
    """
    if not isinstance(eqs.model, Model):
        return None
    formed = eqs.formed
    callbacks = tuple(laws.callbacks)
    own_tables = {callbacks[place]: table for place, table in laws.tables.items()} | dict(tables or {})
    return Provenance(
        eqs.model,
        dict(given),
        eqs.plans.get("trees", lambda: formed.topology.trees),
        formed.dependent_names,
        {name: law for name, law in laws.formulas.items() if name not in own_tables},
        own_tables,
        switches,
        held,
        bool(formed.coupled.rows),
    )
