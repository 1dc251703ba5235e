"""Linkages that pass change points, with their motion in independent coordinates by Lagrange's equations.

SymPy derives these from where the bodies are, which is known in closed form on each branch: no constraint, no
loop and nothing of symbody takes part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import pi
from random import Random
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import symbody as sb

Floats = NDArray[np.float64]
A, B = sp.symbols("a b")


@dataclass
class PlaneMechanism:
    """Bodies in a plane that is turned in space, with a motion in independent coordinates.

    Attributes
    ----------
    angles : mapping
        From each coordinate of a joint to its value on the branch, in the independent coordinates.
    """

    random: Random
    turn: Rotation
    gravity: tuple[float, float]
    coordinates: tuple[Any, ...]
    elements: list[object] = field(default_factory=list)
    ground: dict[str, sb.Frame] = field(default_factory=dict)
    angles: dict[str, Any] = field(default_factory=dict)
    efforts: dict[str, float] = field(default_factory=dict)
    lagrangian: Any = 0
    work: Any = 0

    @property
    def axis(self) -> tuple[float, float, float]:
        """The normal of the plane."""
        return self.point(0, 0, 1)

    def point(self, x: float, y: float, z: float = 0.0) -> tuple[float, float, float]:
        """A vector of the plane, in space."""
        i, j, k = (float(v) for v in self.turn.apply((x, y, z)))
        return i, j, k

    def body(
        self, name: str, centre: tuple[float, float], places: dict[str, tuple[float, float]],
        at: tuple[Any, Any], angle: Any,
    ) -> None:  # fmt: skip
        """Add a body by its centre of mass and its frames, its origin at a place, turned by an angle."""
        mass, inertia = self.random.uniform(0.5, 2), self.random.uniform(0.02, 0.2)
        frames = {
            key: sb.Frame(at=self.point(x - centre[0], y - centre[1])) for key, (x, y) in places.items()
        }
        self.elements.append(sb.Body(name, mass=mass, inertia=(inertia,) * 3, frames=frames))
        x = at[0] + sp.cos(angle) * centre[0] - sp.sin(angle) * centre[1]
        y = at[1] + sp.sin(angle) * centre[0] + sp.cos(angle) * centre[1]
        rates = [sp.Symbol(f"{q}_dot") for q in self.coordinates]

        def rate(value: Any) -> Any:
            return sum(sp.diff(value, q) * v for q, v in zip(self.coordinates, rates, strict=True))

        kinetic = mass * (rate(x) ** 2 + rate(y) ** 2) / 2 + inertia * rate(sp.sympify(angle)) ** 2 / 2
        self.lagrangian += kinetic + mass * (self.gravity[0] * x + self.gravity[1] * y)

    def hinge(self, name: str, first: str, second: str, angle: Any, torque: float = 0.0) -> None:
        """Pin two frames; the angle of the second body less that of the first is known."""
        self.angles[name] = sp.sympify(angle)
        drive = None
        if torque:
            self.efforts["T"], drive = torque, sb.Drive("T")
            self.work += torque * angle
        self.elements.append(
            sb.Revolute(f"J{name}", first, second, axis=self.axis, coordinate=name, torque=drive)
        )

    def model(self) -> sb.Model:
        """The model, its elements in any order: the trees follow."""
        self.random.shuffle(self.elements)
        gravity = self.point(*self.gravity)
        return sb.Model(
            "linkage", self.elements, ground=self.ground, gravity=gravity, inputs=list(self.efforts)
        )

    def values(self, y: Sequence[float]) -> dict[str, float]:
        """The joint coordinates and their rates at independent coordinates and speeds."""
        n = len(self.coordinates)
        place = dict(zip(self.coordinates, y[:n], strict=True))
        found: dict[str, float] = {}
        for name, angle in self.angles.items():
            found[name] = float(angle.subs(place))
            slopes = [float(sp.diff(angle, q).subs(place)) for q in self.coordinates]
            found[f"{name}_dot"] = float(np.dot(slopes, y[n:]))
        return found

    def rates(self) -> Callable[[float, Floats], Floats]:
        """Lagrange's equations, of first order."""
        q = list(self.coordinates)
        v = [sp.Symbol(f"{x}_dot") for x in q]
        momenta = sp.Matrix([sp.diff(self.lagrangian, x) for x in v])
        force = sp.Matrix([sp.diff(self.lagrangian + self.work, x) for x in q]) - momenta.jacobian(
            q
        ) * sp.Matrix(v)
        function = sp.lambdify((q, v), (momenta.jacobian(v), force), "numpy")

        def rates(t: float, y: Floats) -> Floats:
            mass, right = function(y[: len(q)], y[len(q) :])
            return np.concatenate([y[len(q) :], np.linalg.solve(mass, np.asarray(right).ravel())])

        return rates

    def motion(self, y: Sequence[float], times: Floats) -> Floats:
        """Independent coordinates and speeds (2 n, N)."""
        run = solve_ivp(
            self.rates(), (0.0, times[-1]), y, t_eval=times, method="DOP853", rtol=1e-12, atol=1e-12
        )
        assert run.success
        return np.asarray(run.y)


def mechanism(seed: int) -> tuple[PlaneMechanism, list[float]]:
    """A random linkage with independent coordinates and speeds at its start, a quarter of them flat."""
    random = Random(seed)
    kind = random.choice([locomotive, locomotive, slider_crank, scissor_lift, parallelograms])
    turn = Rotation.random(random_state=seed) if random.random() < 0.5 else Rotation.identity()
    g, down = random.choice([0.0, 3.0, 9.81]), random.uniform(-pi, pi)
    gravity = float(g * np.cos(down)), float(g * np.sin(down))
    made = PlaneMechanism(random, turn, gravity, (A, B) if kind is parallelograms else (A,))
    start = kind(made, random.random() < 0.25)
    for name in made.coordinates[: len(start)]:
        del name
    speeds = [random.choice([-1, 1]) * random.uniform(6, 12) for _ in start]
    return made, [*start, *speeds]


def locomotive(made: PlaneMechanism, is_flat: bool) -> list[float]:
    """Equal parallel cranks on one rod: with three or more redundant everywhere, and singular when flat.

    Some pins are balls, which carry no moments: other rows are redundant.
    """
    random = made.random
    n, r = random.randint(2, 6), random.uniform(0.3, 0.8)
    posts = np.cumsum([random.uniform(0.4, 1.5) for _ in range(n)]).tolist()
    tip = r * sp.cos(A), r * sp.sin(A)
    rod = {f"p{k}": (x, 0.0) for k, x in enumerate(posts)}
    made.body("Rod", (random.uniform(0, 1), random.uniform(-0.2, 0.2)), rod, tip, sp.Integer(0))
    for k, x in enumerate(posts):
        made.ground[f"g{k}"] = sb.Frame(at=made.point(x, 0))
        made.body(f"W{k}", (random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)),
                  {"hub": (0.0, 0.0), "tip": (r, 0.0)}, (sp.Float(x), sp.Integer(0)), A)  # fmt: skip
        made.hinge(f"a{k}", f"ground.g{k}", f"W{k}.hub", A, 0.0 if k else random.choice([0.0, 2.0]))
        if k and random.random() < 0.25:
            made.elements.append(sb.Spherical(f"S{k}", f"W{k}.tip", f"Rod.p{k}", tree=False))
        else:
            made.hinge(f"b{k}", f"W{k}.tip", f"Rod.p{k}", -A)
    return [random.choice([0.0, pi]) if is_flat else random.uniform(-3, 3)]


def slider_crank(made: PlaneMechanism, is_flat: bool) -> list[float]:
    """Rod as long as the crank: the slider passes the pivot, or stays on it while both turn together.

    On one branch the rod is turned by -a and the slider at 2 r cos a; on the other, by a + pi and at 0. They
    meet at a = pi/2.
    """
    random, r = made.random, made.random.uniform(0.3, 0.8)
    stays = random.random() < 0.4
    turned, x = (A + sp.pi, sp.Integer(0)) if stays else (-A, 2 * r * sp.cos(A))
    made.ground["pivot"] = sb.Frame()
    made.body("Crank", (random.uniform(0, r), random.uniform(-0.2, 0.2)),
              {"hub": (0.0, 0.0), "tip": (r, 0.0)}, (sp.Integer(0), sp.Integer(0)), A)  # fmt: skip
    made.body("Rod", (random.uniform(0, r), random.uniform(-0.2, 0.2)),
              {"near": (0.0, 0.0), "far": (r, 0.0)}, (r * sp.cos(A), r * sp.sin(A)), turned)  # fmt: skip
    made.body("Slider", (0.0, 0.0), {"pin": (0.0, 0.0)}, (x, sp.Integer(0)), sp.Integer(0))
    made.hinge("a", "ground.pivot", "Crank.hub", A, random.choice([0.0, 2.0]))
    made.hinge("b", "Crank.tip", "Rod.near", turned - A)
    made.hinge("c", "Rod.far", "Slider.pin", -turned)
    made.angles["s"] = x
    made.elements.append(sb.Prismatic("Guide", "ground", "Slider", axis=made.point(1, 0), coordinate="s"))
    return [random.choice([pi / 2, -pi / 2]) if is_flat else random.uniform(-3, 3)]


def scissor_lift(made: PlaneMechanism, is_flat: bool) -> list[float]:
    """Stages of two crossed bars, turned by a and -a: n + 1 constraints are lost at once where it lies flat."""
    random = made.random
    n, half = random.randint(1, 3), random.uniform(0.3, 0.8)
    made.ground["foot"] = sb.Frame()
    for k in range(n):
        middle = half * sp.cos(A), (2 * k + 1) * half * sp.sin(A)
        for name, angle in (("U", A), ("V", -A)):
            centre = random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)
            ends = {"left": (-half, 0.0), "mid": (0.0, 0.0), "right": (half, 0.0)}
            made.body(f"{name}{k}", centre, ends, middle, angle)
        made.hinge(f"m{k}", f"U{k}.mid", f"V{k}.mid", -2 * A)
        if k:
            made.hinge(f"l{k}", f"V{k - 1}.left", f"U{k}.left", 2 * A)
            made.hinge(f"r{k}", f"U{k - 1}.right", f"V{k}.right", -2 * A)
    made.body("Slider", (0.0, 0.0), {"pin": (0.0, 0.0)}, (2 * half * sp.cos(A), sp.Integer(0)), sp.Integer(0))
    made.hinge("a", "ground.foot", "U0.left", A, random.choice([0.0, 2.0]))
    made.hinge("c", "V0.right", "Slider.pin", A)
    made.angles["s"] = 2 * half * sp.cos(A)
    made.elements.append(sb.Prismatic("Guide", "ground", "Slider", axis=made.point(1, 0), coordinate="s"))
    return [0.0 if is_flat else random.uniform(-1.2, 1.2)]


def parallelograms(made: PlaneMechanism, is_flat: bool) -> list[float]:
    """A plate on two or three equal cranks, and another one on the first: two freedoms, each with flat poses."""
    random = made.random
    below, at = "ground", (sp.Integer(0), sp.Integer(0))
    made.ground.update({f"g{k}": sb.Frame(at=made.point(k * 0.9, 0)) for k in range(3)})
    for level, angle in enumerate((A, B)):
        n, r = random.randint(2, 3), random.uniform(0.3, 0.8)
        direction = random.uniform(-1, 1) if level else 0.0
        posts = {f"g{k}": (k * 0.9, 0.0) for k in range(n)}
        moved = at[0] + r * sp.cos(angle + direction), at[1] + r * sp.sin(angle + direction)
        for k in range(n):
            hub = at[0] + k * 0.9, at[1]
            made.body(f"C{level}{k}", (random.uniform(0, r), 0.0), {"hub": (0.0, 0.0), "tip": (r, 0.0)},
                      hub, angle + direction)  # fmt: skip
            made.hinge(f"a{level}{k}", f"{below}.g{k}", f"C{level}{k}.hub", angle + direction)
            made.hinge(f"b{level}{k}", f"C{level}{k}.tip", f"P{level}.p{k}", -angle - direction)
        frames = {**{f"p{k}": place for k, place in enumerate(posts.values())},
                  **{f"g{k}": (k * 0.9, 0.0) for k in range(3)}}  # fmt: skip
        made.body(f"P{level}", (random.uniform(0, 1), random.uniform(0, 0.3)), frames, moved, sp.Integer(0))
        below, at = f"P{level}", moved
    return [0.0 if is_flat else random.uniform(-3, 3), random.uniform(-3, 3)]
