"""Analyses of closed loops beside the same steps written with SymPy alone.

SymPy starts from the same formulas: constraints, mass matrix and forcing. It differentiates them, makes
functions of them by lambdify, and finds roots by nsolve from the same guess. Every task includes all that a
user waits for who has the equations, compiling too; symbody checks ranks, looks for other equilibria and
names faults besides, which makes a single small question slower, not faster.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from benchmarks.table import Table, difference_text, ratio_text, seconds_text
from benchmarks.timing import Settings, in_turns, medians, seconds

Floats = NDArray[np.float64]

_TIMES: Final = np.linspace(0.0, 1.0, 11)
_AT: Final = 0.7


@dataclass(frozen=True, slots=True)
class Loop:
    """A mechanism with one freedom, that of its first coordinate, driven by the torque T."""

    eqs: sb.EquationSet
    near: Mapping[str, float]
    beside: Mapping[str, float]  # an equilibrium

    @property
    def angle(self) -> str:
        """The coordinate that is given."""
        return self.eqs.coordinate_names[0]


def bar(name: str, length: float) -> sb.Body:
    """Return a bar of 1 kg a metre with a frame at either end."""
    ends = {"a": sb.Frame((-length / 2, 0, 0)), "b": sb.Frame((length / 2, 0, 0))}
    return sb.Body(name, length, (0, 0, length**3 / 12), frames=ends)


def slider_crank() -> Loop:
    """Return a crank, a rod and a slider."""
    parts = [
        *(bar("crank", 0.3), bar("rod", 1.1), sb.Body("slider", 0.5, (0, 0, 1))),
        sb.Revolute("A", "ground", "crank.a", coordinate="theta", torque=sb.Drive(applied="T")),
        sb.Revolute("B", "crank.b", "rod.a", coordinate="beta"),
        sb.Prismatic("D", "ground", "slider", axis="x", coordinate="s", force=sb.Drive(stiffness=40, free=1)),
        sb.Revolute("C", "slider", "rod.b", tree=False),
    ]
    model = sb.Model("slider-crank", parts, gravity=(0, -9.81, 0), inputs=["T"])
    return Loop(
        sb.form_equations(model),
        {"theta": _AT, "beta": -0.9, "s": 1.3},
        {"theta": -0.1, "beta": -3.0, "s": -0.8},
    )


def six_bar() -> Loop:
    """Return a four-bar whose rocker moves a slider by a rod."""
    parts = [
        *(bar("crank", 0.2), bar("coupler", 0.6), bar("rocker", 0.5), bar("rod", 0.8)),
        sb.Body("slider", 0.5, (0, 0, 1)),
        sb.Revolute("A", "ground", "crank.a", coordinate="alpha", torque=sb.Drive(applied="T")),
        sb.Revolute("B", "crank.b", "coupler.a", coordinate="beta"),
        sb.Revolute("D", "ground.foot", "rocker.a", coordinate="gamma"),
        sb.Revolute("E", "rocker.b", "rod.a", coordinate="delta"),
        sb.Prismatic("F", "ground.rail", "slider", axis="x", coordinate="s",
                     force=sb.Drive(stiffness=40, free=1)),
        sb.Revolute("C", "coupler.b", "rocker.b", tree=False),
        sb.Revolute("G", "slider", "rod.b", tree=False),
    ]  # fmt: skip
    ground = {"foot": sb.Frame((0.7, 0, 0)), "rail": sb.Frame((0, 0.4, 0))}
    model = sb.Model("six-bar", parts, gravity=(0, -9.81, 0), inputs=["T"], ground=ground)
    near = {"alpha": _AT, "beta": -0.2, "gamma": 1.8, "delta": -1.9, "s": 1.4}
    beside = {"alpha": 0.8, "beta": -0.1, "gamma": 1.7, "delta": -1.8, "s": 1.4}
    return Loop(sb.form_equations(model), near, beside)


LOOPS: Final[Mapping[str, Callable[[], Loop]]] = MappingProxyType(
    {"slider-crank": slider_crank, "six-bar": six_bar}
)


class ByHand:
    """The formulas of a loop in SymPy's plain symbols, and the steps of each analysis."""

    def __init__(self, loop: Loop) -> None:
        eqs = loop.eqs
        self.loop, count = loop, len(eqs.coordinate_names)
        self.q, self.u = (sp.symbols(f"{letter}:{count}") for letter in "qu")
        self.lam, self.T = sp.symbols(f"l:{len(eqs.multiplier_names)}"), sp.Symbol("T")
        plain = {**dict(zip(eqs.speeds, self.u, strict=True)), dynamicsymbols("T"): self.T}
        parts = (eqs.mass_matrix, eqs.forcing, eqs.constraints)
        M, F, Phi = (sp.Matrix(part).subs(plain).subs(dict(zip(eqs.coordinates, self.q, strict=True)))
                     for part in parts)  # fmt: skip
        self.M, self.F, self.Phi = M, F, Phi

    def positions(self, angle: float, near: list[float]) -> list[float]:
        """Return the coordinates at an angle."""
        rows = list(self.Phi.subs(self.q[0], angle))
        return [angle, *map(float, sp.nsolve(rows, self.q[1:], near[1:]))]

    def assembly(self) -> Floats:
        """Return the coordinates where the first is given."""
        return np.array(self.positions(_AT, list(self.loop.near.values())))

    def velocity_ratios(self) -> Floats:
        """Return tau there."""
        # SymPy's own LUsolve takes a pivot that vanishes unnoticed here, and loses all but two digits.
        J = sp.lambdify(self.q, self.Phi.jacobian(self.q))(*self.assembly())
        return np.asarray(np.linalg.solve(J[:, 1:], -J[:, 0]))

    def equilibrium(self) -> Floats:
        """Return the coordinates at rest, T = 0, nearest to the guess."""
        still = dict.fromkeys((*self.u, self.T), 0)
        rows = [*(self.F.subs(still) + self.Phi.jacobian(self.q).T * sp.Matrix(self.lam)), *self.Phi]
        near = list(self.loop.beside.values())
        forces, jacobian = sp.lambdify(self.q, (self.F.subs(still), self.Phi.jacobian(self.q)))(*near)
        start = [*near, *np.linalg.lstsq(jacobian.T, -forces[:, 0], rcond=None)[0]]
        found = sp.nsolve(rows, (*self.q, *self.lam), start)
        return np.array(found, dtype=float)[: len(self.q), 0]

    def linearization(self) -> Floats:
        """Return the eigenvalues about that equilibrium, by the null space of J."""
        J = self.Phi.jacobian(self.q)
        forces = self.F + J.T * sp.Matrix(self.lam)
        blocks = (self.M, J, self.F, forces.jacobian(self.q), forces.jacobian(self.u))
        f = sp.lambdify((*self.q, *self.u, *self.lam, self.T), blocks)
        q, zero = self.equilibrium(), [0.0] * len(self.q)
        _, rows, F, _, _ = f(*q, *zero, *(0.0 for _ in self.lam), 0.0)
        lam = np.linalg.lstsq(rows.T, -F[:, 0], rcond=None)[0]
        M, rows, _, K, C = f(*q, *zero, *lam, 0.0)
        Z = np.linalg.svd(rows)[2][len(self.lam) :].T
        mass, stiffness, damping = (Z.T @ part @ Z for part in (M, K, C))
        A = np.block([[np.linalg.solve(mass, damping), np.linalg.solve(mass, stiffness)],
                      [np.eye(1), np.zeros((1, 1))]])  # fmt: skip
        return np.sort(np.abs(np.linalg.eigvals(A)))

    def inverse_dynamics(self) -> Floats:
        """Return the torque of a uniform turn at some times."""
        J = self.Phi.jacobian(self.q)
        rate = (J * sp.Matrix(self.u)).jacobian(self.q) * sp.Matrix(self.u)
        f = sp.lambdify((*self.q, *self.u), (self.M, self.F.subs(self.T, 0), J, rate))
        q, torques = list(self.loop.near.values()), []
        for time in _TIMES:
            q = self.positions(_AT + time, q)
            J_now = f(*q, *(0.0 for _ in q))[2]
            u = np.array([1.0, *np.linalg.solve(J_now[:, 1:], -J_now[:, 0])])
            M, F, J_now, bias = f(*q, *u)
            a = np.array([0.0, *np.linalg.solve(J_now[:, 1:], -bias[:, 0])])
            columns = np.column_stack([np.eye(len(q))[:, 0], J_now.T])
            torques.append(np.linalg.solve(columns, M @ a - F[:, 0])[0])
        return np.array(torques)


def ours(loop: Loop, task: str) -> Floats:
    """Return the same numbers by symbody's functions."""
    eqs, angle, near = loop.eqs, loop.angle, dict(loop.near)
    guess = {name: value for name, value in near.items() if name != angle}
    found: Any
    if task == "assembly":
        found = list(sb.assemble(eqs, {angle: _AT}, guess).q.values())
    elif task == "velocity_ratios":
        ratios = sb.velocity_ratios(eqs, angle)
        found = ratios.at(sb.assemble(eqs, {angle: _AT}, guess))[:, 0]
    elif task == "equilibrium":
        found = list(sb.find_equilibrium(eqs, loop.beside).q.values())
    elif task == "linearization":
        found = np.sort(np.abs(sb.linearize(eqs, sb.find_equilibrium(eqs, loop.beside)).eigenvalues))
    else:
        found = sb.inverse_dynamics(eqs, {angle: f"{_AT} + t"}, "T", _TIMES, guess=guess)["T"]
    return np.array(found, dtype=float)


TASKS: Final = ("assembly", "velocity_ratios", "linearization", "equilibrium", "inverse_dynamics")


def tables(settings: Settings, loops: Mapping[str, Callable[[], Loop]] = LOOPS) -> Iterator[Table]:
    """Yield one table for each mechanism."""
    for name, make in loops.items():
        loop = make()
        by_hand = ByHand(loop)
        rows = [row(task, loop, by_hand, settings.rounds) for task in TASKS]
        notes = (f"medians of {settings.rounds} rounds; {len(loop.eqs.coordinate_names)} coordinates, "
                 f"{len(loop.eqs.multiplier_names)} constraints; {_TIMES.size} times of inverse dynamics",
                 "symbody looks for other equilibria, too, and SymPy for the nearest alone")  # fmt: skip
        yield Table(
            f"analyses: {name}", ("analysis", "symbody", "SymPy alone", "difference"), tuple(rows), notes
        )


def row(task: str, loop: Loop, by_hand: ByHand, rounds: int) -> tuple[str, ...]:
    """Return times of one analysis, and how far results are apart."""
    tasks = {"ours": partial(ours, loop, task), "SymPy": getattr(by_hand, task)}
    a, b = (each() for each in tasks.values())
    taken = medians(in_turns({name: partial(seconds, each) for name, each in tasks.items()}, rounds))
    apart = float(np.abs(a - b).max() / np.abs(b).max())
    cells = (
        seconds_text(taken["ours"]),
        seconds_text(taken["SymPy"]) + ratio_text(taken["SymPy"], taken["ours"]),
    )
    return (task.replace("_", " "), *cells, difference_text(apart))
