"""Sweeps as pictures, and paths in space that stay in a plane."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.display.test_views import oscillator

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_sweep_is_drawn_case_by_case() -> None:
    eqs = sb.form_equations(oscillator())
    few = sb.sweep(eqs, 1.0, {"m": [1.0, 2.0]}, initial={"x": [0.5]})
    axes = sb.plot(few, "x", "2*x_dot", title="masses")
    upper, lower = axes.figure.axes
    assert (upper.get_title(), lower.get_xlabel()) == ("masses", "time [s]")
    for line, row in zip(lower.get_lines(), few["2*x_dot"], strict=True):
        np.testing.assert_array_equal(line.get_ydata(), row)
    legend = upper.get_legend()
    assert legend is not None and len(legend.get_texts()) == 2 and "= 2" in legend.get_texts()[1].get_text()
    many = sb.plot(sb.sweep(eqs, 1.0, {"m": np.linspace(1, 2, 12)}, initial={"x": [0.5]}))
    assert len(many.get_lines()) == 12 and many.get_legend() is None
    scale = many.figure.axes[-1]
    assert "[kg]" in scale.get_ylabel()
    assert len({line.get_color() for line in many.get_lines()}) == 12


@pytest.mark.parametrize(
    ("expressions", "code"),
    [(("reaction slider",), "plot.sweep_components"), ((("x", "x_dot"),), "plot.sweep_path")],
)
def test_what_cannot_be_drawn_of_a_sweep(expressions: tuple[Any, ...], code: str) -> None:
    sweep = sb.sweep(sb.form_equations(oscillator()), 1.0, {"m": [1.0, 2.0]})
    with pytest.raises(sb.UsageError) as caught:
        sb.plot(sweep, *expressions)
    assert caught.value.problems[0].code == code
    with pytest.raises(sb.UsageError, match="remove ax"):
        sb.plot(sweep, "x", "x_dot", ax=sb.plot(sweep))


def test_paths_that_stay_in_a_plane_are_drawn_in_it() -> None:
    run = sb.simulate(sb.form_equations(sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml")), 0.3)
    axes = sb.plot(run, ("frame r Coupler.P",), ("frame r Crank",))
    assert axes.name == "rectilinear" and (axes.get_xlabel(), axes.get_ylabel()) == ("$x$ [m]", "$y$ [m]")
    in_space = sb.plot(run, ("frame r Coupler.P",), ax=sb.plot(run, ("theta", "beta", "phi")))
    assert in_space.name == "3d"  # as the axes that were given
