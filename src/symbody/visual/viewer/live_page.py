"""Pages that simulate themselves: a mechanism with sliders that any browser computes, without Python."""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np

from symbody.analysis.state import State
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_page import equation_operations, equations_page
from symbody.errors import Problem, UsageError, nearest
from symbody.expr.language.formula import Formula
from symbody.expr.printing.mathml import mathml_name
from symbody.expr.printing.mathml_tables import math_element
from symbody.model.model import Model, resolve_parameters
from symbody.simulation.inputs.input_laws import Law
from symbody.simulation.methods.closed_loops.change_point import change_point_note
from symbody.simulation.programs.javascript_simulation import (
    PageView,
    SimulationText,
    javascript_simulation,
)
from symbody.simulation.programs.motion_request import MotionRequest, branch_problem
from symbody.simulation.simulate import simulate
from symbody.visual.scene import coordinate_courses, make_motion, make_scene, scene_to_json
from symbody.visual.scene.body_poses import Chain, chain_of
from symbody.visual.scene.force_arrows import Arrow, arrows_of
from symbody.visual.scene.json_form import encode_array
from symbody.visual.scene.scene import MotionVector, Scene
from symbody.visual.viewer.page import PageData, fill_page, page_data
from symbody.visual.viewer.still import run_of_state

Bounds = tuple[float, float]
Kind = Literal["parameter", "input", "initial"]

_SHARE: Final = 0.5  # of a parameter's value, to both sides, without bounds
_TABLE: Final = 9  # values of a parameter for which shapes are made
_MOST_SPEEDS: Final = 6  # of equations that are written out
_MOST_OPERATIONS: Final = 1200
_PREVIEW: Final = 8.0  # seconds of the motion that the picture has to hold
_MOST_STEPS: Final = 20_000
_PULL: Final = 4.0  # times the frequency of a pendulum as long as the mechanism: of a held body on its spring
_FREQUENCIES: Final = (6.0, 100.0)  # [rad/s]
_ZEROS: Final = ("(0)", "(0)", "(0)")


@dataclass(frozen=True, slots=True)
class LiveControl:
    """A slider of a page: what it moves, between which values, and where it starts."""

    name: str
    kind: Kind
    min: float
    max: float
    value: float
    unit: str

    def to_json(self) -> dict[str, Any]:
        """Return it as the page reads it."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LivePage:
    """A mechanism that its page simulates.

    Attributes
    ----------
    data : mapping
        What the page holds beside the program.
    program : SimulationText
        The program.
    formulas : str
        MathML of the symbols of the sliders, and of the equations where they are short enough to be read.
    title : str
    """

    data: PageData
    program: SimulationText
    formulas: str
    title: str

    @property
    def html(self) -> str:
        """The page, which needs nothing else.

        Raises
        ------
        EnvironmentFault
            If this installation has no pages.
        """
        script = self.program.script
        digest = base64.b64encode(hashlib.sha256(script.encode("utf-8")).digest()).decode("ascii")
        return fill_page(
            "live.html", self.data,
            {"'sha256-program'": f"'sha256-{digest}'",
             '<template id="symbody-formulas"></template>':
                 f'<template id="symbody-formulas">{self.formulas}</template>',
             '<script id="symbody-program">0</script>': f'<script id="symbody-program">{script}</script>'},
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"<LivePage {self.title!r}: {len(self.data['live']['controls'])} sliders>"


def slider_bounds(
    sliders: Sequence[str | tuple[str, float, float]] | Mapping[str, Bounds | None],
) -> dict[str, Bounds | None]:
    """Return the bounds of sliders by name, None for those without."""
    if isinstance(sliders, Mapping):
        return dict(sliders)
    return {
        slider if isinstance(slider, str) else slider[0]: None
        if isinstance(slider, str)
        else (slider[1], slider[2])
        for slider in sliders
    }


def make_live_page(
    eqs: EquationSet,
    sliders: Mapping[str, Bounds | None],
    request: MotionRequest,
    title: str | None,
    options: Mapping[str, Any],
    vectors: str | Sequence[str] | None = None,
) -> LivePage:
    """Return a mechanism that its page simulates.

    Parameters
    ----------
    sliders : mapping of name to (lowest, highest) or None
        Parameters, inputs, coordinates and speeds; without bounds a parameter goes half of its value to both
        sides, an input its value, an angle half a turn, all else one unit.
    request : MotionRequest
        The motion; parameters and inputs with a slider are added.
    vectors : str or sequence of str, optional
        Forces and torques that are drawn, as for `make_motion`.

    Raises
    ------
    UsageError
        If a name means nothing, bounds are none, or the motion cannot run without Python.
    """
    if not isinstance(eqs.model, Model):
        raise UsageError(
            Problem("animation.no_model", "animate", "mechanisms assembled by hand have no shapes",
                    fix="describe the mechanism as a Model")
        )  # fmt: skip
    kinds = {name: _kind(eqs, name) for name in sliders}
    request = _with_sliders(request, kinds)
    pushed = {name: _constant_law(name, request.inputs.get(name, 0.0)) for name in request.free_inputs}
    trees = eqs.formed.topology
    chain = chain_of(
        eqs.model,
        [body.name for body in eqs.model.bodies],
        inside=trees.rotation_branches & trees.translation_branches,
    )
    values = {name: float(value) for name, value in resolve_parameters(eqs.model, request.parameters).items()}
    scene = make_scene(eqs.model, values)
    arrows = arrows_of(eqs.model, scene, vectors)
    view = PageView(*_with_arrows(chain, arrows), *_spring(scene))
    program = javascript_simulation(eqs, request, view)
    first = program.motion.first
    begins = {**values, **first.q, **first.u, **pushed}
    controls = [_control(eqs, begins[name], name, kinds[name], bounds) for name, bounds in sliders.items()]
    courses = _courses(eqs, request, pushed, first)
    scene = make_scene(eqs.model, values, courses)
    motion = make_motion(run_of_state(first), scene, curves=(), vectors="none")
    motion = replace(motion, vectors=tuple(_arrow_to_come(arrow) for arrow in arrows))
    name = title or eqs.model.name
    data = page_data(scene, motion, name, options)
    tables = list(_scene_tables(eqs.model, values, courses, controls))
    data["live"] = {"controls": [control.to_json() for control in controls], "tables": tables}
    return LivePage(data, program, "".join([*map(_symbol, sliders), _equations(eqs)]), name)


def _with_sliders(request: MotionRequest, kinds: Mapping[str, Kind]) -> MotionRequest:
    return replace(
        request,
        tunable=tuple(name for name, kind in kinds.items() if kind == "parameter"),
        free_inputs=tuple(name for name, kind in kinds.items() if kind == "input"),
    )


def _kind(eqs: EquationSet, name: str) -> Kind:
    if name in eqs.parameter_names:
        return "parameter"
    if name in eqs.input_names:
        return "input"
    if name in eqs.state_names:
        return "initial"
    listed = (*eqs.parameter_names, *eqs.input_names, *eqs.state_names)
    raise UsageError(
        Problem("animation.unknown_slider", name,
                f"{name!r} is neither a parameter nor an input, coordinate or speed",
                fix=nearest(name, listed))
    )  # fmt: skip


def _constant_law(name: str, law: Law) -> float:
    """Return the value of an input that a slider moves.

    Raises
    ------
    UsageError
        If it has a law that is no number: the slider would take its place.
    """
    number = Formula.from_value(law).constant() if isinstance(law, int | float | str | Formula) else None
    if number is not None:
        return float(number)
    raise UsageError(
        Problem("animation.slider_law", name, f"{name} has both a formula and a slider",
                "a slider changes a number, and the formula would be lost",
                "give the input a number, remove its slider, or define the formula in the model, with a "
                "parameter that the slider changes")
    )  # fmt: skip


def _control(eqs: EquationSet, value: float, name: str, kind: Kind, bounds: Bounds | None) -> LiveControl:
    unit = eqs.units.get(name, "")
    if bounds is None:
        share = {"parameter": _SHARE, "input": 1.0, "initial": 0.0}[kind]
        reach = share * abs(value) or (math.pi if unit == "rad" else 1.0)
        bounds = (value - reach, value + reach)
    low, high = (float(bound) for bound in bounds)
    if not (np.isfinite([low, high]).all() and low < high):
        raise UsageError(
            Problem("animation.slider", name, f"a slider cannot go from {low} to {high}",
                    fix="give (lowest, highest)")
        )  # fmt: skip
    if not low <= value <= high:
        raise UsageError(
            Problem("animation.slider_start", name,
                    f"{name} starts at {value:.6g}, which is not between {low:g} and {high:g}",
                    fix="choose bounds around it, or another initial value with initial=, parameters= or "
                        "inputs=")
        )  # fmt: skip
    return LiveControl(name, kind, low, high, value, unit)


def _courses(
    eqs: EquationSet, request: MotionRequest, pushed: Mapping[str, float], first: State
) -> dict[str, Any]:
    """Return the coordinates over the first seconds, which say how far guides and tracks reach.

    Parameters
    ----------
    pushed : mapping of str to float
        First values of the inputs with a slider.

    Raises
    ------
    UsageError
        If constraints become dependent in these seconds.
    """
    start = request.span[0]
    run = simulate(
        eqs, (start, start + _PREVIEW), request.initial, parameters=request.parameters,
        inputs={**request.inputs, **pushed}, times=np.linspace(start, start + _PREVIEW, 81),
        integrator=request.integrator, constraints=request.constraints, events=request.events, rtol=1e-6,
        max_steps=_MOST_STEPS,
    )  # fmt: skip
    note = change_point_note(run.notes)
    if note:
        raise UsageError(branch_problem(eqs.model.name, f"the motion passes a change point: {note}"))
    if run.t.size < 2:
        return {name: np.array([value]) for name, value in first.q.items()}
    return coordinate_courses(run)


def _with_arrows(
    chain: Chain, arrows: Sequence[Arrow]
) -> tuple[tuple[str, ...], tuple[int, ...], tuple[int, ...]]:
    """Return the outputs, parents and order of a `PageView` of bodies, after which come arrows.

    To the page an arrow is one more frame on ground: in the place where it acts, 0 where that is fixed on a
    body, and with its components in the first row of its axes.
    """
    bodies = len(chain.names)
    places = [name for arrow in arrows for name in (arrow.places or _ZEROS)]
    axes = [name for arrow in arrows for name in (*arrow.values, *_ZEROS, *_ZEROS)]
    outputs = (*chain.outputs[:bodies], *places, *chain.outputs[bodies:], *axes)
    order = (*chain.order, *range(bodies, bodies + len(arrows)))
    return outputs, (*chain.parents, *([-1] * len(arrows))), order


def _arrow_to_come(arrow: Arrow) -> MotionVector:
    """Return an arrow whose values the page computes."""
    nothing = np.zeros((1, 3))
    places = nothing if arrow.places else None
    return MotionVector(arrow.name, arrow.kind, arrow.anchor, nothing, places, arrow.prints)


def _spring(scene: Scene) -> tuple[float, float]:
    """Return the mass of all bodies [kg], and the frequency of a point that a pointer holds [rad/s]."""
    mass = sum(body.mass for body in scene.bodies[1:] if math.isfinite(body.mass))
    slow, fast = _FREQUENCIES
    frequency = _PULL * math.sqrt(9.81 / max(scene.size, 1e-9))
    return max(mass, 1e-9), min(max(frequency, slow), fast)


def _scene_tables(
    model: Model, values: Mapping[str, float], courses: Mapping[str, Any], controls: Sequence[LiveControl]
) -> Iterator[dict[str, Any]]:
    """Yield the numbers of the scene that follow a slider, at equal distances of its parameter."""
    for control in controls:
        if control.kind != "parameter":
            continue
        places = np.linspace(control.min, control.max, _TABLE)
        scenes = [make_scene(model, {**values, control.name: float(place)}, courses) for place in places]
        forms = [scene_to_json(replace(scene, meshes=())) for scene in scenes]
        entries: list[list[Any]] = [[list(way), numbers] for way, numbers in _differences((), forms)]
        entries += _mesh_changes(scenes)
        if entries:
            yield {"parameter": control.name, "min": control.min, "max": control.max, "entries": entries}


def _mesh_changes(scenes: Sequence[Scene]) -> list[list[Any]]:
    """Return the ways to the corners of meshes that change, and these corners, one scene after the other."""
    if len({len(scene.meshes) for scene in scenes}) > 1:
        return []
    changes: list[list[Any]] = []
    for place, meshes in enumerate(zip(*(scene.meshes for scene in scenes), strict=True)):
        first = meshes[0]
        alike = all(np.array_equal(mesh.triangles, first.triangles) for mesh in meshes)
        if not alike or any(mesh.vertices.shape != first.vertices.shape for mesh in meshes):
            continue
        if any(not np.array_equal(mesh.vertices, first.vertices) for mesh in meshes):
            changes.append([["meshes", place, "vertices"], encode_array([mesh.vertices for mesh in meshes])])
    return changes


def _differences(way: tuple[Any, ...], items: Sequence[Any]) -> Iterator[tuple[tuple[Any, ...], list[float]]]:
    """Yield the ways to numbers that differ between values of one form, and these numbers."""
    first = items[0]
    if isinstance(first, dict) and all(
        isinstance(each, dict) and each.keys() == first.keys() for each in items
    ):
        for key in (key for key in first if key != "mass"):  # which is not drawn
            yield from _differences((*way, key), [each[key] for each in items])
    elif isinstance(first, list) and all(
        isinstance(each, list) and len(each) == len(first) for each in items
    ):
        for k in range(len(first)):
            yield from _differences((*way, k), [each[k] for each in items])
    elif all(isinstance(each, int | float) and not isinstance(each, bool) for each in items):
        if any(each != first for each in items):
            yield way, [float(each) for each in items]


def _equations(eqs: EquationSet) -> str:
    """Return all equations as HTML, empty where they are too long to be read."""
    if not eqs.speed_names or len(eqs.speed_names) > _MOST_SPEEDS:
        return ""
    if equation_operations(eqs.textbook) > _MOST_OPERATIONS:
        return ""
    return f"<div>{equations_page(eqs.textbook)}</div>"


def _symbol(name: str) -> str:
    """Return the name of a slider as MathML."""
    for order, ending in ((2, "_ddot"), (1, "_dot")):
        if name.endswith(ending):
            return f"<span>{math_element(mathml_name(name.removesuffix(ending), order))}</span>"
    return f"<span>{math_element(mathml_name(name))}</span>"
