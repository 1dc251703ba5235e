"""The examples as test objects: their models, random consistent states, and what is measured on them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import symbody as sb
from symbody.formats.native import from_data
from symbody.model.model import resolve_parameters

Array = NDArray[np.float64]
EXAMPLES = Path(__file__).parents[2] / "examples"
EPS = float(np.finfo(float).eps)
# The models of all examples that have one file more than their folder says.
NAMES = (
    "projectile/projectile", "projectile/projectile_free", "rr_robot/rr_robot", "spinning_top/spinning_top",
    "spinning_top_omega/spinning_top_omega", "slider_crank/slider_crank", "four_bar/four_bar",
    "spatial_four_bar/spatial_four_bar",
)  # fmt: skip


def data_of(name: str) -> dict[str, Any]:
    """The content of an example's model file."""
    path = EXAMPLES / (f"{name}.toml" if "/" in name else f"{name}/{name}.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))


@cache
def model_of(name: str) -> sb.Model:
    return sb.load_model(EXAMPLES / (f"{name}.toml" if "/" in name else f"{name}/{name}.toml"))


@cache
def equations_of(name: str) -> sb.EquationSet:
    return sb.form_equations(model_of(name))


@cache
def compiled(eqs: sb.EquationSet, *outputs: str) -> sb.CompiledFunction:
    return sb.compile(eqs, outputs)


def numbers_of(model: sb.Model) -> dict[str, float]:
    """The values of the parameters."""
    return {name: float(value) for name, value in resolve_parameters(model).items()}


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Coordinates, speeds and inputs as the functions of an EquationSet take them."""

    q: Array
    u: Array
    r: Array


def state_of(eqs: sb.EquationSet, values: Mapping[str, float]) -> State:
    """The state with these values by name."""
    names = (eqs.coordinate_names, eqs.speed_names, eqs.input_names)
    q, u, r = (np.array([values[name] for name in group]) for group in names)
    return State(q, u, r)


def random_values(eqs: sb.EquationSet, rng: np.random.Generator) -> dict[str, float]:
    """A value by name for all states and inputs, consistent in positions and velocities.

    Angles keep away from the singular positions of Euler angles 0, pi/2, pi.
    """
    names = (*eqs.coordinate_names, *eqs.speed_names, *eqs.input_names)
    values = {name: float(rng.choice([-1, 1]) * rng.uniform(0.3, 1.3)) for name in names}
    if eqs.multiplier_names:
        values |= _CLOSED[eqs.model.name](numbers_of(eqs.model), float(rng.uniform(-3, 3)), values)
        values |= dict(zip(eqs.speed_names, consistent_speeds(eqs, state_of(eqs, values)), strict=True))
    return values


def consistent_speeds(eqs: sb.EquationSet, state: State) -> Array:
    """The speeds nearest to those of a state that keep the constraints."""
    jacobian, violation = compiled(eqs, "jacobian", "velocity_constraints")(0.0, state.q, state.u, state.r)
    return state.u - np.linalg.lstsq(jacobian, violation, rcond=None)[0]


def _slider_crank(p: Mapping[str, float], theta: float, values: Mapping[str, float]) -> dict[str, float]:
    beta = math.asin(-p["L1"] * math.sin(theta) / p["L2"])
    return {"theta": theta, "beta": beta, "s": p["L1"] * math.cos(theta) + p["L2"] * math.cos(beta)}


def _four_bar(p: Mapping[str, float], theta: float, values: Mapping[str, float]) -> dict[str, float]:
    """The rod from the crank's pin to the rocker's pin has length b."""
    a, b, c, d = (p[name] for name in "abcd")
    along, across = d - a * math.cos(theta), a * math.sin(theta)
    phi = math.asin((b * b - c * c - across**2 - along**2) / (2 * along * c))
    x, y, z = along + c * math.sin(phi), -across, c * math.cos(phi)
    yaw = math.atan2(y, x) - theta
    return {"theta": theta, "phi": phi, "psi": yaw, "chi": -math.asin(z / b)}


def _planar_four_bar(p: Mapping[str, float], theta: float, values: Mapping[str, float]) -> dict[str, float]:
    """C lies on circles about the crank's pin and the rocker's post; the coupler is above them."""
    pin = np.array([p["L1"] * math.cos(theta), p["L1"] * math.sin(theta)])
    line = np.array([p["L4"], 0.0]) - pin
    length = float(np.hypot(*line))
    corner = math.acos((length**2 + p["L2"] ** 2 - p["L3"] ** 2) / (2 * length * p["L2"]))
    coupler = math.atan2(line[1], line[0]) + corner
    x, y = pin + p["L2"] * np.array([math.cos(coupler), math.sin(coupler)]) - np.array([p["L4"], 0.0])
    return {"theta": theta, "beta": coupler - theta, "phi": math.atan2(y, x)}


_CLOSED: Mapping[str, Callable[[Mapping[str, float], float, Mapping[str, float]], dict[str, float]]] = {
    "slider-crank": _slider_crank,
    "four-bar": _planar_four_bar,
    "spatial four-bar": _four_bar,
}


def condition(eqs: sb.EquationSet, state: State) -> float:
    """The condition of [[M, J^T], [J, 0]] on the range of J: redundant rows do not count."""
    M, J = compiled(eqs, "mass_matrix", "jacobian")(0.0, state.q, state.u, state.r)
    K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    singular = np.linalg.svd(K, compute_uv=False)
    return float(singular[0] / singular[singular > 1e-11 * singular[0]][-1])


def motions(eqs: sb.EquationSet) -> Callable[[State], dict[str, Array]]:
    """A function for place, velocity and acceleration of every body, and the reaction of every joint."""
    kinds = {"r": " ground ground", "R": " ground", "v": " ground ground", "w": " ground ground",
             "vdot": " ground ground", "wdot": " ground ground"}  # fmt: skip
    bodies = [f"frame {kind} {body.name}{rest}" for body in eqs.model.bodies for kind, rest in kinds.items()]
    names = [*bodies, *(f"reaction {joint.name}" for joint in eqs.model.joints)]
    function = compiled(eqs, *names)
    return lambda state: dict(zip(names, function(0.0, state.q, state.u, state.r), strict=True))


def absolute_values(eqs: sb.EquationSet, measured: Mapping[str, Array]) -> dict[str, float]:
    """Coordinates and speeds of free bodies at places and velocities as `motions` gives them."""
    values: dict[str, float] = {}
    for body in eqs.model.bodies:
        r, R, v, w = (measured[f"frame {kind} {body.name} ground{rest}"]
                      for kind, rest in (("r", " ground"), ("R", ""), ("v", " ground"), ("w", " ground")))  # fmt: skip
        columns = {"x": r[0], "y": r[1], "z": r[2], "vx": v[0], "vy": v[1], "vz": v[2]}
        columns |= dict(zip(("qw", "qx", "qy", "qz"), quaternion(R), strict=True))
        columns |= dict(zip(("wx", "wy", "wz"), R.T @ w, strict=True))
        values |= {f"{body.name}_{word}": float(value) for word, value in columns.items()}
    return values


def quaternion(R: Array) -> Array:
    """The unit quaternion, scalar first, of a rotation matrix, by its largest component."""
    K = np.empty((4, 4))
    K[0, 0] = np.trace(R)
    K[0, 1:] = K[1:, 0] = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    K[1:, 1:] = R + R.T - np.trace(R) * np.eye(3)
    # K + 1 is four times the projector on the quaternion.
    column = (K + np.eye(4))[:, int(np.argmax(np.diag(K)))]
    unit: Array = column / np.linalg.norm(column)
    return unit


def turned(data: Mapping[str, Any], rng: np.random.Generator) -> sb.Model:
    """The same mechanism in other axes of ground and of every body.

    All joints stand in the same places as before, so coordinates, speeds and reactions keep their values.
    """
    result = deepcopy(dict(data))
    angles = rng.uniform(-3, 3, 3)
    ground = result.setdefault("ground", {}).setdefault("frames", {})
    result["gravity"] = _times(_matrix(angles).T, result["gravity"])
    _turn_frames(ground, angles)
    for body in result["body"]:
        angles = rng.uniform(-3, 3, 3)
        _turn_frames(body.setdefault("frames", {}), angles)
        tensor = _tensor(body)
        R = _matrix(angles)
        rows = [_times(R.T, row) for row in tensor]  # tensor R, by its symmetry row by row
        columns = [_times(R.T, [rows[i][j] for i in range(3)]) for j in range(3)]
        body["inertia"] = [columns[k][k] for k in range(3)]
        body["products"] = [columns[1][0], columns[2][0], columns[2][1]]
    for joint in result["joint"]:
        joint["between"] = [place if "." in place else f"{place}.turned" for place in joint["between"]]
    return from_data(result)


def _tensor(body: Mapping[str, Any]) -> list[list[str]]:
    """The inertia tensor; moments that a fixed axis makes idle are filled so that a body can have them."""
    moments = body.get("inertia", ["0"] * 3)
    own = [moment for moment in moments if moment != "0"]
    xx, yy, zz = [moment if moment != "0" or not own else own[0] for moment in moments]
    return [[xx, "0", "0"], ["0", yy, "0"], ["0", "0", zz]]


def _turn_frames(frames: dict[str, Any], angles: Sequence[float]) -> None:
    back = [["x", repr(-float(angles[2]))], ["y", repr(-float(angles[1]))], ["z", repr(-float(angles[0]))]]
    for frame in frames.values():
        frame["at"] = _times(_matrix(angles).T, frame.get("at", ["0"] * 3))
        frame["rotate"] = back + frame.get("rotate", [])
    frames["turned"] = {"rotate": back}


def _matrix(angles: Sequence[float]) -> Array:
    """Rz Ry Rx."""
    (cz, cy, cx), (sz, sy, sx) = np.cos(angles), np.sin(angles)
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    product: Array = z @ y @ x
    return product


def _times(matrix: Array, column: Sequence[str]) -> list[str]:
    """A matrix of numbers times a column of formulas."""
    return [
        " + ".join(f"({float(a)!r})*({b})" for a, b in zip(row, column, strict=True) if str(b) != "0") or "0"
        for row in matrix
    ]
