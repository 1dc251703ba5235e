"""Live pictures in notebooks: sliders that move coordinates and parameters, assembled as they move."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.state import State
from symbody.codegen.compile import compile
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, FormulationError, Problem, SimulationError, UsageError, nearest
from symbody.model.model import Model, resolve_parameters
from symbody.visual.scene import make_motion, make_scene
from symbody.visual.scene.body_poses import Chain, chain_of
from symbody.visual.scene.scene import Scene
from symbody.visual.viewer.page import PageData, page_data
from symbody.visual.viewer.still import run_of_state

Slider = str | tuple[str, float, float]
Pose = dict[str, list[list[float]]]

_SHARE: Final = 0.5  # of a parameter's value, to both sides


@dataclass(frozen=True, slots=True)
class SliderRange:
    """A slider: what it moves, between which values, and where it starts."""

    name: str
    min: float
    max: float
    value: float
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class SliderMechanism:
    """A mechanism that is assembled anew for the values of its sliders.

    Attributes
    ----------
    eqs : EquationSet
        Its equations.
    sliders : tuple of SliderRange
        Coordinates and parameters that move.
    first : State
        Where it starts.
    chain : Chain
        Its bodies.
    poses : callable
        Computes where these are, with the parameters among the sliders as arguments.
    """

    eqs: EquationSet
    sliders: tuple[SliderRange, ...]
    first: State
    chain: Chain
    poses: Any

    def state(self, values: Mapping[str, float], near: State, chosen: Collection[str] = ()) -> State:
        """Return the configuration nearest to another one for the values of sliders.

        Parameters
        ----------
        chosen : names
            Sliders that hold where they contradict others, which follow then.

        Raises
        ------
        AssemblyError
            If there is none.
        """
        parameters = {name: value for name, value in values.items() if name in self.eqs.parameter_names}
        fixed = {name: value for name, value in values.items() if name not in parameters}
        guess = {**near.q, **dict.fromkeys(near.u, 0.0)}
        try:
            return assemble(self.eqs, fixed, guess, parameters=parameters, t=near.t)
        except AssemblyError:
            held = {name: value for name, value in fixed.items() if name in chosen}
            if held == fixed:
                raise
            return assemble(self.eqs, held, guess, parameters=parameters, t=near.t)

    def pose(self, state: State) -> Pose:
        """Return where the bodies are, as the page takes it."""
        values = self.parameters(state)
        free = [values[slider.name] for slider in self.sliders if slider.name in self.eqs.parameter_names]
        inputs = np.zeros(len(self.eqs.input_names))
        arrays = self.poses(state.t, list(state.q.values()), list(state.u.values()), inputs, free)
        outputs = {
            name: np.asarray(array)[..., np.newaxis]
            for name, array in zip(self.chain.outputs, arrays, strict=True)
        }
        poses = self.chain.poses(outputs, 1)
        return {"positions": poses.positions[0].tolist(), "quaternions": poses.quaternions[0].tolist()}

    def parameters(self, state: State) -> dict[str, float]:
        """Return the value of every parameter in a state."""
        return _parameters(self.eqs.model, state)

    def scene(self, state: State) -> Scene:
        """Return the shapes, which follow the parameters."""
        courses = {name: np.array([value]) for name, value in state.q.items()}
        return make_scene(self.eqs.model, self.parameters(state), courses)

    def data(self, state: State, title: str, options: Mapping[str, Any]) -> PageData:
        """Return the data of the widget: the mechanism at rest."""
        scene = self.scene(state)
        motion = make_motion(run_of_state(state), scene, curves=(), vectors="none")
        return page_data(scene, motion, title, options)


def slider_mechanism(eqs: EquationSet, sliders: Sequence[Slider]) -> SliderMechanism:
    """Return a mechanism with sliders.

    Parameters
    ----------
    sliders : sequence of name or (name, lowest, highest)
        Coordinates and parameters. Without bounds an angle goes half a turn to both sides, a length as far
        as the mechanism is large, a parameter half of its value.

    Raises
    ------
    UsageError
        If a name is neither a coordinate nor a parameter, or bounds are none.
    """
    if not isinstance(eqs.model, Model):
        what = "mechanisms assembled by hand have no shapes"
        raise UsageError(
            Problem("animation.no_model", "animate", what, fix="describe the mechanism as a Model")
        )
    first = assemble(eqs)
    size = make_scene(eqs.model, _parameters(eqs.model, first)).size
    ranges = tuple(_slider_range(eqs, first, size, slider) for slider in sliders)
    trees = eqs.formed.topology
    chain = chain_of(
        eqs.model,
        [body.name for body in eqs.model.bodies],
        inside=trees.rotation_branches & trees.translation_branches,
    )
    free = [slider.name for slider in ranges if slider.name in eqs.parameter_names]
    return SliderMechanism(eqs, ranges, first, chain, compile(eqs, chain.outputs, free=free, quick=True))


def _slider_range(eqs: EquationSet, first: State, size: float, slider: Slider) -> SliderRange:
    name, *bounds = (slider,) if isinstance(slider, str) else slider
    if name in eqs.parameter_names:
        value = _parameters(eqs.model, first)[name]
        reach = _SHARE * abs(value) or 1.0
    else:
        value = _number(first, name)
        reach = math.pi if eqs.units.get(name, "") == "rad" else size
    low, high = bounds or (value - reach, value + reach)
    if not (np.isfinite([low, high]).all() and low < high):
        raise UsageError(
            Problem("animation.slider", name, f"a slider cannot go from {low} to {high}",
                    fix="give (name, lowest, highest)")
        )  # fmt: skip
    return SliderRange(name, float(low), float(high), min(max(value, low), high), eqs.units.get(name, ""))


def _number(state: State, name: str) -> float:
    try:
        value = np.asarray(state[name])
    except (FormulationError, SimulationError):
        value = np.empty(0)
    eqs = state.eqs
    if value.shape != () or name not in _coordinates(eqs):
        known = (*eqs.coordinate_names, *eqs.parameter_names)
        raise UsageError(
            Problem("animation.unknown_slider", name, f"{name!r} is neither a coordinate nor a parameter",
                    fix=nearest(name, known))
        )  # fmt: skip
    return float(value)


def _coordinates(eqs: EquationSet) -> set[str]:
    return {*eqs.coordinate_names, *(name for joint in eqs.model.joints for name in joint.coordinates)}


def _parameters(model: Model, state: State) -> dict[str, float]:
    return {name: float(value) for name, value in resolve_parameters(model, state.parameters).items()}
