"""Joints as somebody adds them: curves, with and without a turn of the end frame, against closed forms."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar, final

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from symbody.expr.language.formula import Formula
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.fields import Flag, Quantity
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.joint_fields import (
    AS_CONSTRAINT,
    TREE,
    Coordinate,
    CoordinateDrive,
    PrescribedCoordinate,
    TreeMembership,
)
from symbody.model.joint import Joint
from symbody.model.simple_rotation import SimpleRotation, in_plane, unit_axis

MASS, INERTIA, A, B, G = 2.0, 0.3, 1.2, 0.5, 9.81
TIMES = np.linspace(0.0, 1.0, 11)


@final
@element
class Hoop(Joint):
    """Holds the origin of end on a circle of start, in whose plane it does not turn."""

    letters: ClassVar[tuple[str, ...]] = ("s",)
    law: ClassVar[str] = "d = A (cos(rate s), sin(rate s)), R = 1"

    rate: Quantity = Quantity("The angle for each unit of the coordinate.")
    coordinate: Coordinate = Coordinate("Name of the place on the circle.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrive = CoordinateDrive("What acts along the circle.")
    motion: PrescribedCoordinate = PrescribedCoordinate("Prescribed place.", unit="rad")
    as_constraint: Flag = AS_CONSTRAINT

    def shift(self) -> Triple:
        """Return the point of the circle."""
        angle = f"({self.rate.text})*{self.coordinates[0]}"
        x, y = (Formula.from_value(f"{A}*{wave}({angle})") for wave in ("cos", "sin"))
        return in_plane("z", x, y)


@final
@element
class Ellipse(Joint):
    """Holds the origin of end on an ellipse of start; end turns with the parameter's angle."""

    letters: ClassVar[tuple[str, ...]] = ("q",)
    law: ClassVar[str] = "d = (A cos q, B sin q), R = Rot(z, q)"

    coordinate: Coordinate = Coordinate("Name of the parameter's angle.", unit="rad")
    tree: TreeMembership = TREE
    torque: CoordinateDrive = CoordinateDrive("What acts along the angle.")
    motion: PrescribedCoordinate = PrescribedCoordinate("Prescribed angle.", unit="rad")
    as_constraint: Flag = AS_CONSTRAINT

    def turns(self) -> tuple[SimpleRotation, ...]:
        """Return the turn by the angle."""
        return (SimpleRotation(unit_axis("z"), Formula.from_value(self.coordinates[0])),)

    def shift(self) -> Triple:
        """Return the point of the ellipse."""
        x, y = f"{A}*cos({self.coordinates[0]})", f"{B}*sin({self.coordinates[0]})"
        return in_plane("z", Formula.from_value(x), Formula.from_value(y))


BEAD = sb.Body("Bead", mass=MASS, inertia=(0.2, 0.25, INERTIA))


def formed(*joints: Joint) -> sb.EquationSet:
    return sb.form_equations(sb.Model("m", [BEAD, *joints], gravity=(0, -G, 0)))


@pytest.mark.parametrize("rate", [1.0, 1.0 / A, 3.0])
def test_the_circle_pushes_alike_whatever_its_parameter(rate: float) -> None:
    """With the angle a from x and v = A a': N = m (v^2 / A + g sin a): m (A a^2 - g sin a) towards the centre, nothing along the tangent."""
    eqs = formed(Hoop("hoop", "ground", "Bead", rate, coordinate="s"))
    run = sb.simulate(eqs, 1.0, {"s": 0.3 / rate, "s_dot": 2.0 / rate}, times=TIMES, rtol=1e-10, atol=1e-12)
    a, rate_of_a = rate * run["s"], rate * run["s_dot"]
    inward = MASS * (A * rate_of_a**2 - G * np.sin(a))
    assert run["reaction hoop Fx"] == pytest.approx(-inward * np.cos(a), abs=1e-7)
    assert run["reaction hoop Fy"] == pytest.approx(-inward * np.sin(a), abs=1e-7)


@pytest.mark.parametrize("as_constraint", [False, True])
def test_the_effort_of_a_prescribed_place_on_a_circle(as_constraint: bool) -> None:
    """m A^2 a'' + m g A cos a at a = 0.3 + t^2, the work for each unit of a."""
    eqs = formed(
        Hoop("hoop", "ground", "Bead", 1, coordinate="s", motion="0.3 + t^2", as_constraint=as_constraint)
    )
    run = sb.simulate(eqs, 1.0, times=TIMES)
    expected = MASS * A**2 * 2.0 + MASS * G * A * np.cos(0.3 + TIMES**2)
    assert run["effort hoop"] == pytest.approx(expected, abs=1e-6)


def test_a_curve_without_a_turn_closes_no_loop() -> None:
    planar = sb.Planar("plane", "ground", "Bead", coordinates=["x", "y", "c"])
    with pytest.raises(sb.TopologyError) as caught:
        formed(planar, Hoop("hoop", "ground", "Bead", 1, coordinate="s", tree=False))
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("topology.curved_chord", "joint hoop")
    assert "PointOnCurve" in problem.fix


def ellipse_angle() -> np.ndarray:
    """Lagrange: (m (A^2 sin^2 + B^2 cos^2) + I) q'' = -m (A^2 - B^2) sin cos q'^2 - m g B cos q."""

    def rates(_: float, x: np.ndarray) -> list[float]:
        s, c = np.sin(x[0]), np.cos(x[0])
        inertia = MASS * ((A * s) ** 2 + (B * c) ** 2) + INERTIA
        return [x[1], (-MASS * (A * A - B * B) * s * c * x[1] ** 2 - MASS * G * B * c) / inertia]

    return np.asarray(solve_ivp(rates, (0, 1), [0.3, 2.0], t_eval=TIMES, rtol=1e-11, atol=1e-12).y[0])


def test_a_curve_with_a_turn_is_a_branch_and_closes_loops() -> None:
    start = {"q": 0.3, "q_dot": 2.0}
    planar = sb.Planar("plane", "ground", "Bead", coordinates=["x", "y", "c"])
    branch = sb.simulate(
        formed(Ellipse("track", "ground", "Bead", coordinate="q")),
        1.0,
        start,
        times=TIMES,
        rtol=1e-10,
        atol=1e-12,
    )
    chord = sb.simulate(
        formed(planar, Ellipse("track", "ground", "Bead", coordinate="q", tree=False)),
        1.0, start, guess={"x": A, "y": 0.1, "c": 0.3}, times=TIMES, rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    for run in (branch, chord):
        assert run["q"] == pytest.approx(ellipse_angle(), abs=1e-8)
    assert chord["reaction track"] == pytest.approx(branch["reaction track"], abs=1e-6)


@pytest.mark.parametrize("tree", [True, False])
def test_the_effort_of_a_prescribed_angle_on_an_ellipse(tree: bool) -> None:
    planar = [] if tree else [sb.Planar("plane", "ground", "Bead", coordinates=["x", "y", "c"])]
    eqs = formed(*planar, Ellipse("track", "ground", "Bead", coordinate="q", motion="0.3 + t", tree=tree))
    run = sb.simulate(eqs, 1.0, guess=None if tree else {"x": A}, times=TIMES)
    q = 0.3 + TIMES
    expected = MASS * (A * A - B * B) * np.sin(q) * np.cos(q) + MASS * G * B * np.cos(q)
    assert run["effort track"] == pytest.approx(expected, abs=1e-6)


def test_a_file_without_words_for_a_class_is_not_written(tmp_path: Path) -> None:
    model = sb.Model("m", [BEAD, Hoop("hoop", "ground", "Bead", 1, coordinate="s")])
    with pytest.raises(sb.FormatError) as caught:
        sb.save_model(model, tmp_path / "m.toml")
    assert caught.value.problems[0].code == "file.own_class" and not list(tmp_path.iterdir())
