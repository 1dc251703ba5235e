"""Exports of a model with constraints beside joints: rows on positions first, then those on velocities."""

from __future__ import annotations

from pathlib import Path

import sympy as sp

import symbody as sb
from symbody.dynaflexpro import BuildEQs


def test_a_skate_on_a_circle(tmp_path: Path) -> None:
    """``Psi'' + 2 alpha Psi' + beta^2 Psi = 0`` for the circle, ``chi' + 2 alpha chi = 0`` for the blade."""
    parts = [
        sb.Body("Skate", mass=2, inertia=(0, 0, 1)),
        sb.Planar("p", "ground", "Skate", coordinates=["x", "y", "phi"]),
        sb.KnifeEdge("blade", "ground", "Skate"),
        sb.Constraint("ring", "x^2 + y^2 - 4"),
    ]
    sb.save_model(sb.Model("skate", parts), tmp_path / "skate.toml")
    built = BuildEQs(tmp_path / "skate.toml")
    (x, y, phi), (u, v, w) = built.vQ, built.vP
    rate, normal = 2 * x * u + 2 * y * v, sp.Matrix([-sp.sin(phi), sp.cos(phi)])
    assert sp.simplify(built.xJacVel - sp.Matrix([[2 * x, 2 * y, 0], [*normal, 0]])) == sp.zeros(2, 3)
    assert sp.expand(built.xJacPos - sp.Matrix([[2 * x, 2 * y, 0]])) == sp.zeros(1, 3)
    assert built.vVelRHS == sp.zeros(2, 1) and built.vLambda.shape == (2, 1)
    assert [len(found) for found in (built.GetPosCons(), built.GetVelCons(), built.GetAccCons())] == [1, 2, 2]
    plain = sp.Matrix([-2 * u**2 - 2 * v**2, w * (u * sp.cos(phi) + v * sp.sin(phi))])
    assert sp.simplify(built.vAccRHS - plain) == sp.zeros(2, 1)
    built.SetBaumgarte([3, 2])
    blade = normal.dot(sp.Matrix([u, v]))
    held = plain - sp.Matrix([6 * rate + 4 * (x**2 + y**2 - 4), 6 * blade])
    assert sp.simplify(built.vAccRHS - held) == sp.zeros(2, 1)
    assert len(built.GetSysEQs()) == 3 + 2
