"""What a plot draws and says, without a screen."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread
from numpy.typing import NDArray

import symbody as sb
from symbody.errors import EnvironmentFault, UsageError
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.plotting.line_sampling import SMOOTH
from symbody.visual.plotting.plot import plot, save_plot
from tests.simulation.right_hand_sides import oscillator, run
from tests.tiers import cases

Floats = NDArray[np.float64]
XYZ = [f"P $r_{{{letter}}}$ [m]" for letter in "xyz"]  # how the components of "frame r P" are shown


def outputs(name: str, t: Floats, q: Floats, u: Floats) -> Floats:
    known = {"v_dot": -q[0], "frame r P": np.array([q[0], u[0], 0.1 * t]), "pair": np.array([t, -t])}
    known |= {"frame r P x": q[0], "frame r P y": u[0], "frame r Q x": t}
    if name not in known:
        raise UsageError()
    return known[name]


def swing(**changes: Any) -> Trajectory:
    raw = run(oscillator, 1, 1, [0.0, 1.0], (0.0, 6.0))
    parts: dict[str, Any] = {
        "coordinate_names": ("x",),
        "speed_names": ("v",),
        "status": raw.status,
        "statistics": raw.statistics,
        "evaluate": outputs,
        "dense_output": raw.dense_output,
        "units": {"x": "m", "v": "m/s"},
    }
    return Trajectory(raw.t, raw.x[1:], raw.x[:1], **{**parts, **changes})


def data(ax: Axes, line: int = 0) -> Floats:
    return np.asarray(ax.lines[line].get_data(), dtype=np.float64)


def legend(ax: Axes) -> list[str]:
    found = ax.get_legend()
    return [] if found is None else [text.get_text() for text in found.get_texts()]


def test_one_curve_names_its_axis_and_needs_no_legend() -> None:
    ax = plot(swing(), "x", title="A swing")
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("time [s]", "$x$ [m]", "A swing")
    assert legend(ax) == []
    t, x = data(ax)
    assert (t[0], t[-1]) == (0.0, 6.0)
    assert ax.get_xlim() == (0.0, 6.0)
    # closed form; local errors of 1e-8 over some tens of steps
    np.testing.assert_allclose(x, np.cos(t), rtol=0.0, atol=30.0 * 1e-8)


def test_curves_are_smooth_however_long_the_steps() -> None:
    motion = swing()
    assert motion.t.size < 50
    assert data(plot(motion, "x")).shape[1] >= SMOOTH
    assert set(motion.t) <= set(data(plot(motion, "x"))[0])
    bare = swing(dense_output=None)
    np.testing.assert_array_equal(data(plot(bare, "x")), [bare.t, bare["x"]])


def test_stored_arrays_are_drawn_at_the_samples() -> None:
    motion = swing()
    kept = swing(stored={"F": 3.0 * motion.t})
    np.testing.assert_array_equal(data(plot(kept, "F")), [kept.t, 3.0 * kept.t])
    state, stored = plot(kept, "x", "F", panels=True).figure.axes
    np.testing.assert_array_equal(data(stored), [kept.t, 3.0 * kept.t])
    assert (
        data(state).shape[1] >= SMOOTH
    )  # what is known in between is drawn there, whatever stands beside it
    np.testing.assert_array_equal(data(plot(kept, "F", x="x")), [kept["x"], 3.0 * kept.t])


def test_no_expression_means_all_coordinates() -> None:
    assert plot(swing()).get_ylabel() == "$x$ [m]"


def test_several_curves_have_a_legend_and_different_colours() -> None:
    ax = plot(swing(), "x", "frame r P")
    assert legend(ax) == ["$x$ [m]", *XYZ]
    assert ax.get_ylabel() == "length [m]"
    assert len({line.get_color() for line in ax.lines}) == 4


def test_a_vector_makes_three_curves_with_one_axis() -> None:
    ax = plot(swing(), "frame r P")
    assert legend(ax) == XYZ
    assert ax.get_ylabel() == "length [m]"
    assert plot(swing(), "pair").get_ylabel() == ""


def test_curves_of_several_units_share_the_axes_without_panels() -> None:
    ax = plot(swing(), "x", "v", "v_dot", panels=False)
    assert ax.figure.axes == [ax]
    assert legend(ax) == ["$x$ [m]", "$v$ [m/s]", r"$\dot{v}$"]
    assert ax.get_ylabel() == ""


def test_each_unit_has_a_panel_in_the_order_of_first_appearance() -> None:
    ax = plot(swing(), "x", "v", "frame r P", "v_dot", title="A swing", panels=True)
    lengths, rates, unknown = panels = ax.figure.axes
    assert lengths is ax
    assert [panel.get_ylabel() for panel in panels] == [
        "$x$, P $r_{x}$, P $r_{y}$, P $r_{z}$ [m]",
        "$v$ [m/s]",
        r"$\dot{v}$",
    ]
    assert legend(lengths) == ["$x$ [m]", *XYZ]
    assert legend(rates) == legend(unknown) == []
    assert [panel.get_xlabel() for panel in panels] == ["", "", "time [s]"]
    assert [panel.get_title() for panel in panels] == ["A swing", "", ""]
    lengths.set_xlim(1.0, 2.0)  # who zooms into one sees the same time in all
    assert {panel.get_xlim() for panel in panels} == {(1.0, 2.0)}
    # the values are where their unit is
    np.testing.assert_array_equal(data(rates), data(plot(swing(), "v")))


def test_one_unit_makes_the_same_picture_as_ever() -> None:
    (only,) = plot(swing(), "x", "frame r P").figure.axes
    assert only.figure.get_size_inches().tolist() == [7.0, 4.2]


def test_figures_grow_with_their_panels_up_to_a_bound() -> None:
    units = {f"y{k}": f"u{k}" for k in range(12)}
    motion = swing(stored={name: swing().t for name in units}, units=units)
    heights = [
        plot(motion, *[*units][:count], panels=True).figure.get_figheight() for count in (1, 2, 3, 8, 12)
    ]
    assert heights == pytest.approx([4.2, 6.0, 7.8, 13.0, 13.0])


def test_panels_over_another_output_mark_the_start() -> None:
    ax = plot(swing(), "v", "v_dot", x="x", panels=True)
    assert [panel.get_xlabel() for panel in ax.figure.axes] == ["", "$x$ [m]"]
    assert [len(panel.lines) for panel in ax.figure.axes] == [2, 2]


def test_long_names_break_into_lines_beside_their_panel() -> None:
    units = {"x": "m", "the kinetic energy of all that turns about the first axis of the arm": "J"}
    motion = swing(stored={name: swing().t for name in units}, units=units)
    label = plot(motion, *units, panels=True).figure.axes[1].get_ylabel()
    assert label.count("\n") >= 1 and label.replace("\n", " ").endswith("of the arm [J]")
    words = ["way of the left foot of the walker", "way of the right foot of the walker"]
    ax = plot(swing(), "x", "frame r P x", "v", labels=[*words, "v"], panels=True)
    assert ax.get_ylabel() == "length [m]" and len(legend(ax)) == 2


def test_more_curves_than_colours_differ_in_their_dashes() -> None:
    ax = plot(swing(), *["x", "frame r P"] * 2, "x")
    assert len({(line.get_color(), line.get_linestyle()) for line in ax.lines}) == len(ax.lines) == 9


def test_labels_replace_names_and_must_fit() -> None:
    ax = plot(swing(), "x", "frame r P x", labels=["place", "price in $ or $"])
    assert legend(ax) == ["place [m]", r"price in \$ or \$ [m]"]
    both = plot(swing(), "x", "v", labels=["place", "way [m]"], panels=True)  # the unit that is read decides
    assert len(both.figure.axes) == 1
    for labels in (["one"], "xv"):
        with pytest.raises(UsageError, match="2 curves need 2 labels, not .*\n.*labels for x, v"):
            plot(swing(), "x", "v", labels=labels)


def test_a_second_plot_joins_the_first() -> None:
    ax = plot(swing(), "x", labels=["first"])
    assert plot(swing(), "x", ax=ax, labels=["second"]) is ax
    assert legend(ax) == ["first [m]", "second [m]"]
    assert ax.get_ylabel() == "length [m]"
    plot(swing(), "v", ax=ax)
    assert ax.get_ylabel() == ""


def test_a_second_plot_joins_the_panels_of_the_first() -> None:
    ax = plot(swing(), "x", "v", labels=["first", "second"], panels=True)
    assert plot(swing(), "v", "x", "v_dot", ax=ax) is ax
    upper, lower = ax.figure.axes
    assert legend(lower) == ["second [m/s]", "$v$ [m/s]"] and lower.get_ylabel() == "second, $v$ [m/s]"
    assert legend(upper) == ["first [m]", "$x$ [m]", r"$\dot{v}$"]  # what has no panel goes where it was sent
    assert upper.get_ylabel() == ""


def test_axes_of_the_caller_take_all_units() -> None:
    figure, given = pyplot.subplots(2, 1)
    plot(swing(), "x", "v", ax=given[1])
    assert (len(given[0].lines), legend(given[1])) == (0, ["$x$ [m]", "$v$ [m/s]"])
    pyplot.close(figure)


def test_a_path_marks_its_start_and_keeps_its_shape() -> None:
    ax = plot(swing(), "v", x="x", equal=True)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x$ [m]", "$v$ [m/s]")
    assert ax.get_aspect() == 1.0
    x, v = data(ax)
    np.testing.assert_allclose(x**2 + v**2, 1.0, rtol=0.0, atol=60.0 * 1e-8)
    assert data(ax, 1).ravel().tolist() == [1.0, 0.0]
    assert legend(ax) == []


def test_a_path_in_the_plane() -> None:
    ax = plot(swing(), ("x", "v"), title="Phase")
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("$x$ [m]", "$v$ [m/s]", "Phase")
    assert ax.get_aspect() == "auto" and legend(ax) == []  # metres and metres per second
    np.testing.assert_array_equal(data(ax), data(plot(swing(), "v", x="x")))
    assert data(ax, 1).ravel().tolist() == [1.0, 0.0]  # the dot at the start
    assert plot(swing(), ("x", "frame r P x")).get_aspect() == 1.0  # lengths both
    assert plot(swing(), ("x", "frame r P x"), equal=False).get_aspect() == "auto"
    assert plot(swing(), ("x", "v"), equal=True).get_aspect() == 1.0


def test_several_paths_have_a_legend_and_what_they_share_at_the_axes() -> None:
    ax = plot(swing(), ("x", "frame r P y"), ("frame r P x", "frame r P y"))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("length [m]", "P $r_{y}$ [m]")
    assert legend(ax) == ["$x$, P $r_{y}$", "P"]
    ax = plot(swing(), ("frame r P x", "v"), ("frame r Q x", "x"), labels=["P", "Q in $"])
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x$ [m]", "")
    assert legend(ax) == ["P", r"Q in \$"]


def test_a_path_in_space_is_a_vector_or_three_numbers() -> None:
    ax = plot(swing(), ("frame r P",))
    assert ax.name == "3d" and ax.get_legend() is None
    labels = [getattr(ax, f"get_{letter}label")() for letter in "xyz"]
    assert labels == XYZ
    x, y, z = ax.lines[0].get_data_3d()
    np.testing.assert_allclose(x**2 + y**2, 1.0, rtol=0.0, atol=60.0 * 1e-8)
    assert z[0] == 0.0 and (np.diff(z) >= 0.0).all() and x.size >= SMOOTH
    # A unit is equally long: limits and the box have one ratio.
    spans = [np.ptp(getattr(ax, f"get_{letter}lim")()) for letter in "xyz"]
    box = np.asarray(vars(ax)["_box_aspect"])
    ratios = np.array(spans) / box
    assert np.ptp(ratios) < 1e-6 * ratios.max()
    assert plot(swing(), ("x", "v", "t")).name == "3d"


def test_paths_that_cannot_be_drawn_are_told() -> None:
    cases: list[tuple[tuple[str | tuple[str, ...], ...], dict[str, str], str]] = [
        ((("x",),), {}, "a path has 2 or 3 components, not 1"),
        ((("frame r P", "x"),), {}, "not 4\n.*they are r P x, r P y, r P z, x"),
        ((("x", "v"), "v"), {}, "curves over an output and paths do not share axes"),
        ((("x", "v"),), {"x": "v"}, "do not share axes"),
        ((("x", "v"), ("frame r P",)), {}, "two components in the plane and three in space"),
        ((("x", "v"), ("v", "x")), {"labels": "xv"}, "2 curves need 2 labels"),
    ]
    for expressions, options, message in cases:
        with pytest.raises(UsageError, match=message):
            plot(swing(), *expressions, **options)
    with pytest.raises(UsageError, match="axes for paths in space have projection='3d'"):
        plot(swing(), ("frame r P",), ax=plot(swing(), "x"))


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("frame v Top.CoM ground Base x", "Top.CoM Base $v_{x}$ [m/s]"),
        ("frame wdot Top ground ground z", r"Top $\dot{\omega}_{z}$ [rad/s²]"),
        ("frame R Top ground xy", "Top $R_{xy}$"),
        ("x_ddot", r"$\ddot{x}$ [m/s²]"),
        ("effort B", "effort B"),
    ],
)
def test_units_follow_from_the_words_of_an_output(name: str, unit: str) -> None:
    motion = swing(stored={name: np.zeros(swing().t.size)}, units={"x_dot": "m/s"})
    assert plot(motion, name).get_ylabel() == unit


def test_a_reaction_has_six_named_components() -> None:
    four_bar = sb.load_model(Path(__file__).parents[2] / "examples" / "four_bar" / "four_bar.toml")
    motion = sb.simulate(sb.form_equations(four_bar), 0.1)
    forces, moments = plot(motion, "reaction C", panels=True).figure.axes
    assert [text.split(" ")[2] for text in legend(forces)] == ["$F_{x}$", "$F_{y}$", "$F_{z}$"]
    assert [text.split(" ")[2] for text in legend(moments)] == ["$M_{x}$", "$M_{y}$", "$M_{z}$"]
    assert (forces.get_ylabel(), moments.get_ylabel()) == ("force [N]", "torque [N m]")
    labels = [plot(motion, f"reaction C {entry}").get_ylabel() for entry in ("Fx", "Mz")]
    assert labels == ["reaction C $F_{x}$ [N]", "reaction C $M_{z}$ [N m]"]


def test_a_label_with_a_unit_keeps_it() -> None:
    assert plot(swing(), "x", labels=["way [km]"]).get_ylabel() == "way [km]"


def test_names_that_do_not_exist_are_errors_and_leave_the_axes_alone() -> None:
    ax = plot(swing(evaluate=None), "x")
    with pytest.raises(UsageError, match="did you mean 'x'"):
        plot(swing(evaluate=None), "v", "xx", ax=ax)
    with pytest.raises(UsageError, match="did you mean 'x'"):
        plot(swing(evaluate=None), "v", x="xx", ax=ax)
    with pytest.raises(UsageError, match=r"'frame r P' has 3 components\n.*'frame r P x', 'frame r P y'"):
        plot(swing(), "v", x="frame r P", ax=ax)
    assert len(ax.lines) == 1


def test_a_single_sample_is_visible() -> None:
    ax = plot(swing().at(2.0), "x")
    assert data(ax).shape == (2, 1)
    assert ax.lines[0].get_marker() == "o"


def test_no_window_and_no_global_figure(tmp_path: Path) -> None:
    before = pyplot.get_fignums()
    ax = plot(swing(), "x")
    assert isinstance(ax.figure, Figure)
    assert pyplot.get_fignums() == before
    assert matplotlib.get_backend().lower() == "agg"
    script = "import sys, symbody.visual.plotting.plot; print('matplotlib.pyplot' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert (done.stdout, done.stderr) == ("False\n", "")


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_pictures_are_written(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"swing.{suffix}"
    save_plot(plot(swing(), "x", "v"), path)
    starts = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}
    assert path.read_bytes().startswith(starts[suffix])


def test_nothing_is_cut_off(tmp_path: Path) -> None:
    figure, given = pyplot.subplots()
    own = plot(swing(), "x", "frame r P", title="The title of a plot")
    panels = plot(swing(), "x", "frame r P", "pair", "v", title="The title of a plot", panels=True)
    for name, ax in (
        ("own", own),
        ("panels", panels),
        ("given", plot(swing(), "x", "v", "pair", ax=given, title="The title")),
    ):
        path = tmp_path / f"{name}.png"
        save_plot(ax, path)
        picture = imread(path)
        # a frame of two points around everything is blank
        edges = [picture[:2], picture[-2:], picture[:, :2], picture[:, -2:]]
        assert all((edge == 1.0).all() for edge in edges)
        assert picture.min() < 0.5
    pyplot.close(figure)


@pytest.mark.parametrize("count", cases([16, 23, 40], fast=[23]))
def test_long_legends_stay_in_the_picture(tmp_path: Path, count: int) -> None:
    save_plot(plot(swing(), "v", *["x"] * count, title="Many curves"), tmp_path / "many.png")
    picture = imread(tmp_path / "many.png")
    edges = [picture[:2], picture[-2:], picture[:, :2], picture[:, -2:]]
    assert all((edge == 1.0).all() for edge in edges)


def test_files_that_cannot_be_written_are_told(tmp_path: Path) -> None:
    ax = plot(swing(), "x")
    with pytest.raises(UsageError, match="'bmp9' is not a picture format\n.*png"):
        save_plot(ax, tmp_path / "swing.bmp9")
    with pytest.raises(UsageError, match="the name has no suffix"):
        save_plot(ax, tmp_path / "swing")
    with pytest.raises(EnvironmentFault, match="No such file or directory"):
        save_plot(ax, tmp_path / "missing" / "swing.png")


def test_motion_without_coordinates_needs_a_name() -> None:
    parts = [sb.Body("B", mass=1), sb.Prismatic("P", "ground", "B", coordinate="x", motion="sin(t)")]
    run = sb.simulate(sb.form_equations(sb.Model("driven", parts)), 0.1)
    for panels in (False, True):
        with pytest.raises(UsageError, match=r"plot\.nothing"):
            sb.plot(run, panels=panels)
    assert sb.plot(run, "energy").get_lines()
