"""A body that is dragged in the picture: the configuration that brings a point of it to the pointer.

The direction of each step follows from the freedoms that the constraints leave; the step is a guess from
which assembly closes the loops, so that every pose that is shown is an assembled one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.closed_gaps import with_closed_gaps
from symbody.analysis.configurations.positions import PositionSolver
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.builder.page_problems import page_problem, page_problems
from symbody.builder.task_failure import Report, TaskFailure
from symbody.builder.tasks.mechanisms import solver_of
from symbody.builder.tasks.placement import placed_motion, scene_bodies
from symbody.builder.tasks.reading import Data, Latest, complete_model, model_key
from symbody.errors import AssemblyError, Problem, SymbodyError
from symbody.manifold import null_space
from symbody.tolerances import DIFFERENCE, SHARP_RANK

Floats = NDArray[np.float64]

_ROUNDS: Final = 8  # steps of one request
_HALVINGS: Final = 5
_REACH: Final = 0.35  # of one step: rad, or the size of the mechanism
_JUMP: Final = 4.0  # times a step: an assembly that is farther from its guess is another branch
_NEAR: Final = 1e-5  # of the size of the mechanism: the point is where the pointer is
_DAMPING: Final = 3e-2  # of the size of the mechanism: what keeps steps short near dead centres
_STILL: Final = 1e-6  # of the size of the mechanism: what moves a point less than this does not move it
_TINY: Final = 1e-4  # of sizes: steps and gains below this are not worth another round
_GRIPS: Final[Latest[Grip]] = Latest(8)


@dataclass(frozen=True, slots=True, eq=False)
class Grip:
    """A body of a mechanism that can be dragged.

    Attributes
    ----------
    task : ConstraintEvaluator
        Without ropes and stops: which gaps are closed is for assembly to say.
    """

    solver: PositionSolver
    task: ConstraintEvaluator
    body: str

    def place(self, q: Floats, point: Floats) -> Floats:
        """Return where a point (3,) of the body is in ground's axes [m]."""
        outputs = (f'frame r "{self.body}" ground ground', f'frame R "{self.body}" ground')
        at, axes = self.task.compile(outputs)(self.task.t, q, np.zeros(len(self.task.eqs.speed_names)))
        return np.asarray(np.ravel(at) + np.reshape(axes, (3, 3)) @ point)

    def slopes(self, q: Floats, point: Floats) -> Floats:
        """Return the derivatives (3, n_q) of a point by the coordinates, each in its size."""
        columns = np.zeros((3, q.size))
        for k in range(q.size):
            step = np.zeros(q.size)
            step[k] = DIFFERENCE * self.task.sizes[k]
            columns[:, k] = self.place(q + step, point) - self.place(q - step, point)
        return columns / (2.0 * DIFFERENCE)

    def freedoms(self, q: Floats) -> Floats:
        """Return the directions (n_q, f) of coordinates, each in its size, that the constraints leave."""
        return null_space(self.task.manifold().jacobian(q), SHARP_RANK)


@dataclass(frozen=True, slots=True, eq=False)
class PointDrag:
    """A point of a body (3,) [m] and the line of sight, in ground's axes, on which it should be."""

    grip: Grip
    point: Floats
    origin: Floats
    direction: Floats

    @property
    def size(self) -> float:
        """The length of the mechanism [m]."""
        return self.grip.task.mechanism.length

    def lateral_part(self, vectors: Floats) -> Floats:
        """Return the parts of vectors (3, ...) that are across the line."""
        return vectors - np.multiply.outer(self.direction, self.direction @ vectors)

    def miss(self, q: Floats) -> Floats:
        """Return the way (3,) from the point to the line [m]."""
        return self.lateral_part(self.origin - self.grip.place(q, self.point))

    def distance(self, q: Floats) -> float:
        """Return how far the point is from the line [m]."""
        return float(np.linalg.norm(self.miss(q)))

    def step(self, q: Floats) -> Floats | None:
        """Return the change of the coordinates (n_q,) that leads towards the line; None if none moves it."""
        freedoms = self.grip.freedoms(q)
        moves = self.grip.slopes(q, self.point) @ freedoms
        if np.abs(moves).max(initial=0.0) < _STILL * self.size:
            return None
        seen = self.lateral_part(moves)
        damping = (_DAMPING * self.size) ** 2 * np.eye(freedoms.shape[1])
        turn = freedoms @ np.linalg.solve(seen.T @ seen + damping, seen.T @ self.miss(q))
        share = min(1.0, _REACH / max(float(np.abs(turn).max(initial=0.0)), 1e-300))
        return np.asarray(share * turn * self.grip.task.sizes)


def drag_body(payload: Mapping[str, Any], report: Report) -> dict[str, Any]:
    """Return values of all coordinates, where the bodies stand, and how far the point is from the pointer.

    Raises
    ------
    TaskFailure
        If the loops do not close, or nothing moves the body.
    """
    data, folder, body = payload["data"], payload["folder"], payload["body"]
    key = model_key(data, folder)
    try:
        drag = _point_drag(payload, _GRIPS.get(f"{body}\n{key}", lambda: _grip(data, folder, body)))
        solver = drag.grip.solver
        q = follow_line(drag, _start(solver, payload["guess"]))
        values = dict(zip(solver.eqs.coordinate_names, q.tolist(), strict=True))
        motion = placed_motion(solver.eqs, values, scene_bodies(solver.eqs.model))
    except SymbodyError as error:
        raise TaskFailure(page_problems(error.problems, data)) from None
    return {
        "values": {**values, **_cut_coordinates(drag.grip.task, q)},
        "positions": motion.positions[0].tolist(),
        "quaternions": motion.quaternions[0].tolist(),
        "at": drag.grip.place(q, drag.point).tolist(),
        "distance": drag.distance(q),
        "size": drag.size,
    }


def follow_line(drag: PointDrag, q: Floats) -> Floats:
    """Return the coordinates at which the point is as near to the line as steps from `q` lead.

    Raises
    ------
    AssemblyError
        If not even the first step can be assembled.
    TaskFailure
        If no freedom moves the point.
    """
    start, distance = q, drag.distance(q)
    for _ in range(_ROUNDS):
        if distance < _NEAR * drag.size:
            break
        step = drag.step(q)
        if step is None and q is start:
            raise TaskFailure([page_problem(_immovable(drag.grip.body), {})])
        if step is None or np.abs(step / drag.grip.task.sizes).max() < _TINY:
            break
        nearer, failure = _step_nearer(drag, q, step)
        if nearer is None and failure is not None and q is start:
            raise failure
        if nearer is None:
            break
        before, q, distance = distance, nearer, drag.distance(nearer)
        if before - distance < _TINY * drag.size:
            break
    return q


def _step_nearer(drag: PointDrag, q: Floats, step: Floats) -> tuple[Floats | None, AssemblyError | None]:
    """Return assembled coordinates nearer to the line, and what assembly said of longer steps."""
    failure, sizes, before = None, drag.grip.task.sizes, drag.distance(q)
    for _ in range(_HALVINGS):
        try:
            tried = drag.grip.solver.nearest(q + step)
        except AssemblyError as error:
            failure = failure or error
        else:
            moved, meant = (float(np.abs(each / sizes).max(initial=0.0)) for each in (tried - q, step))
            if moved <= _JUMP * meant and drag.distance(tried) < before:
                return tried, failure
        step = step / 2.0
    return None, failure


def _point_drag(payload: Mapping[str, Any], grip: Grip) -> PointDrag:
    point, origin, direction = (np.array(payload[name]) for name in ("point", "origin", "direction"))
    length = float(np.linalg.norm(direction))
    if not (np.isfinite([*point, *origin]).all() and np.isfinite(length) and length > 0.0):
        raise TaskFailure([page_problem(_no_line(), {})])
    return PointDrag(grip, point, origin, direction / length)


def _grip(data: Data, folder: str, body: str) -> Grip:
    model = complete_model(data, folder)
    if body not in scene_bodies(model):
        raise TaskFailure([page_problem(_unknown(body), data)])
    solver = solver_of(data, folder, model)
    return Grip(
        solver, solver.evaluator or constraint_evaluator(with_closed_gaps(solver.eqs, ()), {}, {}, 0.0), body
    )


def _start(solver: PositionSolver, guess: Mapping[str, float]) -> Floats:
    """Return assembled coordinates at the pose of before."""
    names = solver.eqs.coordinate_names
    if not guess.keys() >= set(names):
        return np.array(list(solver.positions({}, guess).values()))
    return solver.nearest(np.array([guess[name] for name in names]))


def _cut_coordinates(task: ConstraintEvaluator, q: Floats) -> dict[str, float]:
    """Return the coordinates of cut joints that the model has initial values of."""
    known = dict.fromkeys(task.eqs.model.initial, 0.0)
    return {
        name: task.measure(name, q)
        for name in task.split_values(known)[0]
        if name not in task.eqs.coordinate_names
    }


def _immovable(body: str) -> Problem:
    return Problem(
        "builder.immovable", body, f"nothing moves this point of {body} from here",
        "its motion is prescribed, or the mechanism is locked, or this is a dead centre",
        "drag another body, or move a coordinate by its slider",
    )  # fmt: skip


def _unknown(body: str) -> Problem:
    return Problem("builder.drag", body, f"there is no body {body!r}", fix="drag a body of the picture")


def _no_line() -> Problem:
    return Problem(
        "builder.drag", "direction", "the pointer has no position in the picture", fix="press on a body again"
    )
