"""The fault checklist, D: inertia. One test a row; the number is the row's."""

from __future__ import annotations

import numpy as np
import pytest

from symbody.codegen.compile import compile
from symbody.equations.form import form_equations
from symbody.errors import FormulationError, ModelError
from symbody.model import Body, Frame, Model, Prismatic, Revolute, Spherical
from tests.faults.refusals import refused, refused_file, refused_model

EPS = float(np.finfo(float).eps)


@pytest.mark.parametrize("unit", [1e-30, 1.0, 1e20])
def test_row_37_moments_that_no_body_has(unit: float) -> None:
    # Beyond a relative 1e-9 of the largest moment it is refused, below it is rounding.
    for k in range(3):
        moments = [unit, unit, unit]
        moments[k] = 2 * unit * (1 + 2e-9)
        assert refused_model(Body("A", inertia=moments)) == [("model.impossible_inertia", "body A, inertia")]
        moments[k] = 2 * unit * (1 + 2e-10)
        assert Model("plate", [Body("A", inertia=moments)]).bodies


def test_row_37_thin_rods_and_plates_are_real() -> None:
    rod = Body("Rod", mass="m", inertia=(0, "m*L**2/12", "m*L**2/12"))
    plate = Body("Plate", mass="m", inertia=("m*L**2/12", "m*w**2/12", "m*(L**2 + w**2)/12"))
    parameters = {"m": 0.3, "L": 0.7, "w": 0.1}
    assert len(Model("thin", [rod, plate], parameters=parameters).bodies) == 2


def test_row_37_what_is_wrong_is_shown_in_full() -> None:
    refused_model(Body("A", inertia=(1, 1, 2.000000004)), words="the moments 1, 1, 2.000000004")
    refused_file("impossible_inertia", "model.impossible_inertia")
    refused_file("negative_inertia", "model.impossible_inertia")


def test_row_37_the_cure_names_the_way_out() -> None:
    bodies = [((1, 1, 5), (0, 0, 0)), ((1, 1, -1), (0, 0, 0)), ((1, 1, 1), (5, 0, 0))]
    for moments, products in bodies:
        with pytest.raises(ModelError) as caught:
            Model("odd", [Body("A", inertia=moments, products=products)])
        assert "unphysical=True" in caught.value.problems[0].fix
        assert Model("odd", [Body("A", inertia=moments, products=products, unphysical=True)]).notes


def test_row_38_products_that_no_body_has() -> None:
    flipped = Body("A", inertia=(2, 2, 2), products=(0.9, 0.9, 0.9))
    words = "with the opposite signs of the products a body would be possible"
    assert refused_model(flipped, words=words) == [("model.impossible_inertia", "body A, inertia")]
    assert Model("signs", [Body("A", inertia=(2, 2, 2), products=(-0.9, -0.9, -0.9))]).bodies
    refused_model(
        Body("A", inertia=(1, 1, 1), products=(5, 0, 0)), words="the entries xy, xz, yz of the tensor"
    )
    refused_file("impossible_products", "model.impossible_inertia")
    # A tensor is given by six numbers, so that it is always symmetric.


def test_row_39_an_inertia_that_is_missing_is_zero_and_told_where_it_matters() -> None:
    ball = Body("Ball", mass=1, frames={"rim": Frame(at=(0, 1, 0))})
    assert [value.text for value in (*ball.inertia, *ball.products)] == ["0"] * 6
    centred = form_equations(Model("spin", [ball, Spherical("s", "ground", "Ball")]))
    found = refused(lambda: compile(centred, "udot"), FormulationError)
    assert found == [("equations.massless", f"speed s_w{axis}") for axis in "xyz"]
    # It does not matter to a pendulum of one point: -g sin(0.3)/L.
    pin = Revolute("pin", "ground", "Ball.rim", coordinate="angle")
    pendulum = form_equations(Model("pendulum", [ball, pin], gravity=(0, -9.81, 0)))
    (rate,) = compile(pendulum, "udot")(0.0, [0.3], [0.0])
    assert rate == pytest.approx(-9.81 * np.sin(0.3), rel=4 * EPS)


def test_row_40_a_massless_link_that_something_resists() -> None:
    slider = Body("Slider", mass=2, inertia=(2, 2, 3))
    parts = [
        Body("Link"),
        slider,
        Revolute("turn", "ground", "Link", coordinate="angle"),
        Prismatic("slide", "Link", "Slider", axis="x", coordinate="x"),
    ]
    f = compile(form_equations(Model("polar", parts)), ["mass_matrix", "udot"])
    found = f(0.0, [0.3, 0.5], [0.1, 0.0])
    assert found.mass_matrix == pytest.approx(np.diag([3 + 2 * 0.5**2, 2]), rel=4 * EPS)
    assert found.udot == pytest.approx([0.0, 0.5 * 0.1**2], rel=4 * EPS)


@pytest.mark.parametrize(
    ("parts", "speeds"),
    [
        ([Revolute("a", "ground", "Body", coordinate="p"), Prismatic("b", "Body", "Link", coordinate="q")],
         {"q_dot"}),
        # The link turns freely between two hinges on one axis: either of them may be named.
        ([Revolute("a", "ground", "Link", coordinate="p"), Revolute("b", "Link", "Body", coordinate="q")],
         {"p_dot", "q_dot"}),
    ],
)  # fmt: skip
def test_row_40_a_massless_link_that_nothing_resists(parts: list[Revolute], speeds: set[str]) -> None:
    bodies = [Body("Body", mass=1, inertia=(1, 1, 1)), Body("Link")]
    eqs = form_equations(Model("light", [*bodies, *parts]))
    for _ in range(2):  # nothing half solved is left behind
        ((code, where),) = refused(lambda: compile(eqs, "udot"), FormulationError)
        assert code == "equations.massless" and where.removeprefix("speed ") in speeds
    assert compile(eqs, "mass_matrix")(0.0, [0.0, 0.0], [0.0, 0.0]).shape == (2, 2)


def linkage(closed: bool) -> Model:
    """A double pendulum, or a parallelogram, of rods with mass m and length L."""
    frames = {"a": Frame(at=("-L/2", 0, 0)), "b": Frame(at=("L/2", 0, 0))}
    names = ["crank", "rod", "rocker"] if closed else ["crank", "rod"]
    inertia = ("0", "m*L**2/12", "m*L**2/12")
    bodies = [Body(name, mass="m", inertia=inertia, frames=frames) for name in names]
    joints = [
        Revolute("A", "ground", "crank.a", coordinate="qA"),
        Revolute("B", "crank.b", "rod.a", coordinate="qB"),
        Revolute("C", "rod.b", "rocker.b"),
        Revolute("D", "ground.post", "rocker.a", coordinate="qD"),
    ]
    return Model(
        "rods",
        [*bodies, *(joints if closed else joints[:2])],
        gravity=(0, "-g", 0),
        parameters={"m": 1, "L": 1, "g": 9.81},
        ground={"post": Frame(at=("L", 0, 0))},
        initial={"qA": 1, "qB": -1, "qD": 1} if closed else {},
    )


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize(("mass", "length"), [(1e-15, 1.0), (1e-15, 1e-6), (1e-60, 1e-20), (1e15, 1e6)])
def test_row_41_accelerations_at_any_scale(closed: bool, mass: float, length: float) -> None:
    """Accelerations of rods go with g/L and do not depend on the mass."""
    eqs = form_equations(linkage(closed))
    q = [1.0, -1.0, 1.0] if closed else [0.3, 0.2]
    u = [0.0] * len(q)
    large = compile(eqs, "udot")(0.0, q, u)
    small = compile(eqs, "udot", {"m": mass, "L": length})(0.0, q, u)
    # Rounding of solving n <= 5 equations whose scaled condition number is below 100.
    assert small * length == pytest.approx(large, rel=1000 * EPS)
    assert np.abs(large).min() > 1


def test_row_41_freedoms_of_a_micro_mechanism() -> None:
    assert form_equations(linkage(closed=True)).degrees_of_freedom == 1
    model = linkage(closed=True)
    tiny = Model(
        "tiny",
        model.elements,
        model.gravity,
        {"m": 1e-15, "L": 1e-6, "g": 9.81},
        (),
        model.initial,
        model.ground,
    )
    assert form_equations(tiny).degrees_of_freedom == 1
    assert not any("radius" in note for note in tiny.notes)


@pytest.mark.parametrize("inertia", [(0, 0, "m*L**2/3"), (0, "m*L**2/3", "m*L**2/3")])
def test_row_42_an_inertia_about_the_wrong_point(inertia: tuple[object, ...]) -> None:
    # The moment of a rod about its end, where the one about its centre belongs.
    rod = Body("Rod", mass="m", inertia=inertia, frames={"end": Frame(at=("L/2", 0, 0))})
    parameters = {"m": 2, "L": 0.4}
    notes = Model("rod", [rod], parameters=parameters).notes
    assert any("body Rod" in note and "about the centre of mass, or about end?" in note for note in notes)
    right = Body("Rod", mass="m", inertia=(0, 0, "m*L**2/12"), frames=rod.frames)
    assert not any("centre of mass" in note for note in Model("rod", [right], parameters=parameters).notes)


def test_row_42_a_body_larger_than_its_frames_is_no_remark() -> None:
    # About the hub no wheel of these moments is possible: they cannot have been taken there.
    wheel = Body("Wheel", mass=1, inertia=(0.5, 0.5, 1), frames={"hub": Frame(at=(0.9, 0, 0))})
    assert not any("centre of mass" in note for note in Model("wheel", [wheel]).notes)
