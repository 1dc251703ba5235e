"""The fault checklist, A: structure of a model. One test a row; the number is the row's.

Row 14, a chain of many bodies, has a file of its own.
"""

from __future__ import annotations

from copy import deepcopy
from dataclasses import FrozenInstanceError
from functools import partial
from itertools import product

import numpy as np
import pytest

from symbody.codegen.compile import compile
from symbody.equations.form import form_equations
from symbody.errors import FrameError, ModelError, TopologyError
from symbody.expr.graph import Graph
from symbody.formats import model_from_toml
from symbody.graph.topology import choose_topology
from symbody.graph.trees import Trees
from symbody.model import (
    Body,
    Drive,
    Force,
    Frame,
    Model,
    PinSlot,
    Planar,
    Prismatic,
    Revolute,
    Torque,
    Universal,
    Weld,
)
from symbody.simulation.simulate import simulate
from symbody.spatial.frame import FrameTree
from symbody.spatial.rotation import Rotation
from tests.faults.refusals import refused, refused_file, refused_model


def four_bar(*driven: str) -> Model:
    """A parallelogram of three links; the joints named are driven."""
    frames = {"a": Frame(at=(-0.5, 0, 0)), "b": Frame(at=(0.5, 0, 0))}
    ends = {
        "A": ("ground", "crank.a"),
        "B": ("crank.b", "rod.a"),
        "C": ("rod.b", "rocker.b"),
        "D": ("ground.post", "rocker.a"),
    }
    return Model(
        "four-bar",
        [
            *(Body(name, mass=1, inertia=(0, 0, 1), frames=frames) for name in ("crank", "rod", "rocker")),
            *(Revolute(j, *ends[j], coordinate=f"q{j}", motion="w*t" if j in driven else None) for j in ends),
        ],
        parameters={"w": 1},
        ground={"post": Frame(at=(1, 0, 0))},
    )


def test_row_01_one_name_for_two_elements() -> None:
    assert refused_model(Body("A"), Torque("A", "A", (0, 0, 1))) == [
        ("names.duplicate", "body A, name; torque A, name")
    ]
    assert refused_model(Body("A"), Body("A", mass=1), words="2 elements are named 'A'") == [
        ("names.duplicate", "body A (element 1), name; body A (element 2), name")
    ]
    refused_file("duplicate_body", "names.duplicate")
    refused_file("duplicate_element", "names.duplicate")
    # Two frames of one name: keys of a table, which a file cannot repeat, and Python neither.
    text = 'name = "a"\n[ground.frames]\nN = {}\nN = {}\n'
    assert refused(lambda: model_from_toml(text, where="a.toml")) == [("file.duplicate_key", "a.toml:4")]


def test_row_02_unknown_names_with_the_nearest() -> None:
    link = Body("Link", frames={"tip": Frame()})
    assert refused_model(link, Weld("w", "ground", "Lnk"), words="did you mean 'Link'") == [
        ("model.unknown_place", "joint w, between[1]")
    ]
    assert refused_model(link, Weld("w", "ground", "Link.tp"), words="'tip'") == [
        ("model.unknown_place", "joint w, between[1]")
    ]
    assert refused_model(Body("A", mass="mas"), parameters={"mass": 1}, words="'mass'") == [
        ("names.unknown", "body A, mass, column 1")
    ]
    for name, code in (
        ("unknown_body", "model.unknown_place"),
        ("unknown_frame", "model.unknown_place"),
        ("unknown_ground_frame", "model.unknown_place"),
        ("unknown_symbol", "names.unknown"),
        ("initial_unknown", "initial.unknown"),
        ("ambiguous_frame", "model.unknown_place"),
        ("unknown_joint_type", "file.unknown_type"),
        ("unknown_key", "file.unknown_key"),
    ):
        refused_file(name, code)  # fmt: skip


def test_row_03_frames_in_a_circle() -> None:
    # In a model a frame stands on a body and in no other frame, so that no circle can be written.
    text = 'name = "a"\n[ground.frames]\nA = { on = "B" }\nB = { on = "A" }\n'
    assert [code for code, _ in refused(lambda: model_from_toml(text))] == ["file.unknown_key"] * 2
    tree = FrameTree(Graph(), {"A": ("B", Rotation()), "B": ("A", Rotation())})
    assert refused(lambda: tree.place("A"), FrameError) == [("frame.circle", "A")]


def test_row_04_a_body_without_joint_is_free_and_a_frame_needs_a_body() -> None:
    model = Model("thrown", [Body("Ball", mass=1, inertia=(1, 1, 1))])
    assert any("body Ball has no joint and moves freely" in note for note in model.notes)
    assert form_equations(model).degrees_of_freedom == 6
    assert refused(lambda: Weld("w", "ground", Frame()), words="does not know its body") == [
        ("model.not_a_place", "joint w, between[1]")
    ]


def test_row_05_no_way_to_ground() -> None:
    assert refused_model(Body("A"), Body("B"), Revolute("j", "A", "B"), words="no chain of joints") == [
        ("model.no_ground", "body A")
    ]
    refused_file("no_ground", "model.no_ground")


def test_row_06_both_ends_on_one_body() -> None:
    parts = (Body("A", frames={"tip": Frame()}), Revolute("j", "A", "A.tip"))
    assert refused_model(*parts) == [("model.self_joint", "joint j, between")]
    assert refused_model(Weld("w", "ground", "ground")) == [("model.self_joint", "joint w, between")]
    refused_file("self_joint", "model.self_joint")


def test_row_07_two_joints_between_the_same_bodies() -> None:
    door = Body("Door", mass=1, inertia=(1, 1, 1), frames={"low": Frame(), "high": Frame(at=(0, 0, 1))})
    hinges = [
        Revolute("low", "ground", "Door.low", coordinate="angle"),
        Revolute("high", "ground.high", "Door.high"),
    ]
    eqs = form_equations(Model("door", [door, *hinges], ground={"high": Frame(at=(0, 0, 1))}))
    assert eqs.degrees_of_freedom == 1
    # The second hinge adds nothing, and the reader is told.
    assert eqs.multiplier_names == ()
    assert any("joint high: 5 closing equations hold identically" in note for note in eqs.notes)
    slider = Prismatic("slide", "ground.high", "Door.high", axis="x")
    locked = form_equations(Model("both", [door, hinges[0], slider], ground={"high": Frame(at=(0, 0, 1))}))
    assert locked.degrees_of_freedom == 0 and locked.multiplier_names


@pytest.mark.parametrize("axis", [(0, 0, 0), ("a - 1", 0, 0)])
def test_row_08_zero_axis(axis: tuple[object, ...]) -> None:
    parts = (Body("A"), Revolute("j", "ground", "A", axis=axis))
    assert refused_model(*parts, parameters={"a": 1}) == [("model.zero_axis", "joint j, axis")]


def test_row_08_zero_and_nan_axes_of_files() -> None:
    refused_file("zero_axis", "model.zero_axis")
    refused_file("zero_axis_by_parameters", "model.zero_axis")
    refused_file("nan_axis", "file.not_finite")
    assert refused(lambda: Revolute("j", "ground", "A", axis=(0, 0, float("nan")))) == [
        ("expression.not_finite", "joint j, axis[2]")
    ]


def test_row_08_other_lengths_are_normalized_and_noted() -> None:
    model = Model("long axis", [Body("A"), Revolute("j", "ground", "A", axis=(0, 3, 4))])
    assert "joint j, axis: the axis of length 5 is normalized" in model.notes
    assert [component.text for component in model.joint("j").turns()[0].axis] == ["0", "3/5", "4/5"]


def test_row_09_the_plane_of_a_planar_joint_is_one_normal() -> None:
    # A plane is given by its normal alone, so that two parallel directions cannot be given.
    assert refused(lambda: Planar("p", "ground", "A", axis=((1, 0, 0), (2, 0, 0)))) == [
        ("model.axis_letter", "joint p, axis")
    ]
    refused_file("planar_axis_as_list", "file.wrong_type")
    refused_file("planar_axis_of_three", "model.axis_letter")


def test_row_09_parallel_axes_of_a_universal_joint() -> None:
    cases = ((((0, 0, 1), (0, 0, 2)), "0 deg"), (("x", (1, 1, 0)), "45 deg"), (((1, 0, 0), "x"), "0 deg"))
    for make, (axes, angle) in product((Universal, PinSlot), cases):
        found = refused(partial(make, "j", "ground", "A", axes), words=f"the axes is {angle}")
        assert found == [("model.skew_axes", "joint j, axes")]
    refused_file("parallel_axes", "model.skew_axes")
    # Axes in parameters are judged by their values.
    by_parameter = Universal("j", "ground", "A", axes=("x", (0, "c", "s")))
    Model("m", [Body("A"), by_parameter], parameters={"c": 0.6, "s": 0.8})
    skew = Universal("j", "ground", "A", axes=("x", ("c", "s", 0)))
    found = refused_model(Body("A"), skew, parameters={"c": "1/2", "s": "sqrt(3)/2"}, words="60 deg")
    assert found == [("model.skew_axes", "joint j, axes")]


@pytest.mark.parametrize(
    ("model", "sizes"),
    [
        (Model("nothing"), (0, 0, 0, 0)),
        (Model("parameter alone", parameters={"m": 1}), (0, 0, 1, 0)),
        (Model("input alone", inputs=["F"]), (0, 0, 0, 1)),
        (Model("welded", [Body("A", mass=1), Weld("w", "ground", "A")]), (0, 0, 0, 0)),
        (Model("one", [Body("A", mass=1), Prismatic("j", "ground", "A", coordinate="x")]), (1, 1, 0, 0)),
    ],
    ids=lambda value: value.name if isinstance(value, Model) else "",
)
def test_row_10_sizes_zero(model: Model, sizes: tuple[int, ...]) -> None:
    eqs = form_equations(model)
    n, _, n_p, n_r = sizes
    counts = (eqs.coordinate_names, eqs.speed_names, eqs.parameter_names, eqs.input_names)
    assert tuple(map(len, counts)) == sizes
    assert eqs.mass_matrix.shape == (n, n) and eqs.forcing.shape == (n, 1)
    assert eqs.constraint_jacobian.shape == (0, n) and eqs.degrees_of_freedom == n
    assert len(eqs.parameters) == n_p and len(eqs.dynamic_equations()) == len(eqs.kinematic_equations) == n
    f = compile(eqs, ["xdot", "udot", "lambda", "mass_matrix", "energy"])
    for batch in ((), (0,), (3,)):
        zeros = np.zeros((*batch, n))
        values = f(0.0, zeros, zeros, np.zeros((*batch, n_r)))
        assert [value.shape for value in values] == [
            (*batch, 2 * n), (*batch, n), (*batch, 0), (*batch, n, n), batch
        ]  # fmt: skip
    run = simulate(eqs, 1.0)
    assert run.success and run.u.shape[0] == run.q.shape[0] == n


def test_row_11_all_coordinates_prescribed() -> None:
    arm = Body("Arm", mass=1, inertia=(0, 0, 2))
    model = Model("driven", [arm, Revolute("j", "ground", "Arm", coordinate="a", motion="w*t**2")],
                  parameters={"w": 3})  # fmt: skip
    said = "every coordinate is prescribed: only reactions and driving forces remain to be computed"
    assert said in model.notes
    eqs = form_equations(model)
    assert said in eqs.notes and eqs.speed_names == ()
    assert compile(eqs, "udot")(0.0, [], []).shape == (0,)
    # Inverse dynamics: J times the second derivative of the motion, 2*(2*3) N m.
    assert compile(eqs, "effort j")(0.7, [], []) == 12
    assert simulate(eqs, 1.0).success


def test_row_11_motions_beside_a_free_coordinate_are_no_remark() -> None:
    model = four_bar("A")
    assert not any("every coordinate" in note for note in model.notes)


def test_row_12_a_loop_whose_every_joint_is_driven() -> None:
    with pytest.raises(ModelError, match="no joint of the loop A, B, C, D is left free") as caught:
        four_bar("A", "B", "C", "D")
    (problem,) = caught.value.problems
    assert problem.code == "model.over_driven" and problem.fix
    assert problem.where == "; ".join(f"joint {name}, motion" for name in "ABCD")
    refused_file("over_driven", "model.over_driven")


def test_row_12_only_the_loop_is_named_and_branches_may_be_driven() -> None:
    stand = Body("Stand"), Revolute("stand", "ground", "Stand", motion="t")
    parts = (Body("A"), Body("B"), Revolute("a", "Stand", "A", motion="t"))
    back = Prismatic("c", "B", "Stand", motion=0)
    names = ["x", "y", "z"]
    driven = Planar("b", "A", "B", coordinates=names, motion={"x": "t", "y": 0, "z": 1})
    assert refused_model(*stand, *parts, driven, back, words="no joint of the loop a, b, c is left free") == [
        ("model.over_driven", "joint a, motion; joint b, motion.x; joint c, motion")
    ]
    partly = Planar("b", "A", "B", coordinates=names, motion={"x": "t", "y": 0})
    assert Model("driven", [*stand, *parts, partly, back]).bodies


def test_row_12_every_over_driven_loop_is_told() -> None:
    pairs = [Revolute(f"j{k}", "ground", body, motion="t") for k, body in enumerate("AABB")]
    assert refused_model(Body("A"), Body("B"), *pairs) == [
        ("model.over_driven", "joint j0, motion; joint j1, motion"),
        ("model.over_driven", "joint j2, motion; joint j3, motion"),
    ]


def test_row_13_a_choice_of_trees_that_is_none() -> None:
    model = four_bar()
    names = ["A", "B", "C"]

    def codes(rotation: list[str], translation: list[str], words: str) -> list[tuple[str, str]]:
        return refused(lambda: choose_topology(model, Trees(rotation, translation)), TopologyError, words)

    circle = "the joints A, B, C, D form a cycle: ground - crank - rod - rocker - ground"
    assert codes([*names, "D"], names, circle) == [("topology.cycle", "tree, rotation")]
    assert codes(names, ["A", "Z"], "there is no joint 'Z'") == [
        ("topology.unknown_joint", "tree, translation")
    ]
    assert codes(["A", "A"], names, "listed twice") == [("topology.twice", "tree, rotation")]
    # What a tree does not reach is told: it gets coordinates of its own.
    topology = choose_topology(model, Trees(["A"], names))
    for body in ("rod", "rocker"):
        assert f"body {body} has absolute coordinates for its orientation" in topology.notes


def test_row_15_nothing_can_be_changed_after_equations_exist() -> None:
    offset = np.array([1.0, 0.0, 0.0])
    parameters = {"m": 1.0}
    inputs = ["F"]
    body = Body("A", mass="m", frames={"tip": Frame(at=offset)})
    slider = Prismatic("j", "ground", "A.tip", coordinate="x", force=Drive("F"))
    model = Model("kept", [body, slider], parameters=parameters, inputs=inputs)
    eqs = form_equations(model)
    before = deepcopy(model), str(eqs.mass_matrix)
    offset[0] = 7
    parameters["m"] = 2.0
    inputs.append("G")
    assert (model, str(eqs.mass_matrix)) == before
    for thing, field in ((model, "parameters"), (body, "mass"), (slider, "axis"), (eqs, "model")):
        with pytest.raises(FrozenInstanceError):
            setattr(thing, field, 1)
    with pytest.raises(TypeError):
        model.parameters["m"] = 3
    matrix = eqs.mass_matrix
    matrix[0, 0] = 0
    assert str(eqs.mass_matrix) == before[1]


def test_row_16_a_force_acts_on_a_body_and_on_another() -> None:
    assert refused_model(Force("f", "Nobody", (1, 0, 0))) == [("model.unknown_place", "force f, on")]
    assert refused_model(Body("A"), Force("f", "A", (1, 0, 0), reaction_on="B.tip")) == [
        ("model.unknown_place", "force f, reaction_on")
    ]
    refused_file("force_on_no_body", "model.unknown_place")
    refused_file("force_without_place", "file.missing_key")


def test_row_16_the_reaction_goes_where_it_is_said() -> None:
    parts = [Body("A", mass=2), Body("B", mass=4)]
    rails = [Prismatic(f"on {b.name}", "ground", b, axis="x", coordinate=f"x{b.name}") for b in parts]
    for reaction, expected in (("ground", [3.0, 0.0]), ("B", [3.0, -1.5])):
        force = Force("push", "A", (6, 0, 0), reaction_on=reaction)
        eqs = form_equations(Model("push", [*parts, *rails, force]))
        assert compile(eqs, "udot")(0.0, [0.0, 0.0], [0.0, 0.0]).tolist() == expected


def test_row_17_ends_that_lead_nowhere() -> None:
    # A model has no ports; an end that leads nowhere is what can be unconnected.
    assert refused_model(Body("A"), Weld("w", "ground", "A.port")) == [
        ("model.unknown_place", "joint w, between[1]")
    ]
    refused_file("between_of_three", "file.wrong_length")


def test_row_17_ports_of_a_diagram() -> None:
    pytest.skip("unconnected or doubly connected port, marked by the canvas: there is no diagram yet")


def test_row_18_a_load_that_reads_the_acceleration_it_causes() -> None:
    # Where a loop without state could be written today: a load that reads the acceleration it causes.
    slider = Prismatic("j", "ground", "A", coordinate="x", force=Drive("-x_ddot"))
    assert refused_model(Body("A", mass=1), slider) == [
        ("names.not_here", "joint j, force.applied, column 2")
    ]


def test_row_18_algebraic_loops() -> None:
    pytest.skip("algebraic loop in signal blocks, exact to the port: there are no signal blocks yet")
