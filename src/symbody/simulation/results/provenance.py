"""`Provenance`: what a motion was computed from, in the words of the model, and how files hold it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import fits
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.input_formulas import input_formula
from symbody.expr.language.formula import Formula
from symbody.formats.native import model_from_toml, model_to_toml
from symbody.graph.trees import Trees
from symbody.model.declarations.arguments import plain_value
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


Floats = NDArray[np.float64]
Record = dict[str, Any]  # what JSON can say

_KINDS: Final[Mapping[str, object]] = {
    "text": str,
    "parameters": dict[str, str],
    "rotation_tree": list[str],
    "translation_tree": list[str],
    "dependent_speeds": list[str],
    "inputs": dict[str, str],
    "tables": dict[str, tuple[str, str]],
    "switches": bool,
}


def record_of(provenance: Provenance) -> tuple[Record, dict[str, Floats]]:
    """Return what is written of it, and the points of its tables as arrays (2, N)."""
    record: Record = {
        "text": model_to_toml(provenance.model, is_alone=True),
        "parameters": {
            name: Formula.from_value(plain_value(value), where=name).text
            for name, value in provenance.given.items()
        },
        "rotation_tree": provenance.trees.rotation,
        "translation_tree": provenance.trees.translation,
        "dependent_speeds": provenance.dependent_speeds,
        "inputs": {
            name: input_formula(plain_value(law), name).text for name, law in provenance.inputs.items()
        },
        "tables": {name: (table.kind, table.outside) for name, table in provenance.tables.items()},
        "switches": provenance.switches,
        "substitutes": provenance.substitutes,
    }
    held = provenance.held
    if held is not None:
        record["held"] = held.names
    points = [np.array([table.t, table.values], dtype=np.float64) for table in provenance.tables.values()]
    arrays = {f"table_{k}": array for k, array in enumerate(points)}
    return record, arrays | ({} if held is None else {"held": np.vstack([held.t, held.values])})


def provenance_from(record: Record, arrays: Mapping[str, Floats], where: str) -> Provenance:
    """Return what `record_of` wrote.

    Raises FormatError, ModelError, ExpressionError if the text is not a model, or a formula is none, in file
    `where`; UsageError if points make no table; KeyError, TypeError, ValueError if something is missing, or
    of another kind.
    """
    given = {**record, "tables": {name: tuple(words) for name, words in record["tables"].items()}}
    for name, kind in _KINDS.items():
        if not fits(kind, given[name]):
            raise ValueError(f"{name} has another type")
    tables = {
        name: Table(*arrays[f"table_{k}"], *words) for k, (name, words) in enumerate(given["tables"].items())
    }
    return Provenance(
        model_from_toml(given["text"], f"{where}, model"),
        {
            name: Formula.from_value(text, where=f"{where}, {name}")
            for name, text in given["parameters"].items()
        },
        Trees(given["rotation_tree"], given["translation_tree"]),
        tuple(given["dependent_speeds"]),
        {name: input_formula(text, name) for name, text in given["inputs"].items()},
        tables,
        given["switches"],
        _held_record(given.get("held", []), arrays),
        given.get("substitutes", False) is True,
    )


def _held_record(names: list[str], arrays: Mapping[str, Floats]) -> HeldRecord | None:
    """Return held values; files of older versions have none."""
    if not fits(list[str], names) or (names and arrays["held"].shape[:1] != (len(names) + 1,)):
        raise ValueError("held has another type")
    return HeldRecord(tuple(names), arrays["held"][0], arrays["held"][1:]) if names else None
