"""`make_motion`: the poses of all bodies over time, thinned to what the eye needs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from symbody.arguments import checked_arguments
from symbody.errors import Problem, UsageError
from symbody.model.model import Model
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.plotting.curves import curves_of
from symbody.visual.scene.body_poses import Chain, Floats, chain_of, of_one_sign
from symbody.visual.scene.force_arrows import Arrow, arrows_of, vectors_of
from symbody.visual.scene.sampling import Sampled, sample, thin
from symbody.visual.scene.scene import MotionCurve, Scene, SceneMotion

MOST_SAMPLES: Final = 4000
_MOST_POSES: Final = 200_000  # of all bodies at all times: some megabytes
_FEWEST: Final = 300  # that much every motion gets, however many bodies it has
_MOST_CURVES: Final = 12  # without a choice


@checked_arguments
def make_motion(
    run: Trajectory,
    scene: Scene,
    times: ArrayLike | None = None,
    curves: Sequence[str] | None = None,
    vectors: str | Sequence[str] | None = None,
    span: tuple[float, float] | None = None,
) -> SceneMotion:
    """Return where the bodies of a scene are during a motion.

    Between its samples positions are interpolated along lines and orientations about fixed axes; the samples
    are as many as keep that within a thousandth of the scene's size and 0.2 degrees, and curves within a
    300th of their range, but not more than 4000. A motion without dense output has samples of its own only.

    Parameters
    ----------
    run : Trajectory
        With its model.
    scene : Scene
        Of the same model.
    times : (N,) array, optional
        The samples themselves [s].
    curves : sequence of str, optional
        Outputs to be drawn over time; by default the coordinates, at most twelve.
    vectors : "all", "applied", "none" or sequence of str, optional
        Forces and torques to be drawn: those named by their elements; by default those of `Force` and
        `Torque`, if they are few. "all" adds reactions of joints and forces of springs.
    span : (start, end), optional
        The part of the motion that is shown [s]; by default all of it.

    Raises
    ------
    UsageError
        If the run has no model, no sample, or names are unknown.
    """
    model = _model(run)
    if curves is None:
        curves = run.coordinate_names[:_MOST_CURVES]
    arrows = arrows_of(model, scene, vectors)
    inside = None
    if run.provenance is not None:
        trees = run.provenance.trees
        inside = {*trees.rotation} & {*trees.translation}
    chain = chain_of(model, [body.name for body in scene.bodies[1:]], inside)
    source = _Source(run, chain, tuple(curves), tuple(arrows))
    samples = _samples(source, scene.size, times, span)
    shown = source.outputs(samples.times)
    return SceneMotion(
        samples.times,
        samples.poses.positions,
        of_one_sign(samples.poses.quaternions),
        _curves(shown, curves),
        vectors_of(arrows, {name: np.asarray(shown.stored[name]) for name in shown.stored}, scene.size),
        tuple((name, float(t)) for name, t, _ in run.events),
    )


def coordinate_courses(run: Trajectory) -> dict[str, Floats]:
    """Return the coordinates of joints at the samples (N,), those that couplings and motions give included.

    Guides are as long as these need. Coordinates that the run cannot compute, as of cut joints, are left out.
    """
    courses = dict(zip(run.coordinate_names, np.atleast_2d(run.q), strict=True))
    if run.model is None or run.provenance is None:
        return courses
    trees = {*run.provenance.trees.rotation, *run.provenance.trees.translation}
    for joint in run.model.joints:
        for name in joint.coordinates if joint.name in trees else ():
            if name not in courses:
                try:
                    courses[name] = np.atleast_1d(run[name])
                except UsageError:
                    continue
    return courses


def _model(run: Trajectory) -> Model:
    if run.t.size == 0:
        raise UsageError(
            Problem("animation.no_samples", "run", "the motion has no samples: nothing was computed",
                    fix="see run.status and run.notes")
        )  # fmt: skip
    if run.model is None:
        raise UsageError(
            Problem("animation.no_model", "run", "the motion does not contain its mechanism",
                    "its file was written by an older version, or its equations were assembled by hand",
                    "animate(run, model=...) with the model it was computed from")
        )  # fmt: skip
    return run.model


@dataclass(frozen=True, slots=True, eq=False)
class _Source:
    """A run, and what is drawn of it.

    Attributes
    ----------
    chain : Chain
        The bodies.
    curves : tuple of str
        Outputs.
    arrows : tuple of Arrow
        Forces and torques.
    """

    run: Trajectory
    chain: Chain
    curves: tuple[str, ...]
    arrows: tuple[Arrow, ...]

    def motion(self, times: Floats) -> Trajectory:
        """Return the run at times: any where there is dense output, else some of its samples."""
        run = self.run
        if run.dense_output is not None:
            moved = run.at(times)
            only_stored = (run.stored.keys() - {"work"}) & {*self.curves}
            return replace(moved, stored={name: _interpolate(run, name, times) for name in only_stored})
        t = np.atleast_1d(run.t)
        order = np.argsort(t, kind="stable")
        places = order[np.searchsorted(t[order], times, side="right") - 1]
        stored = {name: np.atleast_1d(values)[..., places] for name, values in run.stored.items()}
        q, u, s = (array.reshape(-1, t.size)[:, places] for array in (run.q, run.u, run.s))
        return replace(run, t=t[places], q=q, u=u, s=s, stored=stored)

    def sample(self, times: Floats) -> Sampled:
        """Return poses and curves at times."""
        run = self.motion(times)
        outputs = _values_of(run, (*self.chain.outputs, *self.curves))
        rows = [outputs[name].reshape(-1, times.size) for name in self.curves]
        values = np.concatenate([np.empty((0, times.size)), *rows]).T
        return Sampled(times, self.chain.poses(outputs, times.size), values)

    def outputs(self, times: Floats) -> Trajectory:
        """Return the run at times with all curves and forces stored."""
        run = self.motion(times)
        names = dict.fromkeys([*self.curves, *(name for arrow in self.arrows for name in arrow.outputs)])
        return replace(run, stored={**run.stored, **_values_of(run, names)})


def _values_of(run: Trajectory, names: Iterable[str]) -> dict[str, Floats]:
    """Return the samples by name; `run.outputs` without any name would say what there is."""
    asked = tuple(names)
    return run.outputs(*asked) if asked else {}


def _interpolate(run: Trajectory, name: str, times: Floats) -> Floats:
    """Return the stored values, interpolated linearly between samples."""
    values = run.stored[name].reshape(-1, run.t.size)
    order = np.argsort(run.t, kind="stable")
    rows = np.array([np.interp(times, run.t[order], row[order]) for row in values])
    return rows.reshape(*run.stored[name].shape[:-1], times.size)


def _samples(
    source: _Source, size: float, times: ArrayLike | None, span: tuple[float, float] | None
) -> Sampled:
    run = source.run
    if times is not None:
        return source.sample(_chosen_times(run, times))
    bodies = max(len(source.chain.names), 1)
    most = min(MOST_SAMPLES, max(_FEWEST, _MOST_POSES // bodies))
    every = _clip_times(run, np.unique(np.atleast_1d(run.t)), span)
    if run.dense_output is None:
        return thin(source.sample(every), size, most)
    ends = [float(t) for _, t, _ in run.events if every[0] < t < every[-1]]
    return sample(source.sample, np.union1d(every, ends), size, most)


def _clip_times(run: Trajectory, every: Floats, span: tuple[float, float] | None) -> Floats:
    """Return the times between two, and these themselves where the motion is known there."""
    if span is None:
        return every
    first, last = span
    if not every[0] <= first < last <= every[-1]:
        raise _times(
            f"{first:g} to {last:g} s is not part of the motion",
            f"it runs from {every[0]:g} to {every[-1]:g} s",
        )
    between = every[(every >= first) & (every <= last)]
    if run.dense_output is None:
        return between if between.size else every[[int(np.argmin(np.abs(every - first)))]]
    return np.union1d(between, [first, last])


def _chosen_times(run: Trajectory, times: ArrayLike) -> Floats:
    try:
        chosen = np.unique(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        chosen = np.empty(0)
    if chosen.size == 0 or not np.isfinite(chosen).all():
        raise _times(f"{times!r} are not valid times", "give times [s], as by numpy.linspace(0, 2, 50)")
    if run.dense_output is None and not np.isin(chosen, run.t).all():
        raise _times("the motion between the samples was not stored", "choose times from run.t")
    return chosen


def _times(what: str, fix: str) -> UsageError:
    return UsageError(Problem("animation.times", "times", f"nothing can be shown: {what}", fix=fix))


def _curves(run: Trajectory, names: Iterable[str]) -> tuple[MotionCurve, ...]:
    return tuple(
        MotionCurve(curve.name, curve.unit, np.asarray(curve.values))
        for name in names
        for curve in curves_of(run, name)
    )
