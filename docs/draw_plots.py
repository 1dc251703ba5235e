"""Draw the pictures of docs/plots.md: ``python docs/draw_plots.py``."""

from __future__ import annotations

from pathlib import Path

import symbody as sb

PICTURES = Path(__file__).parent / "pictures"
EXAMPLES = Path(__file__).parents[1] / "examples"


def ball() -> None:
    """Draw a ball that bounces: jumps of its velocity, and events."""
    lift = sb.Prismatic("lift", "ground", sb.Body("Ball", mass=1), axis="y", coordinate="h")
    model = sb.Model("ball", [lift], gravity=(0, -9.81, 0), initial={"h": 1.0})
    bounce = sb.Event("h", direction=-1, action={"h_dot": "-0.8*h_dot"}, name="bounce")
    run = sb.simulate(sb.form_equations(model), 2.5, times=[0.0, 2.5], events=bounce)
    sb.save_plot(sb.plot(run, "h", "h_dot"), PICTURES / "plot_ball.svg")


def slider_crank() -> None:
    """Draw expressions of a slider-crank with their units."""
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml"))
    run = sb.simulate(eqs, 2.0)
    force = "sqrt('reaction A Fx'^2 + 'reaction A Fy'^2)"
    ax = sb.plot(run, force, "0.5*m3*s_dot^2", "180/pi*theta_dot")
    sb.save_plot(ax, PICTURES / "plot_expressions.svg")


if __name__ == "__main__":
    ball()
    slider_crank()
