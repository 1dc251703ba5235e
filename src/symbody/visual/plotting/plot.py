"""Pictures of a motion: outputs over time or over each other, and paths, drawn with matplotlib."""

from __future__ import annotations

import pathlib
from collections.abc import Sequence
from os import PathLike

from matplotlib.axes import Axes

import symbody
from symbody.analysis.linear.linearization import Linearization
from symbody.arguments import checked_arguments
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.sweeps.result import Sweep
from symbody.visual.plotting.canvas import (
    draw,
    is_in_space,
    label_curves,
    label_panels,
    label_paths,
    new_axes,
    new_panels,
    panels_beside,
)
from symbody.visual.plotting.curves import (
    PlanePath,
    PlottedCurve,
    curves_of,
    in_their_plane,
    path_of,
    rename_curves,
    single_curve,
)
from symbody.visual.plotting.event_marks import mark_events
from symbody.visual.plotting.line_sampling import is_continuous, smooth_motion
from symbody.visual.plotting.sweep_plot import plot_sweep


@checked_arguments
def plot(
    run: Trajectory | Sweep,
    *expressions: str | tuple[str, ...],
    ax: Axes | None = None,
    x: str = "t",
    title: str | None = None,
    labels: Sequence[str] | None = None,
    equal: bool | None = None,
    panels: bool | None = None,
    events: bool = True,
) -> Axes:
    """Draw outputs of a motion and return the axes, which notebooks show; no window opens.

    Lines go through the motion between its samples, and no peak is cut off; what jumps at an event or a
    step of an input is vertical there. Outputs known at the samples alone are drawn as they are.

    Parameters
    ----------
    run : Trajectory or Sweep
        Of a sweep all cases are drawn over time, each output in a panel of its own.
    *expressions : str or tuple of str
        Any name or formula of ``run[...]``, such as ``"0.5*m*x_dot^2"`` and
        ``"sqrt('reaction A Fx'^2 + 'reaction A Fy'^2)"``; all coordinates if none is given.
        A vector makes three curves. A tuple makes a path of its two or three components: ``("X", "Y")``, or
        ``("frame r P",)`` for the path of a frame, in its plane x, y or z = constant if there is one.
    ax : Axes, optional
        Where to draw, for instance from ``matplotlib.pyplot.subplots()`` to see a window. By default a new
        figure that belongs to no window: ``ax.figure``, or `save_plot`. What is given takes all curves,
        regardless of their units; panels of an earlier plot take those of their own units.
    x : str
        The output along the horizontal axis; with another than time the start is marked by a dot.
    title : str, optional
        Above the axes; by default the name of the model.
    labels : sequence of str, optional
        One for each curve or path, in place of the names; a unit in brackets at the end is understood.
    equal : bool, optional
        Whether a unit is equally long on all axes; by default it is for paths of lengths.
    panels : bool, optional
        Whether each unit has a panel of its own, in the order in which they come, below each other over one
        horizontal axis; outputs of unknown unit share one too. The uppermost axes are returned,
        ``ax.figure.axes`` are all. By default they have, except in given axes; False draws all curves over
        each other, regardless of their units.
    events : bool
        Whether the events of the motion are marked by thin lines with their names, over time.

    Returns
    -------
    Axes
        Of Matplotlib, to change or to save; of several panels the uppermost ones.

    Raises
    ------
    UsageError
        An unknown name, an output with several components where one is needed, or too few labels.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> ax = sb.plot(sb.simulate(eqs, 1.0), "x", "x_dot")
    >>> len(ax.figure.axes)
    2
    """
    if isinstance(run, Sweep):
        return plot_sweep(run, expressions, ax, title)
    _check_motion(run)
    chosen = expressions or _coordinates(run)
    curves = [item for item in chosen if isinstance(item, str)]
    if len(curves) == len(chosen):
        across, drawn = _pair_with_abscissa(run, curves, x)
        axes = _curves(across, rename_curves(drawn, labels), ax, x, title, bool(equal), panels is not False)
        if events and x == "t":
            mark_events(axes, panels_beside(axes).values(), run)
        return axes
    _check_paths_alone(curves, x)
    return _paths(rename_curves(_make_paths(run, chosen), labels), ax, title, equal)


def _check_motion(run: object) -> None:
    if not isinstance(run, Trajectory):
        fix = "give what simulate, inverse_dynamics or sweep returns"
        if isinstance(run, Linearization):
            fix += "; for a Bode diagram: control.bode_plot(run.to_control()), of python-control"
        raise UsageError(Problem("plot.not_a_motion", "run", f"{run!r} is not a motion", fix=fix))


def _coordinates(run: Trajectory) -> tuple[str, ...]:
    """Return the coordinates, which are drawn where nothing is named.

    Raises
    ------
    UsageError
        If there are none, as where all motion is prescribed.
    """
    if not run.coordinate_names:
        raise UsageError(
            Problem("plot.nothing", "run", "the motion has no coordinates", "all of it is prescribed",
                    'name what to draw: plot(run, "energy")')
        )  # fmt: skip
    return run.coordinate_names


def _check_paths_alone(curves: Sequence[str], x: str) -> None:
    if curves or x != "t":
        what, fix = "curves over an output and paths do not share axes", "draw them with two calls of plot"
        raise UsageError(Problem("plot.mixed", repr(curves[0] if curves else x), what, fix=fix))


def _make_paths(run: Trajectory, chosen: Sequence[str | tuple[str, ...]]) -> list[PlanePath]:
    words = [(item,) if isinstance(item, str) else item for item in chosen]
    return [path_of(motion, item) for motion, item in zip(_motions(run, words), words, strict=True)]


def _motions(run: Trajectory, groups: Sequence[Sequence[str]]) -> list[Trajectory]:
    """Return for each group of outputs the motion to draw it from: a smooth one, or the samples."""
    known = {name: is_continuous(run, name) for group in groups for name in group}
    smooth = smooth_motion(run, [name for name in known if known[name]]) if any(known.values()) else run
    return [smooth if all(known[name] for name in group) else run for group in groups]


def _pair_with_abscissa(
    run: Trajectory, names: Sequence[str], x: str
) -> tuple[list[PlottedCurve], list[PlottedCurve]]:
    """Return for each curve what runs along the horizontal axis, and the curve."""
    across, curves = list[PlottedCurve](), list[PlottedCurve]()
    for motion, name in zip(_motions(run, [(x, name) for name in names]), names, strict=True):
        several = curves_of(motion, name)
        across += [single_curve(motion, x)] * len(several)
        curves += several
    return across, curves


def _curves(
    across: Sequence[PlottedCurve],
    curves: Sequence[PlottedCurve],
    ax: Axes | None,
    x: str,
    title: str | None,
    equal: bool,
    apart: bool,
) -> Axes:
    units = list(dict.fromkeys(curve.shown_unit for curve in curves))
    panels = new_panels(units if apart else [""]) if ax is None else panels_beside(ax)
    first = next(iter(panels.values())) if ax is None else ax
    for place, curve in zip(across, curves, strict=True):
        axes = panels.get(curve.shown_unit, first)
        draw(axes, (place, curve), curve.text, marks_start=x != "t")
    every = list(panels.values()) or [first]
    if len(every) > 1:
        label_panels(every, across[0], title)
    else:
        label_curves(first, across[0], title)
    for axes in every:
        if equal:
            axes.set_aspect("equal", adjustable="datalim")
        elif x == "t":
            axes.margins(x=0.0)
    return first


def _paths(paths: Sequence[PlanePath], ax: Axes | None, title: str | None, equal: bool | None) -> Axes:
    if ax is None or not is_in_space(ax):
        paths = in_their_plane(paths)
    sizes = {len(path.curves) for path in paths}
    axes = new_axes(sizes == {3}) if ax is None else ax
    if sizes != {3 if is_in_space(axes) else 2}:
        what = "paths have two components in the plane and three in space"
        fix = "draw the two kinds with two calls; axes for paths in space have projection='3d'"
        raise UsageError(Problem("plot.path_axes", paths[0].name, what, fix=fix))
    for path in paths:
        draw(axes, path.curves, path.label, marks_start=True)
    label_paths(axes, paths, title)
    units = {curve.unit for path in paths for curve in path.curves}
    if equal or (equal is None and units == {"m"}):
        axes.set_aspect("equal", adjustable="datalim")
    return axes


@checked_arguments
def save_plot(ax: Axes, path: str | PathLike[str]) -> None:
    """Write the figure that holds `ax` to a file; the suffix chooses png, svg, pdf or another format.

    Parameters
    ----------
    ax : Axes
        What `plot` returned.
    path : str or path
        The file.

    Raises
    ------
    UsageError
        A suffix that is not a picture format.
    EnvironmentFault
        If the file cannot be written.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> import tempfile
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "x.svg")
    ...     sb.save_plot(sb.plot(sb.simulate(eqs, 1.0), "x"), path)
    ...     path.read_text(encoding="utf-8").count("<svg")
    1
    """
    canvas = ax.figure.canvas
    suffix = pathlib.Path(path).suffix.lstrip(".").lower()
    known = canvas.get_supported_filetypes()
    if suffix not in known:
        what = f"{suffix!r} is not a picture format" if suffix else "the name has no suffix"
        fix = f"end the name with one of {', '.join(sorted(known))}"
        raise UsageError(Problem("plot.format", str(path), what, fix=fix))
    try:
        metadata = {"Software": f"symbody {symbody.__version__}"} if suffix == "png" else None
        canvas.figure.savefig(path, format=suffix, metadata=metadata)
    except OSError as error:
        what = f"the picture cannot be written: {error.strerror}"
        fix = "choose an existing folder with write permission"
        raise EnvironmentFault(Problem("plot.unwritable", str(path), what, fix=fix)) from error
