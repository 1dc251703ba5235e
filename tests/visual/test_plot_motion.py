"""Plots of computed motions: peaks between steps, jumps, events, expressions and their units."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.text import Annotation
from numpy.typing import NDArray

from symbody import (
    Body,
    Drive,
    Event,
    Model,
    Prismatic,
    Revolute,
    Table,
    Trajectory,
    form_equations,
    load_model,
    simulate,
)
from symbody.errors import FormulationError
from symbody.visual.plotting.axis_labels import readable, shown_unit, typed_unit
from symbody.visual.plotting.event_marks import EventLines
from symbody.visual.plotting.plot import plot

Floats = NDArray[np.float64]

GRAVITY = 9.81


def data(ax: Axes, line: int = 0) -> Floats:
    return np.asarray(ax.lines[line].get_data(), dtype=np.float64)


def names_above(ax: Axes) -> list[Annotation]:
    return [text for text in ax.texts if isinstance(text, Annotation)]


@pytest.fixture(scope="module")
def oscillator() -> Trajectory:
    """x = cos(w t) with w = 1.7 rad/s, in long steps of order 8."""
    mass = Body("Mass", mass="m")
    slider = Prismatic(
        "slider", "ground", mass, axis="x", coordinate="x", force=Drive(stiffness="k", applied="F")
    )
    model = Model(
        "oscillator",
        [slider],
        inputs=["F"],
        parameters={"m": 2.0, "k": 2.0 * 1.7**2, "l": 4.0},
        initial={"x": 1.0},
    )
    return simulate(form_equations(model), 30.0, inputs={"F": 0.0}, rtol=1e-5)


@pytest.fixture(scope="module")
def ball() -> Trajectory:
    """A ball dropped from 1 m that loses a fifth of its speed at each bounce; few samples are stored."""
    lift = Prismatic("lift", "ground", Body("Ball", mass=1), axis="y", coordinate="h")
    model = Model("ball", [lift], gravity=(0, -GRAVITY, 0), initial={"h": 1.0})
    bounce = Event("h", direction=-1, action={"h_dot": "-0.8*h_dot"}, name="bounce")
    return simulate(form_equations(model), 1.5, times=np.linspace(0.0, 1.5, 4), events=bounce)


def test_peaks_between_steps_are_drawn(oscillator: Trajectory) -> None:
    t, x = data(plot(oscillator, "x"))
    assert np.abs(oscillator["x"][oscillator.t > 5.0]).max() < 1.0 - 1e-3  # the samples miss the amplitude
    quarter = np.pi / 1.7
    for k in range(1, int(30.0 / quarter)):
        near = np.abs(t - k * quarter) < 0.5 * quarter
        # amplitude within 1e-3 of the range, which is 2; the tolerance of the run is far below
        assert np.abs(x[near]).max() == pytest.approx(1.0, abs=1e-3)
    # and straight lines between the points stay near the curve
    middle = (t[1:] + t[:-1]) / 2.0
    np.testing.assert_allclose((x[1:] + x[:-1]) / 2.0, np.cos(1.7 * middle), rtol=0.0, atol=2e-3)


def test_peaks_of_outputs_that_are_much_faster_than_the_motion(oscillator: Trajectory) -> None:
    t, y = data(plot(oscillator, "sin(40*x)"))
    middle = (t[1:] + t[:-1]) / 2.0
    exact = np.sin(40.0 * np.cos(1.7 * middle))
    assert np.abs((y[1:] + y[:-1]) / 2.0 - exact).max() < 4e-3 + 40.0 * 1e-4  # the line, and the run itself


def test_few_stored_samples_do_not_matter(ball: Trajectory) -> None:
    t, h = data(plot(ball, "h"))
    assert ball.t.size == 4
    fall = np.sqrt(2.0 / GRAVITY)
    rise = 0.8 * GRAVITY * fall / GRAVITY
    assert h[(t > fall) & (t < fall + 2.0 * rise)].max() == pytest.approx(0.64, abs=1e-3)
    assert h.min() > -1e-6  # the ground is never crossed by a line


def test_a_jump_stays_a_jump(ball: Trajectory) -> None:
    t, v = data(plot(ball, "h_dot"))
    fall = np.sqrt(2.0 / GRAVITY)
    place = int(np.argmax(np.abs(np.diff(v))))
    assert t[place : place + 2] == pytest.approx([fall, fall], abs=1e-7)
    assert t[place + 1] - t[place] < 1e-12
    assert v[place : place + 2] == pytest.approx([-GRAVITY * fall, 0.8 * GRAVITY * fall], abs=1e-6)
    others = np.delete(np.abs(np.diff(v)), place)
    assert np.sort(others)[-3] < 0.5  # the later bounces apart, nothing jumps


def test_reactions_jump_where_an_input_does() -> None:
    arm = Body("Arm", mass=1, inertia=(0, 0, 1))
    pin = Revolute("pin", "ground", arm, axis="z", coordinate="theta", torque=Drive(applied="T"))
    eqs = form_equations(Model("arm", [pin], inputs=["T"]))
    step = Table([0.0, 1.0, 1.0, 2.0], [0.0, 0.0, 3.0, 3.0])
    run = simulate(eqs, 2.0, inputs={"T": step})
    t, torque = data(plot(run, "2*theta_ddot"))
    place = int(np.argmax(np.abs(np.diff(torque))))
    assert t[place : place + 2] == pytest.approx([1.0, 1.0], abs=1e-12)
    assert set(np.round(torque, 9)) == {0.0, 6.0}


def test_a_motion_without_dense_output_is_drawn_as_it_is(oscillator: Trajectory) -> None:
    bare = Trajectory(
        oscillator.t, oscillator.q, oscillator.u, oscillator.coordinate_names, oscillator.speed_names,
        oscillator.status, oscillator.statistics,
    )  # fmt: skip
    np.testing.assert_array_equal(data(plot(bare, "x")), [bare.t, bare["x"]])


def test_events_are_marked_once_with_names_that_keep_apart(ball: Trajectory) -> None:
    ax = plot(ball, "h", "h_dot", panels=True)
    times = [event.t for event in ball.events]
    for panel in ax.figure.axes:
        (lines,) = (each for each in panel.collections if isinstance(each, EventLines))
        assert [segment[0][0] for segment in lines.get_segments()] == pytest.approx(times)
    assert not names_above(ax.figure.axes[1])
    ax.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in names_above(ax)]
    assert boxes and all(text.get_text() == "bounce" for text in names_above(ax))
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    plot(ball, "h", ax=ax)  # the same events are not drawn twice
    assert len([each for each in ax.collections if isinstance(each, EventLines)]) == 1
    assert len(names_above(ax)) == len(boxes)


def test_many_events_keep_their_names_apart(ball: Trajectory) -> None:
    bounces = ball.events * 1
    crowd = [bounces[0]._replace(name=f"contact {k}", t=0.02 * k) for k in range(60)]
    busy = Trajectory(
        ball.t, ball.q, ball.u, ball.coordinate_names, ball.speed_names, ball.status, ball.statistics,
        dense_output=ball.dense_output, events=tuple(crowd),
    )  # fmt: skip
    ax = plot(busy, "h", title="Crowded")
    ax.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in [*names_above(ax), ax.title]]
    assert 5 < len(boxes) < 60
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])


def test_events_can_be_left_out_and_are_not_marked_over_other_outputs(ball: Trajectory) -> None:
    for ax in (plot(ball, "h", events=False), plot(ball, "h_dot", x="h")):
        assert not ax.collections and not names_above(ax)


def test_twin_axes_share_a_legend_and_differ_in_their_colours(ball: Trajectory) -> None:
    figure, left = pyplot.subplots()
    right = left.twinx()
    plot(ball, "h", ax=left)
    plot(ball, "h_dot", ax=right)
    assert left.get_legend() is None
    shown = right.get_legend()
    assert shown is not None
    assert [text.get_text() for text in shown.get_texts()] == ["$h$ [m]", r"$\dot{h}$ [m/s]"]
    assert left.lines[0].get_color() != right.lines[0].get_color()
    assert (left.get_ylabel(), right.get_ylabel()) == ("$h$ [m]", r"$\dot{h}$ [m/s]")
    pyplot.close(figure)


def test_axes_of_the_caller_in_space(oscillator: Trajectory) -> None:
    figure = pyplot.figure()
    ax = figure.add_subplot(projection="3d")
    assert plot(oscillator, ("frame r Mass",), ax=ax) is ax
    assert len(ax.lines) == 2
    pyplot.close(figure)


@pytest.mark.parametrize(
    ("expression", "label"),
    [
        ("0.5*m*x_dot^2", r"$m \, \dot{x}^{2}/2$ [J]"),
        ("x/l", "$x/l$"),
        ("k*x", r"$k \, x$ [N]"),
        ("x_ddot", r"$\ddot{x}$ [m/s²]"),
        ("'reaction slider Fy'/m", r"$F_{\mathrm{slider},y}/m$ [m/s²]"),
        ("kinetic_energy", "kinetic energy [J]"),
        ("9.81*x", r"$9.81 \, x$"),  # who knows what the number is
    ],
)
def test_expressions_are_set_as_formulas_with_their_unit(
    oscillator: Trajectory, expression: str, label: str
) -> None:
    assert plot(oscillator, expression).get_ylabel() == label


def test_the_force_in_a_joint_from_quoted_outputs(oscillator: Trajectory) -> None:
    ax = plot(oscillator, "sqrt('reaction slider Fx'^2 + 'reaction slider Fy'^2)")
    assert ax.get_ylabel() == r"$\sqrt{F_{\mathrm{slider},x}^{2} + F_{\mathrm{slider},y}^{2}}$ [N]"
    parts = oscillator["reaction slider Fx"], oscillator["reaction slider Fy"]
    values = oscillator["sqrt('reaction slider Fx'^2 + 'reaction slider Fy'^2)"]
    np.testing.assert_allclose(values, np.hypot(*parts), rtol=1e-12, atol=1e-12)


def test_quoted_outputs_that_do_not_exist_or_are_no_numbers(oscillator: Trajectory) -> None:
    with pytest.raises(FormulationError, match="no joint or constraint 'slide'"):
        oscillator["2*'reaction slide Fx'"]
    with pytest.raises(FormulationError, match=r"its shape is \(6,\)\n.*\n.*\n.*name one component"):
        oscillator["2*'reaction slider'"]


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("theta_1", r"$\theta_{1}$"),
        ("theta_1_ddot", r"$\ddot{\theta}_{1}$"),
        ("reaction my joint Mz", "reaction my joint $M_{z}$"),
        ("rope_tension R1", "rope tension R1"),
        ("udot[3]", "udot[3]"),
        ("if(x > 0, x, 0)", "if(x > 0, x, 0)"),  # more than mathtext has
        ("price $", r"price \$"),
    ],
)
def test_names_as_people_read_them(name: str, label: str) -> None:
    assert readable(name) == label


def test_units_are_shown_raised_and_read_back() -> None:
    assert shown_unit("rad^2/s^2") == "rad²/s²"
    assert typed_unit("rad²/s²") == "rad^2/s^2"
    assert shown_unit("m^(1/2)") == "m^(1/2)" == typed_unit("m^(1/2)")


def test_axes_show_their_picture_in_notebooks(oscillator: Trajectory) -> None:
    for ax in (
        plot(oscillator, "x"),
        plot(oscillator, "x", "x_dot", panels=True),
        plot(oscillator, ("frame r Mass",)),
    ):
        show = getattr(ax, "_repr_png_", None)
        assert show is not None
        assert show().startswith(b"\x89PNG")


def test_a_matrix_that_bears_the_name_of_a_measured_angle() -> None:
    """Joint B of the slider-crank is cut, and its angle is called B, as the derivatives by inputs are."""
    folder = Path(__file__).parents[2] / "examples" / "slider_crank"
    run = simulate(form_equations(load_model(folder / "slider_crank.toml")), 0.2)
    assert run["B"].shape == (6, 1, run.t.size)
    assert run["(B)"].shape == run.t.shape
    assert len(plot(run, "B").lines) == 6


def test_what_was_loaded_is_drawn_as_far_as_it_is_known(oscillator: Trajectory, tmp_path: Path) -> None:
    oscillator.save(tmp_path / "run.npz", "energy")
    loaded = replace(Trajectory.load(tmp_path / "run.npz"), evaluate=None)  # as of a file without its model
    ax = plot(loaded, "x", "energy", panels=True)
    smooth, samples = ax.figure.axes
    np.testing.assert_array_equal(data(smooth), data(plot(oscillator, "x")))
    np.testing.assert_array_equal(data(samples), [oscillator.t, oscillator["energy"]])


def test_motions_that_run_backwards() -> None:
    eqs = form_equations(Model("free", [Prismatic("slider", "ground", Body("Mass", mass=1), coordinate="x")]))
    back = simulate(eqs, (2.0, 0.0), {"x": 1.0, "x_dot": -1.0})
    t, x = data(plot(back, "x"))
    assert (t[0], t[-1]) == (2.0, 0.0) and (np.diff(t) <= 0.0).all()
    np.testing.assert_allclose(x, 3.0 - t, rtol=0.0, atol=1e-8)
