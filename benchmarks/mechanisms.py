"""Mechanisms written twice: as a model, and with sympy.physics.mechanics, in the same names.

Coordinates have the same names on both sides; SymPy's speeds, the rates, are u0 of q0 or u_theta of theta.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import symbody as sb

Kane = Any  # a KanesMethod whose equations are formed

EXAMPLES: Final = Path(__file__).parents[1] / "examples"

_AXES: Final = "xyz"


@dataclass(frozen=True, slots=True)
class Mechanism:
    """One size of a mechanism, to be derived by both; another process has to find what it calls."""

    name: str
    model: Callable[[], sb.Model]
    kane: Callable[[], Kane]


def pendulum_on_cart(links: int) -> Mechanism:
    """Return a planar pendulum of point masses on a cart, in angles against the vertical.

    Rotations lead from ground to each link, translations from link to link. SymPy's side is the model
    that comes with SymPy.
    """
    return Mechanism(
        f"{links} links",
        partial(_pendulum, links),
        partial(_kane, "pendulum", links),
    )


def _pendulum(links: int) -> sb.Model:
    elements: list[Any] = [
        sb.Body("C0", mass="m0"),
        sb.Prismatic("slide", "ground", "C0", axis="x", coordinate="q0", force=sb.Drive(applied="F")),
    ]
    for k in range(1, links + 1):
        elements += [
            sb.Body(f"C{k}", mass=f"m{k}", frames={"hinge": sb.Frame(at=(0, f"-l{k - 1}", 0))}),
            sb.Revolute(
                f"hinge{k}", f"C{k - 1}", f"C{k}.hinge", tree={"rotation": False, "translation": True}
            ),
            sb.Planar(
                f"angle{k}",
                "ground",
                f"C{k}",
                coordinates=(f"x{k}", f"y{k}", f"q{k}"),
                tree={"rotation": True, "translation": False},
            ),
        ]
    parameters = [f"m{k}" for k in range(links + 1)] + [f"l{k}" for k in range(links)]
    return sb.Model(
        "pendulum",
        elements,
        gravity=(0, "-g", 0),
        parameters=dict.fromkeys(parameters, 1.0) | {"g": 9.81},
        inputs=["F"],
    )


def spatial_chain(links: int) -> Mechanism:
    """Return a chain of rigid bodies, hinged in turn about y, z and x of the link before."""
    return Mechanism(f"{links} bodies", partial(_chain, links), partial(_kane, "chain", links))


def _chain(links: int) -> sb.Model:
    elements: list[Any] = []
    before = "ground"
    for k in range(links):
        ends = {"P": sb.Frame(at=(0, 0, f"-l{k}/2")), "Q": sb.Frame(at=(0, 0, f"l{k}/2"))}
        inertia = (f"a{k}", f"b{k}", f"c{k}")
        elements += [
            sb.Body(f"B{k}", mass=f"m{k}", inertia=inertia, frames=ends),
            sb.Revolute(f"J{k}", before, f"B{k}.P", axis=_AXES[(k + 1) % 3], coordinate=f"q{k}"),
        ]
        before = f"B{k}.Q"
    parameters = {f"{letter}{k}": 1.0 for k in range(links) for letter in "mabcl"}
    return sb.Model("chain", elements, gravity=(0, 0, "-g"), parameters=parameters | {"g": 9.81})


def _kane(name: str, links: int) -> Kane:
    """Return a mechanism of `benchmarks.kane`, which is loaded now."""
    return getattr(import_module("benchmarks.kane"), name)(links)


def example(name: str, kane: Callable[[], Kane]) -> Mechanism:
    """Return an example by its file, beside `kane`."""
    return Mechanism(name, partial(sb.load_model, EXAMPLES / name / f"{name}.toml"), kane)
