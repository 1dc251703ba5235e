"""Outputs of motions from files, computed by equations that are formed again from the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import mechanism_scales
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.errors import Problem, TopologyError, UsageError
from symbody.graph.trees import TreeChoice, Trees
from symbody.model.model import Model
from symbody.simulation.inputs.held_law import HeldLaw, held_later
from symbody.simulation.inputs.input_laws import Callback, InputLaws
from symbody.simulation.results.evaluate import OutputEvaluator
from symbody.simulation.results.provenance import Provenance
from symbody.simulation.simulation_problem import Evaluator, SimulationProblem
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]
Names = tuple[str, ...]

# Outputs that follow from positions and speeds alone, whatever joints stick and gaps are closed.
_KINEMATIC: Final = ("frame r ", "frame R ", "frame v ", "frame w ")
_ENERGIES: Final = ("energy", "kinetic_energy", "potential_energy")


@dataclass(frozen=True, slots=True, eq=False)
class Recomputation(OutputEvaluator):
    """Computes outputs of a motion that was read from a file; the first one forms the equations.

    Attributes
    ----------
    provenance : Provenance
        What the motion was computed from.
    coordinate_names, speed_names : tuple of str
        What the equations have to have.
    near : mapping of coordinate to float
        Where the motion starts.
    """

    provenance: Provenance
    coordinate_names: Names
    speed_names: Names
    near: Mapping[str, float]
    _made: SingleFlight[None, Evaluator] = field(default_factory=SingleFlight, repr=False)

    @property
    def wrapped_angles(self) -> tuple[str, ...]:
        """Angles of cut joints, which are given within half a turn."""
        return self._made.get(None, self._evaluator).wrapped_angles

    def together(self, names: Sequence[str], t: Floats, q: Floats, u: Floats) -> list[Floats]:
        """Return outputs with time last, all from one compiled function.

        Raises UsageError if one cannot be computed from the file.
        """
        for name in names:
            self._check(name)
        computed = self._made.get(None, self._evaluator).together(names, t, q, u)
        missing = self.provenance.missing_inputs
        for name, values in zip(names, computed, strict=True):
            if missing and not np.isfinite(values).all():
                listed = ", ".join(missing)
                why = f"it depends on {listed}, whose value was a Python function, which files cannot store"
                raise _unknown_output(name, why)
        return computed

    def _check(self, name: str) -> None:
        if name == "work":
            raise _unknown_output(
                name, "it was integrated during the motion; the file has it at the samples only"
            )
        kinematic = name.startswith(_KINEMATIC) or name in (*_ENERGIES, *self.coordinate_names)
        if self.provenance.switches and not kinematic:
            raise _unknown_output(
                name, "joints stuck or gaps closed or opened during the motion, which changes the equations"
            )

    def _evaluator(self) -> Evaluator:
        source = self.provenance
        try:
            eqs = form_equations(
                source.model,
                tree=source.trees,
                dependent_speeds=source.dependent_speeds or None,
                substitute=source.substitutes,
            )
        except TopologyError as error:  # the model lacks joints that gave the coordinates
            raise _another_model(source.model, error.problems[0].what) from error
        check_names(eqs, self.coordinate_names, self.speed_names)
        laws: dict[str, Callback] = {**held_later(eqs, source.missing_inputs)}  # not numbers
        laws |= {} if source.held is None else {n: HeldLaw(source.held, n) for n in source.held.names}
        laws |= {name: table.reader() for name, table in source.tables.items()}
        callbacks = {name: laws[name] for name in eqs.input_names if name in laws}
        tables = {k: source.tables[name] for k, name in enumerate(callbacks) if name in source.tables}
        known = InputLaws(source.inputs, callbacks, (), tables)
        scales = mechanism_scales(eqs, source.given, near=self.near)
        return Evaluator(SimulationProblem(eqs, source.given, known, scales), None)


def provenance_for(model: Model, coordinate_names: Names, speed_names: Names) -> Provenance:
    """Return what a motion of a model was probably computed from: its values, and trees that fit the names.

    Raises UsageError if no usual choice of trees has these coordinates and speeds.
    """
    choices: tuple[TreeChoice, ...] = (None, "joints", "absolute")
    for substitutes, choice in product((False, True), choices):
        eqs = form_equations(model, tree=choice, substitute=substitutes)
        if (eqs.coordinate_names, eqs.speed_names) == (coordinate_names, speed_names):
            topology = eqs.formed.topology
            joints = [joint.name for joint in model.joints]
            rotation = [name for name in joints if name in topology.rotation_branches]
            trees = Trees(rotation, [name for name in joints if name in topology.translation_branches])
            inputs = dict.fromkeys(model.inputs, 0)
            return Provenance(model, {}, trees, inputs=inputs, substitutes=substitutes)
    check_names(form_equations(model), coordinate_names, speed_names)
    raise AssertionError("names that differ were rejected")


def check_names(eqs: EquationSet, coordinate_names: Names, speed_names: Names) -> None:
    """Refuse equations of another mechanism than the one that moved.

    Raises UsageError if coordinates or speeds differ.
    """
    if (eqs.coordinate_names, eqs.speed_names) == (coordinate_names, speed_names):
        return
    ours, theirs = ", ".join(coordinate_names), ", ".join(eqs.coordinate_names)
    raise _another_model(eqs.model, f"its coordinates are {ours}; those of the model are {theirs}")


def _another_model(model: Model, why: str) -> UsageError:
    return UsageError(
        Problem("trajectory.another_model", model.name, "the motion is not one of this model", why,
                "give the model that the motion was computed from")
    )  # fmt: skip


def _unknown_output(name: str, why: str) -> UsageError:
    return UsageError(
        Problem("trajectory.not_computable", repr(name), f"{name} cannot be computed from the file", why,
                f"store it with the motion: run.save(path, {name!r})")
    )  # fmt: skip
