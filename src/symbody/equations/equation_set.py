"""`EquationSet`: the equations of motion of a model as formulas, and as roots of outputs for code."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from collections.abc import Sequence as Items
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import symbody.equations.outputs as outputs
from symbody.arguments import checked_arguments
from symbody.equations.cache_key import DeferredEquations
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.freedoms.always_undetermined import find_always_undetermined
from symbody.equations.freedoms.mobility import Mobility, mobility
from symbody.equations.names import NamedEquations, OrderedNames, names_of
from symbody.equations.outputs.output_roots import code_roots, evaluable_roots
from symbody.equations.outputs.printed_equations import PrintedEquations
from symbody.equations.outputs.units import Units, output_units
from symbody.equations.solving.negligible_constraints import drop_rows, magnitude_program, negligible_rows
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.errors import number_in_words
from symbody.expr.graph import Symbol
from symbody.expr.rewrite import operation_count
from symbody.expr.sequences.sequence import Roots, Sequence
from symbody.expr.sympy.sympy_bridge import SympyEquation, SympyExpr, SympyMatrix, to_sympy
from symbody.model.model import Model
from symbody.model.output_names import (
    ACCELERATIONS,
    INPUTS,
    MULTIPLIERS,
    POSITIONS,
    SIGNALS,
    SPEEDS,
    ListedOutput,
    list_readable,
    parse_derivative,
)
from symbody.single_flight import SingleFlight

if TYPE_CHECKING:
    from symbody.equations.outputs.output_table import OutputTable
    from symbody.equations.outputs.textbook import Reaction, Textbook


@dataclass(frozen=True, eq=False, slots=True)
class EquationSet(PrintedEquations, NamedEquations):
    """Equations of motion ``M u' = F + J^T lambda``, ``J u' = gamma``, ``q' = N u + nu`` of a model.

    Every property that shows formulas returns SymPy objects in dynamicsymbols; the numbers come from
    the expression graph behind them, through `compile` and `simulate`.

    Attributes
    ----------
    model : Model
        The mechanism.
    formed : EquationsOfMotion
        The equations in the expression graph. If an earlier process formed the same ones without an error,
        they are formed when this is first read.
    notes : tuple of str
        Every choice that was made, with its reason.
    further : mapping of name to Roots
        Outputs beside those that every set of equations has.
    identity : bytes
        A hash of all that the equations follow from; empty if it cannot be computed.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass="m"), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness="k"))
    >>> model = sb.Model("oscillator", [rail], parameters={"m": 2, "k": 8}, inputs=["F"])
    >>> eqs = sb.form_equations(model)
    >>> eqs.mass_matrix, eqs.forcing, eqs.state_names
    (Matrix([[m]]), Matrix([[-k*x(t) + F(t)]]), ('x_dot', 'x'))
    """

    model: Model
    _given: EquationsOfMotion | DeferredEquations
    notes: tuple[str, ...] = ()
    further: Mapping[str, Roots] = field(default_factory=dict, repr=False)
    # Roots and formulas already made; pure functions of `formed`, so they cannot go stale.
    _roots: SingleFlight[str, Roots] = field(default_factory=SingleFlight, repr=False)
    _textbook: SingleFlight[None, Textbook] = field(default_factory=SingleFlight, repr=False)
    _names: OrderedNames | None = field(default=None, repr=False)
    # What later stages compute from these equations, and from formulas of callers, which may be many.
    plans: SingleFlight[Hashable, Any] = field(default_factory=partial(SingleFlight, 512), repr=False)
    variants: SingleFlight[Hashable, Any] = field(default_factory=partial(SingleFlight, 16), repr=False)
    identity: bytes = field(default=b"", repr=False)
    # Forms the same equations in another process, where that is less than to hand them over.
    _again: Callable[[], EquationSet] | None = field(default=None, repr=False)

    def __reduce__(self) -> tuple[Callable[..., EquationSet], tuple[object, ...]]:
        if self._again is not None:
            return self._again, ()
        return EquationSet, (self.model, self.formed, self.notes, self.further)

    def __deepcopy__(self, memo: object) -> EquationSet:
        return self  # nothing of it can be changed

    def __repr__(self) -> str:
        numbers = {"coordinate": self.formed.q, "speed": self.formed.u, "constraint": self.formed.rows}
        sizes = ", ".join(number_in_words(len(those), word) for word, those in numbers.items())
        return f"EquationSet of {self.model.name!r}: {sizes}"

    @property
    def formed(self) -> EquationsOfMotion:
        """The equations in the expression graph."""
        return self._given.equations if isinstance(self._given, DeferredEquations) else self._given

    @property
    def are_formed(self) -> bool:
        """Whether `formed` has been read."""
        return not isinstance(self._given, DeferredEquations) or self._given.are_formed

    @property
    def names(self) -> OrderedNames:
        """Names of all that has a place in an array."""
        if self._names is None:  # two threads may both make them
            object.__setattr__(self, "_names", names_of(self.formed))
        return self._names or names_of(self.formed)

    @property
    def units(self) -> Units:
        """SI units of coordinates, rates, energies, efforts, reactions and frames, where derivable."""
        units: Units = self.plans.get("units", partial(output_units, self.formed))
        return units

    @property
    def listed_outputs(self) -> list[ListedOutput]:
        """What can be read of these equations, by headings; of frames the motions seen from ground."""
        names, signals = self.names, self.model.signals
        symbols = {
            POSITIONS: names.coordinates,
            SPEEDS: names.speeds,
            ACCELERATIONS: names.accelerations,
            INPUTS: names.inputs,
            SIGNALS: [*(signal.name for signal in signals), *(f"{name}_dot" for name in names.signals)],
            MULTIPLIERS: names.multipliers,
        }
        return list_readable(self.formed.topology.output_scope, symbols)

    def outputs(self) -> OutputTable:
        """Return what can be computed of these equations by name: shapes, units and what each is.

        The table can be searched and is shown by notebooks; `compile`, `generate_code`, results, events and
        formulas (in quotes) take its names. Beside these there are derivatives such as ``"d udot/d q"``,
        motions of any two frames, ``"frame v A.tip B"``, and expressions in all names.

        Returns
        -------
        OutputTable
            A tuple of (name, shape, unit, meaning, title).

        Examples
        --------
        >>> import symbody as sb
        >>> joint = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
        >>> eqs = sb.form_equations(sb.Model("cart", [joint]))
        >>> eqs.outputs().search("energy").names
        ('kinetic_energy', 'potential_energy', 'energy')
        >>> eqs.outputs().search("mass matrix")[0].shape
        (1, 1)
        """
        names, holonomic = self.names, len(self.formed.holonomic)
        sizes = {"n_u": len(names.speeds), "n_q": len(names.coordinates), "n_s": len(names.signals)}
        sizes |= {"n_x": len(names.states), "n_r": len(names.inputs), "n_c": len(names.multipliers)}
        sizes["n_h"] = holonomic
        table = outputs.output_table.output_table
        return table(self.listed_outputs, self.formed.topology.output_scope, self.units, sizes)

    @property
    def coordinates(self) -> tuple[SympyExpr, ...]:
        """Coordinates q as dynamicsymbols."""
        return self._symbols(self.formed.q)

    @property
    def speeds(self) -> tuple[SympyExpr, ...]:
        """Speeds u; those that are rates are derivatives of the coordinates."""
        return self._symbols(self.formed.u)

    @property
    def signal_states(self) -> tuple[SympyExpr, ...]:
        """States s of signals as dynamicsymbols."""
        return self._symbols(self.formed.signal_states)

    @property
    def states(self) -> tuple[SympyExpr, ...]:
        """Speeds, then coordinates, then the states of signals."""
        return self.speeds + self.coordinates + self.signal_states

    @property
    def inputs(self) -> tuple[SympyExpr, ...]:
        """Inputs r as dynamicsymbols."""
        return self._symbols(self.formed.inputs)

    @property
    def parameters(self) -> tuple[SympyExpr, ...]:
        """Parameters as symbols."""
        return self._symbols(self.formed.parameters)

    @property
    def multipliers(self) -> tuple[SympyExpr, ...]:
        """Multipliers lambda; none in a tree."""
        return self._symbols(self.formed.multipliers)

    @property
    def mass_matrix(self) -> SympyMatrix:
        """M, (n_u, n_u), symmetric."""
        return self.textbook.matrix("mass_matrix")

    @property
    def forcing(self) -> SympyMatrix:
        """F, (n_u, 1): everything but ``M u'`` and the multipliers, on the right-hand side."""
        return self.textbook.matrix("forcing")

    @property
    def constraints(self) -> SympyMatrix:
        """Position constraints Phi, (n_h, 1); none in a tree."""
        return self.textbook.matrix("constraints")

    @property
    def constraint_jacobian(self) -> SympyMatrix:
        """J in the speeds, (n_c, n_u); no rows in a tree."""
        return self.textbook.matrix("jacobian")

    @property
    def velocity_constraints(self) -> SympyMatrix:
        """``J u + b``, (n_c, 1), zero in every motion; none in a tree."""
        return self.textbook.matrix("velocity_constraints")

    @property
    def position_jacobian(self) -> SympyMatrix:
        """Derivatives of Phi with respect to the coordinates, (n_h, n_q)."""
        return self.textbook.matrix("position_jacobian")

    @property
    def invariants(self) -> tuple[SympyExpr, ...]:
        """Quantities that are 1 in every motion: squared norms of quaternions."""
        return self.textbook.norms

    @property
    def A(self) -> SympyMatrix:
        """Derivatives of x' with respect to the states (u, q, s), (n_x, n_x), the others held fixed."""
        return self.textbook.derivatives("A")

    @property
    def B(self) -> SympyMatrix:
        """Derivatives of x' with respect to the inputs, (n_x, n_r)."""
        return self.textbook.derivatives("B")

    @property
    def kinetic_energy(self) -> SympyExpr:
        """Kinetic energy relative to ground [J]."""
        return self.textbook.matrix("kinetic_energy")[0]

    @property
    def potential_energy(self) -> SympyExpr:
        """Potential energy of gravity and springs [J], zero at the origin and at the free lengths."""
        return self.textbook.matrix("potential_energy")[0]

    @property
    def kinematic_equations(self) -> list[SympyEquation]:
        """``q' = N u + nu``, one equation a coordinate."""
        return self.textbook.equations("rates", "qdot")

    def dynamic_equations(self) -> list[SympyEquation]:
        """Return ``M u' = F + J^T lambda``, one equation a speed, in the order of `speeds`."""
        return self.textbook.equations("inertial", "driving")

    @property
    def definitions(self) -> tuple[tuple[SympyExpr, SympyExpr], ...]:
        """Pairs (z1, expression), ... that all formulas of this set are written in, each by earlier ones.

        Empty while no entry exceeds 20,000 operations written out.
        """
        return self.textbook.definitions

    @property
    def independent_speeds(self) -> tuple[SympyExpr, ...]:
        """Speeds that determine all others on the branch of the initial values, the earliest possible."""
        return self._symbols(tuple(self.formed.u[k] for k in self.mobility.independent_speeds))

    @property
    def degrees_of_freedom(self) -> int:
        """Dimension of the branch of the initial values; see `mobility`."""
        return self.mobility.degrees_of_freedom

    @property
    def mobility(self) -> Mobility:
        """Degrees of freedom for the model's values, those for an instant at a change point, and notes.

        Where the initial values do not close the loops, the nearest configuration that does counts.

        Raises
        ------
        AssemblyError, ModelError
            If the loops do not close from any of several starts, or a parameter has no value.
        """
        return mobility(self.formed)

    @property
    def undetermined_reactions(self) -> tuple[str, ...]:
        """Outputs that the motion does not determine for any values of the parameters.

        Components of reactions, "reaction J Fz", and efforts that hold motions, "effort J", of loops with
        redundant constraints. As outputs they have the minimum-norm solution. What values of the parameters
        leave undetermined in addition is reported by `redundancy` and the notes of a run.
        """
        names: tuple[str, ...] = self.plans.get(
            "undetermined reactions", partial(find_always_undetermined, self.formed)
        )
        return names

    @checked_arguments
    def for_values(self, parameters: Mapping[str, float]) -> EquationSet:
        """Return these equations with the constraints that some values of the parameters fulfil set to 0 = 0.

        The solver drops an exact row of zeros, but would take one that is zero up to rounding for a
        constraint. `compile` does this.

        Parameters
        ----------
        parameters : mapping of name to float
            Parameters not named may have any value.

        Raises
        ------
        FormulationError
            If a constraint on parameters alone excludes these values.
        """
        check_parameter_constraints(self.formed, parameters)
        program: Sequence = self.plans.get("noise program", partial(magnitude_program, self.formed))
        return self.without_rows(negligible_rows(self.formed, parameters, program))

    def without_rows(self, silent: Items[bool]) -> EquationSet:
        """Return these equations with some constraints set to 0 = 0; the same rows give the same object."""
        if not any(silent):
            return self
        changed: EquationSet = self.plans.get(("without rows", tuple(silent)), lambda: self._drop(silent))
        return changed

    def _drop(self, silent: Items[bool]) -> EquationSet:
        formed = drop_rows(self.formed, silent)
        return self if formed is self.formed else EquationSet(self.model, formed, self.notes)

    @property
    def textbook(self) -> Textbook:
        """The same equations as formulas."""
        return self._textbook.get(None, partial(outputs.textbook.Textbook, self.formed))

    @checked_arguments
    def operation_count(self, *outputs: str) -> int:
        """Return the operations of a shared evaluation of `outputs`, parameters as symbols."""
        nodes = [node for name in outputs for node in self.roots(name).nodes]
        return operation_count(self.formed.graph, nodes)

    @checked_arguments
    def roots(self, name: str) -> Roots:
        """Return the roots of an output in the expression graph; see `evaluable_roots`."""
        if name in self.further:
            return self.further[name]
        return self._roots.get(name, lambda: evaluable_roots(self.formed, name))

    @checked_arguments
    def code_roots(self, name: str) -> Roots:
        """Return the roots of an output for machine code: derivatives as programs for several columns."""
        if parse_derivative(name) is None:
            return self.roots(name)
        roots: Roots = self.plans.get(("code", name), lambda: code_roots(self.formed, name))
        return roots

    @checked_arguments
    def frame_motion(
        self, kind: str, end: str, reference: str = "ground", resolved_in: str = "ground"
    ) -> SympyMatrix:
        """Return the motion of one frame relative to another as formulas.

        Parameters
        ----------
        kind : str
            "r" position of end's origin [m], "v" and "vdot" its first and second time derivative as seen from
            the reference; "R" the rotation matrix that takes components in end to components in the
            reference; "w" and "wdot" the angular velocity and its time derivative as seen from the reference.
        end, reference, resolved_in : str
            "Body.Frame", "Body" or "ground"; components are along the axes of the last, which "R"
            does not use.

        Returns
        -------
        (3, 1) or (3, 3) Matrix
            In coordinates, speeds and their derivatives.

        Raises
        ------
        FormulationError
            If the kind or a frame is unknown.
        """
        return self.textbook.frame_motion(kind, end, reference, resolved_in)

    @checked_arguments
    def reaction(self, joint: str, on: str = "", at: str = "", frame: str = "") -> Reaction:
        """Return the reaction of a joint in q, u, u' and the multipliers, those of redundant rows too.

        Where constraints hold identically their multipliers ``lambda_<joint>_<k>`` are among them: any values
        fit the motion. The output "reaction J" has those of least norm.

        Parameters
        ----------
        joint : str
            Name of the joint.
        on : str, optional
            The body it acts on; by default the end body.
        at : str, optional
            The frame whose origin the moment is about; by default the end frame of the joint.
        frame : str, optional
            The axes of the components; by default the start frame of the joint.

        Raises
        ------
        FormulationError
            If a name is unknown, or the joint does not act on the body.
        """
        return self.textbook.reaction(joint, on, at, frame)

    def _symbols(self, symbols: tuple[Symbol, ...]) -> tuple[SympyExpr, ...]:
        graph = self.formed.graph
        return tuple(to_sympy(graph, [graph.symbol(symbol) for symbol in symbols]))
