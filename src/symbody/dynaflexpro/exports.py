"""What a built model exports: vectors, matrices and equations under their names in DynaFlexPro."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.textbook import Reaction
from symbody.errors import Problem, UsageError
from symbody.expr.expression import Expr
from symbody.expr.graph import TIME, Symbol, SymbolKind
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.sympy.closed_form import closed_forms
from symbody.expr.sympy.sympy_writer import SympyEquation, SympyExpr, SympyMatrix, symbol_to_sympy, to_sympy

Substitutions = Mapping[SympyExpr, object] | Iterable[SympyEquation]


@dataclass(slots=True)
class ModelEquations:
    """Equations of motion ``xM vPdot = vF + xJacVel^T f``, ``xJacVel vP = vVelRHS`` of a model.

    States are the speeds, then the coordinates. Multipliers f stand on the right with a plus, and a reaction
    is the wrench on the end body of a joint by its start body. DynaFlexPro's successor writes both on the
    left, ``M p' + C^T f = F`` and ``M p' + Psi_p^T lambda = F``: its f and lambda have the opposite sign.

    Attributes
    ----------
    equations : EquationSet
        What is exported, under symbody's own names; what `compile` and `simulate` take.
    """

    equations: EquationSet
    built: tuple[str, ...] = ()
    _formed: EquationSet = field(init=False)  # without stabilization
    _baumgarte: tuple[float, float] = field(init=False, default=(0.0, 0.0))

    def __post_init__(self) -> None:
        self._formed = self.equations

    @property
    def notes(self) -> tuple[str, ...]:
        """Every choice that was made, and where the angle rates are singular."""
        return self.built + self.equations.notes

    @property
    def vQ(self) -> SympyMatrix:
        """Coordinates, (n_q, 1)."""
        return _column(self.equations.coordinates)

    @property
    def vP(self) -> SympyMatrix:
        """Speeds, (n_u, 1)."""
        return _column(self.equations.speeds)

    @property
    def vX(self) -> SympyMatrix:
        """States: speeds, then coordinates."""
        return _column(self.equations.states)

    @property
    def vQdot(self) -> SympyMatrix:
        """Time derivatives of the coordinates."""
        return self.vQ.diff(symbol_to_sympy(TIME))

    @property
    def vPdot(self) -> SympyMatrix:
        """Time derivatives of the speeds."""
        return self.vP.diff(symbol_to_sympy(TIME))

    @property
    def vXdot(self) -> SympyMatrix:
        """Time derivatives of the states."""
        return self.vX.diff(symbol_to_sympy(TIME))

    @property
    def xM(self) -> SympyMatrix:
        """Mass matrix, (n_u, n_u), symmetric."""
        return self.equations.mass_matrix

    @property
    def vF(self) -> SympyMatrix:
        """Right-hand side, (n_u, 1): loads, weight and terms quadratic in the speeds, no multipliers."""
        return self.equations.forcing

    @property
    def vLambda(self) -> SympyMatrix:
        """Multipliers f, (n_c, 1)."""
        return _column(self.equations.multipliers)

    @property
    def vKinTransRHS(self) -> SympyMatrix:
        """What vQdot is in the speeds, (n_q, 1)."""
        return _column(equation.rhs for equation in self.equations.kinematic_equations)

    @property
    def xJacPos(self) -> SympyMatrix:
        """Derivatives of the position constraints by vQ, (n_h, n_q)."""
        return self.equations.position_jacobian

    @property
    def xJacVel(self) -> SympyMatrix:
        """Coefficients of vP in the velocity constraints, (n_c, n_u)."""
        return self.equations.constraint_jacobian

    @property
    def vVelRHS(self) -> SympyMatrix:
        """Right-hand side of ``xJacVel vP = vVelRHS``, (n_c, 1); zero unless a motion is prescribed."""
        formed = self.equations.formed
        return _column(-rest for rest in to_sympy(formed.graph, [row.drift.index for row in formed.rows]))

    @property
    def vAccRHS(self) -> SympyMatrix:
        """Right-hand side of ``xJacVel vPdot = vAccRHS``, (n_c, 1)."""
        formed = self._formed
        gamma = formed.textbook.readable("gamma")
        plain = closed_forms(formed.formed.graph, [gamma], EXPAND_LIMIT).matrices["gamma"]
        alpha, beta = self._baumgarte
        if not alpha and not beta:
            return plain
        opened = formed.constraints  # of rows on velocities alone there is none
        opened = opened.col_join(opened.zeros(plain.rows - opened.rows, 1))
        return plain - 2 * alpha * formed.velocity_constraints - beta**2 * opened

    def GetDynEQs(self) -> list[SympyEquation]:
        """Return ``xM vPdot = vF + xJacVel^T f``, one equation a speed."""
        return self.equations.dynamic_equations()

    def GetKinTrans(self) -> list[SympyEquation]:
        """Return the rates of the coordinates in the speeds.

        Where a value of `GetKinTransSingularities` vanishes they do not exist.
        """
        return self.equations.kinematic_equations

    def GetKinTransSingularities(self) -> dict[str, SympyExpr]:
        """Return, by joint, the expression that must not vanish: ``sin(eta)`` for Euler angles 3-1-3."""
        found = self.equations.formed.variables.singularities
        nodes = [expression.index for expression in found.values()]
        return dict(zip(found, to_sympy(self.equations.formed.graph, nodes), strict=True))

    def GetPosCons(self) -> list[SympyEquation]:
        """Return the position constraints ``Phi = 0``; none in a tree."""
        return _zero_equations(self.equations.constraints)

    def GetVelCons(self) -> list[SympyEquation]:
        """Return the velocity constraints ``xJacVel vP - vVelRHS = 0``; none in a tree."""
        return _zero_equations(self.equations.velocity_constraints)

    def GetAccCons(self) -> list[SympyEquation]:
        """Return the acceleration constraints ``xJacVel vPdot = vAccRHS``; none in a tree."""
        if not self.equations.multiplier_names:
            return []
        pairs = zip(self.xJacVel * self.vPdot, self.vAccRHS, strict=True)
        return [SympyEquation(left, right, evaluate=False) for left, right in pairs]

    def SetBaumgarte(self, pair: Sequence[float] | None = None) -> tuple[float, float]:
        """Set alpha and beta [1/s] if they are given, and return what holds from now on; (0, 0) at first.

        With position constraints Psi their second derivative chi is replaced by
        ``chi + 2 alpha Psi' + beta^2 Psi``, from now on in everything this model exports that contains
        accelerations: in `vAccRHS`, in `GetAccCons`, and in what `BuildSimCode` computes. Values of 1 to 10
        are usual; a velocity constraint has no last term.

        Raises
        ------
        UsageError
            If there are not two numbers >= 0.
        """
        if pair is not None:
            self._baumgarte = _check_pair(pair)
            self.equations = _stabilize(self._formed, *self._baumgarte)
        return self._baumgarte

    def GetSysODEs(self) -> list[SympyEquation]:
        """Return the dynamic equations, then the rates of the coordinates that are not speeds themselves."""
        trivial = set(self.equations.speeds)
        return self.GetDynEQs() + [rate for rate in self.GetKinTrans() if rate.lhs not in trivial]

    def GetSysEQs(self) -> list[SympyEquation]:
        """Return `GetSysODEs` and the constraints in acceleration form: as many as unknowns vXdot and f."""
        return self.GetSysODEs() + self.GetAccCons()

    def GetFrameMotion(
        self, kind: str, end: str, start: str = "Ground", ref: str = "Ground", subs: Substitutions = ()
    ) -> SympyMatrix:
        """Return the motion of frame `end` relative to `start`, components in `ref`.

        Parameters
        ----------
        kind : str
            "r", "v", "vdot": position, velocity, acceleration; "R": rotation matrix, which has no `ref`;
            "w", "wdot": angular velocity and acceleration. Derivatives are those seen from `start`.
        subs : mapping or equations, optional
            Put in for symbols and functions, ``[Eq(a, b)]`` or ``{a: b}``.
        """
        motion = self.equations.frame_motion(kind, end, start, ref)
        given = subs if isinstance(subs, Mapping) else {equation.lhs: equation.rhs for equation in subs}
        return motion.subs(dict(given)).doit() if given else motion

    def GetReaction(self, joint: str, on: str = "", at: str = "", ref: str = "") -> Reaction:
        """Return force and moment of a joint on its end body in `vLambda`; see `EquationSet.reaction`.

        Multipliers of constraints that hold identically, which any values fit, are 0 here.
        """
        found = self.equations.reaction(joint, on, at, ref)
        formed = self.equations.formed
        symbols = [formed.graph.symbol(Symbol(row.name, SymbolKind.MULTIPLIER)) for row in formed.redundant]
        idle = dict.fromkeys(to_sympy(formed.graph, symbols), 0)
        return Reaction(found.force.subs(idle), found.moment.subs(idle)) if idle else found

    def GetParams(self) -> list[SympyExpr]:
        """Return the parameters."""
        return list(self.equations.parameters)


def _column(entries: Iterable[SympyExpr]) -> SympyMatrix:
    values = list(entries)
    return SympyMatrix(len(values), 1, values)


def _zero_equations(column: SympyMatrix) -> list[SympyEquation]:
    return [SympyEquation(entry, 0, evaluate=False) for entry in column]


def _check_pair(pair: Sequence[float]) -> tuple[float, float]:
    """Return alpha and beta as they are.

    Raises
    ------
    UsageError
        If there are not two finite numbers >= 0.
    """
    values = list(pair) if isinstance(pair, Iterable) else [pair]
    numbers = all(isinstance(value, int | float) and 0 <= value < math.inf for value in values)
    if len(values) != 2 or not numbers:
        raise UsageError(
            Problem("dynaflexpro.baumgarte", "SetBaumgarte", f"{values} are not two numbers >= 0",
                    "", "give alpha and beta, for instance SetBaumgarte([5, 5]); [0, 0] switches it off")
        )  # fmt: skip
    return values[0], values[1]


def _stabilize(eqs: EquationSet, alpha: float, beta: float) -> EquationSet:
    """Return equations whose constraints decay like ``Psi'' + 2 alpha Psi' + beta^2 Psi = 0``."""
    if not alpha and not beta:
        return eqs
    graph, rows = eqs.formed.graph, []
    for row in eqs.formed.rows:
        rate = row.drift
        for speed, slope in row.jacobian.items():
            rate = rate + slope * Expr(graph, speed)
        rows.append(replace(row, gamma=row.gamma - (rate * (2 * alpha) + row.value * beta**2)))
    return EquationSet(eqs.model, eqs.formed.with_rows(tuple(rows)), eqs.notes)
