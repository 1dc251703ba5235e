"""`animate`: motions as pages for any browser, in notebooks as pictures that move."""

from __future__ import annotations

import html
import sys
import tempfile
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from os import PathLike
from pathlib import Path
from typing import Any, Final, Literal, TypedDict, Unpack, get_args, overload

import numpy as np
from numpy.typing import ArrayLike

from symbody.analysis.state import State
from symbody.arguments import checked_arguments
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import EnvironmentFault, Problem, UsageError, nearest
from symbody.model.model import Model
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.inputs.input_laws import Law
from symbody.simulation.methods.integration import Constraints, Integrator
from symbody.simulation.programs.motion_request import MotionRequest
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.scene import coordinate_courses, make_motion, make_scene
from symbody.visual.scene.scene import Scene, SceneMotion
from symbody.visual.scene.view import seen_along
from symbody.visual.viewer.live import Slider, SliderMechanism, slider_mechanism
from symbody.visual.viewer.live_page import LivePage, make_live_page, slider_bounds
from symbody.visual.viewer.page import PageData, page_data, page_text, write_page
from symbody.visual.viewer.still import run_of_state

Theme = Literal["auto", "light", "dark", "contrast"]
View = Literal["auto", "front", "top", "right", "isometric"]

_HEIGHT: Final = 520  # pixels in a notebook


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Animation:
    """A motion to show; notebooks display it.

    Attributes
    ----------
    scene : Scene
        The shapes.
    motion : SceneMotion
        Where they are.
    title : str
        Above the picture.
    options : mapping
        Settings of the page.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> run = sb.simulate(sb.form_equations(sb.Model("cart", [rail])), 1.0)
    >>> sb.animate(run, "cart.html").title  # doctest: +SKIP
    'cart'
    """

    scene: Scene
    motion: SceneMotion
    title: str
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def data(self) -> PageData:
        """The data of a page, as values that JSON can represent."""
        return page_data(self.scene, self.motion, self.title, self.options)

    @property
    def html(self) -> str:
        """The page, which needs nothing else.

        Raises
        ------
        EnvironmentFault
            If this installation has no pages.
        """
        return page_text(self.data)

    @checked_arguments
    def save(self, path: str | PathLike[str]) -> None:
        """Write the page to a file.

        Raises
        ------
        EnvironmentFault
            If it cannot be written; the file that was there is unchanged.
        """
        write_page(Path(path), self.html)

    def show(self) -> Path:
        """Open the page in the browser and return the file it is in, which stays until the system clears it.

        Where no browser opens, as on a computer without a display, the path is printed.

        Raises
        ------
        EnvironmentFault
            If there is no page.
        """
        text = self.html
        with tempfile.NamedTemporaryFile("w", prefix="symbody-", suffix=".html", delete=False) as file:
            path = Path(file.name)
        write_page(path, text)
        if not webbrowser.open(path.as_uri()):
            print(f"no browser opened; the page is {path}")
        return path

    def __repr__(self) -> str:
        times = self.motion.times
        return f"<Animation {self.title!r}: t = {times[0]:g} to {times[-1]:g} s, {times.size} samples>"

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own, which exported notebooks keep."""
        source, name = _attribute(self.html), _attribute(self.title)
        return (
            f'<iframe srcdoc="{source}" title="{name}" sandbox="allow-scripts" width="100%" '
            f'height="{_HEIGHT}" style="border:0" allowfullscreen></iframe>'
        )


def _attribute(text: str) -> str:
    """Return a text as the value of an attribute, whatever the encoding of the page round it."""
    return html.escape(text, quote=True).encode("ascii", "xmlcharrefreplace").decode("ascii")


class _Picture(TypedDict, total=False):
    """What `animate` takes for every picture."""

    curves: Sequence[str] | None
    vectors: str | Sequence[str] | None
    traces: Sequence[str]
    times: ArrayLike | None
    title: str | None
    model: Model | None
    view: View
    theme: Theme
    speed: float


class _LivePicture(_Picture, total=False):
    """What `animate` takes for pictures of equations."""

    live: bool
    sliders: Sequence[Slider] | Mapping[str, tuple[float, float] | None]
    initial: Mapping[str, Value] | None
    parameters: Mapping[str, Value] | None
    inputs: Mapping[str, Law] | None
    integrator: Integrator | None
    constraints: Constraints | None
    events: Event | Sequence[Event]
    rtol: float


@overload
def animate(run: EquationSet, path: None = None, **options: Unpack[_LivePicture]) -> LiveAnimation: ...
@overload
def animate(run: EquationSet, path: str | PathLike[str], **options: Unpack[_LivePicture]) -> LivePage: ...
@overload
def animate(
    run: Trajectory | State, path: str | PathLike[str] | None = None, *, live: Literal[True],
    **options: Unpack[_Picture],
) -> LiveAnimation: ...  # fmt: skip
@overload
def animate(
    run: Trajectory | State, path: str | PathLike[str] | None = None, *, live: Literal[False] = False,
    **options: Unpack[_Picture],
) -> Animation: ...  # fmt: skip
@checked_arguments
def animate(
    run: Trajectory | State | EquationSet, path: str | PathLike[str] | None = None, *,
    curves: Sequence[str] | None = None, vectors: str | Sequence[str] | None = None,
    traces: Sequence[str] = (), times: ArrayLike | None = None, title: str | None = None,
    model: Model | None = None, view: View = "auto", theme: Theme = "auto", speed: float = 1.0,
    live: bool = False, sliders: Sequence[Slider] | Mapping[str, tuple[float, float] | None] = (),
    initial: Mapping[str, Value] | None = None, parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Law] | None = None, integrator: Integrator | None = None,
    constraints: Constraints | None = None, events: Event | Sequence[Event] = (), rtol: float = 1e-8,
) -> Animation | LiveAnimation | LivePage:  # fmt: skip
    """Show a motion: as a page that any browser opens, without a network, or in a notebook.

    With a path the page is written there. Without one, a notebook shows what is returned; elsewhere the page
    opens in the browser.

    Parameters
    ----------
    run : Trajectory, State or EquationSet
        With its model. A state makes a still picture; equations a live one, with a path a page that
        simulates.
    path : path, optional
        Of the page, ``"motion.html"``. It holds everything it needs.
    curves : sequence of str, optional
        Outputs drawn over time below the picture; by default the coordinates, at most twelve.
    vectors : "all", "applied", "none" or sequence of str, optional
        Forces and torques that are drawn: "applied" those of `Force` and `Torque`, by default if they are
        few; "all" also reactions of joints and forces of springs; or those of elements by their names.
    traces : sequence of str
        Points whose paths are drawn: ``"Body.frame"``, or a body for its centre of mass.
    times : (start, end) or (N,) array, optional
        The part of the motion that is shown, or all samples [s]. By default there are as many samples as the
        eye needs: what is interpolated between them is within a thousandth of the mechanism's size.
    title, model : str, Model, optional
        By default the model's name; the mechanism that moves, for motions from files of older versions.
    view : "front", "top", "right", "isometric" or "auto"
        By default planar mechanisms are seen against the normal of their plane, others isometrically.
    theme, speed : "light", "dark", "contrast" or "auto", float
        Colours; seconds of the motion in a second.
    live, sliders : bool, sequence of str or (name, lowest, highest), or mapping of name to (lowest, highest)
        In a notebook: share time with Python; coordinates and parameters of equations to move by sliders. On
        a page of equations: parameters, inputs, first values of coordinates and speeds.
    initial, parameters, inputs, integrator, constraints, events, rtol : optional
        Of a page of equations, as `simulate` takes them, without Python functions and implicit methods.

    Returns
    -------
    Animation, LiveAnimation or LivePage
        The picture of a motion, which ``save`` writes and notebooks show; with `live`, and of equations, one
        that Python moves; of equations with a path, the page that simulates.

    Raises
    ------
    UsageError
        If a name is unknown, the run has no model or no samples, or times lie outside of it.
    EnvironmentFault
        If the page cannot be written, or this installation has no pages.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> run = sb.simulate(eqs, 1.0)
    >>> sb.animate(run, "oscillator.html", curves=["x", "energy"])  # doctest: +SKIP
    <Animation 'oscillator': t = 0 to 1 s, 67 samples>
    """
    target = None if path is None else _page_path(path)
    options = {"view": view, "theme": theme, "speed": speed}
    if isinstance(run, EquationSet):
        motion = (initial or {}, parameters or {}, inputs or {}, (), (), integrator, constraints, rtol)
        request = MotionRequest(*motion, events=check_events(events, run))
        return live_mechanism(run, sliders, title, target, options, request, vectors)
    animation = make_animation(run, curves, vectors, traces, times, title, model, options)
    return LiveAnimation(new_widget(animation.data)) if live else _present(animation, target)


def _present(animation: Animation, target: Path | None) -> Animation:
    """Return an animation, written to a page or shown in the browser; a notebook shows it by itself."""
    if target is not None:
        animation.save(target)
    elif not in_notebook():
        animation.show()
    return animation


def live_mechanism(
    eqs: EquationSet,
    sliders: Sequence[Slider] | Mapping[str, tuple[float, float] | None],
    title: str | None,
    path: Path | None,
    options: Mapping[str, Any],
    request: MotionRequest,
    vectors: str | Sequence[str] | None = None,
) -> LiveAnimation | LivePage:
    """Return a mechanism with sliders, and write its page if a path is given; see `animate`."""
    if path is not None:
        _check_options(options)
        page = make_live_page(eqs, slider_bounds(sliders), request, title, options, vectors)
        write_page(path, page.html)
        return page
    if request != MotionRequest() or vectors is not None:
        raise UsageError(
            Problem("animation.live_widget", "animate", "sliders in a notebook change positions, without "
                "simulating",
                    "initial, parameters, inputs, events, vectors, integrator and constraints are for pages "
                "that simulate",
                    "give a path: animate(eqs, 'live.html', ...)")
        )  # fmt: skip
    if isinstance(sliders, Mapping):
        sliders = [name if bounds is None else (name, *bounds) for name, bounds in sliders.items()]
    _check_options(options)
    mechanism = slider_mechanism(eqs, sliders)
    data = mechanism.data(mechanism.first, title or eqs.model.name, options)
    return LiveAnimation(new_widget(data, mechanism))


def new_widget(data: PageData, mechanism: SliderMechanism | None = None) -> Any:
    """Return the notebook widget.

    Raises
    ------
    EnvironmentFault
        If anywidget is not installed, or this installation has no pages.
    """
    try:
        module = import_module("symbody.visual.viewer.notebook_widget")
    except ImportError:
        raise EnvironmentFault(
            Problem("animation.no_anywidget", "live", "live pictures need anywidget, which is not installed",
                    fix="pip install symbody[notebook], or remove live=True")
        ) from None  # fmt: skip
    return module.MechanismWidget(data, mechanism)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LiveAnimation:
    """A picture in a notebook that shares its time and its sliders with Python.

    Attributes
    ----------
    widget : widget of anywidget
        With traits ``time`` [s], ``playing``, ``slider_values``, ``message``; `observe` follows them.
    """

    widget: Any

    @property
    def time(self) -> float:
        """The time that is shown [s]."""
        return float(self.widget.time)

    def seek(self, time: float) -> None:
        """Show another time [s]."""
        self.widget.time = float(time)

    @property
    def state(self) -> State | None:
        """Where the sliders have moved the mechanism; None without sliders."""
        state: State | None = self.widget.state
        return state

    def observe(self, call: Any, names: str = "time") -> None:
        """Call a function with each change of a trait; see traitlets."""
        self.widget.observe(call, names)

    def __repr__(self) -> str:
        return f"<LiveAnimation {self.widget.data['title']!r}>"

    def _repr_mimebundle_(self, **words: Any) -> Any:
        return self.widget._repr_mimebundle_(**words)


def make_animation(
    run: Trajectory | State,
    curves: Sequence[str] | None,
    vectors: str | Sequence[str] | None,
    traces: Sequence[str],
    times: ArrayLike | None,
    title: str | None,
    model: Model | None,
    options: Mapping[str, Any],
) -> Animation:
    """Return a motion as it is shown; see `animate`."""
    motion_run = _run_of(run, model)
    if motion_run.model is None:
        raise _no_model()
    _check_options(options)
    scene = make_scene(motion_run.model, motion_run.parameters, coordinate_courses(motion_run))
    pair = _span(times)
    motion = make_motion(motion_run, scene, None if pair else times, curves, vectors, pair)
    scene = seen_along(scene, motion)
    settings = {
        **options,
        "speed": float(options["speed"]),
        "traces": [_point(scene, name) for name in traces],
    }
    return Animation(scene, motion, title or scene.name, settings)


def _check_options(options: Mapping[str, Any]) -> None:
    for name, words in (("view", get_args(View)), ("theme", get_args(Theme))):
        word = options.get(name, "auto")
        if word not in words:
            fix = f"choose one of {', '.join(words)}"
            raise UsageError(Problem("animation.option", name, f"{word!r} is not a {name}", fix=fix))
    speed = options.get("speed", 1.0)
    if not (np.isfinite(speed) and speed > 0.0):
        raise UsageError(
            Problem("animation.option", "speed", f"{speed} is not a valid speed", fix="give one > 0")
        )


def in_notebook() -> bool:
    """Return whether what is returned to the user is shown by a notebook."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return getattr(shell, "kernel", None) is not None


def _run_of(run: Trajectory | State, model: Model | None) -> Trajectory:
    if isinstance(run, State):
        return run_of_state(run)
    if not isinstance(run, Trajectory):
        fix = "give what simulate returns; of a sweep, one case: sweep.trajectory(3)"
        raise UsageError(Problem("animation.not_a_motion", "run", f"{run!r} is not a motion", fix=fix))
    if model is None or model == run.model:
        return run
    return run.of_model(model)


def _no_model() -> UsageError:
    return UsageError(
        Problem("animation.no_model", "run", "the motion does not contain its mechanism",
                "its file was written by an older version, or its equations were assembled by hand",
                "animate(run, model=...) with the model it was computed from")
    )  # fmt: skip


def _page_path(path: str | PathLike[str]) -> Path:
    target = Path(path)
    if target.suffix.lower() not in (".html", ".htm"):
        raise UsageError(
            Problem("animation.suffix", str(path), f"a page cannot be a {target.suffix or 'such'} file",
                    fix="end the name with .html; for films and pictures use save_animation")
        )  # fmt: skip
    return target


def _span(times: ArrayLike | None) -> tuple[float, float] | None:
    """Return the two ends of a part of the motion, if it is these that are given."""
    if times is None or np.shape(times) != (2,):
        return None
    try:
        first, last = (float(t) for t in np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        return None
    return first, last


def _point(scene: Scene, name: str) -> str:
    """Return a point as the page names it."""
    known = [f"{body.name}.{frame.name}" for body in scene.bodies[1:] for frame in body.frames]
    centres = {body.name: f"{body.name}.CoM" for body in scene.bodies[1:]}
    if name in known:
        return name
    if name in centres:
        return centres[name]
    raise UsageError(
        Problem("animation.unknown_point", repr(name), f"there is no point {name!r} on a body", "",
                nearest(name, [*centres, *known]))
    )  # fmt: skip
