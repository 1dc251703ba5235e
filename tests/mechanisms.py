"""Mechanisms that many tests use, formed once in a process."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import symbody as sb

EXAMPLES = Path(__file__).parents[1] / "examples"


@cache
def example(name: str) -> sb.EquationSet:
    """The equations of an example by the name of its file."""
    (path,) = EXAMPLES.glob(f"*/{name}.toml")
    return sb.form_equations(sb.load_model(path))


@cache
def cart() -> sb.EquationSet:
    """A unit mass on a line under the force F: x'' = F."""
    joint = sb.Prismatic("j", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    return sb.form_equations(sb.Model("cart", [sb.Body("B", mass=1), joint], inputs=["F"]))


@cache
def pendulum() -> sb.EquationSet:
    """A mass of 1 kg on a massless rod of 1 m."""
    body = sb.Body("B", mass=1, inertia=(0, 0, 0), frames={"A": sb.Frame(at=(0, 1, 0))})
    joint = sb.Revolute("j", "ground", "B.A", axis="z", coordinate="theta")
    return sb.form_equations(sb.Model("pendulum", [body, joint], gravity=(0, "-9.81", 0)))
