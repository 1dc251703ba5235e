"""Draw linear against full motions of a pendulum: `python docs/draw_linearization.py` writes the picture."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import expm

import symbody as sb

PICTURE = Path(__file__).parent / "pictures" / "linearization.png"


def main() -> None:
    """Write the picture."""
    bob = sb.Body("Bob", mass=0.1, frames={"o": sb.Frame(at=(0, 1, 0))})
    pivot = sb.Revolute("pivot", "ground", "Bob.o", coordinate="theta")
    eqs = sb.form_equations(sb.Model("pendulum", [bob, pivot], gravity=(0, -9.81, 0)))
    times = np.linspace(0.0, 4.0, 401)
    figure, panels = plt.subplots(1, 3, figsize=(9, 2.8), constrained_layout=True)
    cases = ((0.0, 0.1, "about 0, from 0.1 rad"), (0.0, 1.5, "about 0, from 1.5 rad"),
             (np.pi, np.pi - 0.01, "about pi, from pi - 0.01 rad"))  # fmt: skip
    for panel, (place, start, title) in zip(panels, cases, strict=True):
        full = sb.simulate(eqs, 4.0, {"theta": start}, times=times)
        lin = sb.linearize(eqs, {"theta": place})
        k = lin.state_names.index("theta")
        first = np.zeros(2)
        first[k] = start - place
        linear = [place + (expm(lin.A * t) @ first)[k] for t in times]
        panel.plot(times, full["theta"], color="#1f4e79", label="full")
        panel.plot(times, linear, color="#c55a11", linestyle="--", label="linear")
        low, high = float(full["theta"].min()), float(full["theta"].max())
        panel.set_ylim(low - 0.15 * (high - low), high + 0.15 * (high - low))
        panel.set_title(title, fontsize=9)
        panel.set_xlabel("t [s]")
    panels[0].set_ylabel("theta [rad]")
    panels[0].legend(fontsize=8, loc="lower right")
    figure.savefig(PICTURE, dpi=110)


if __name__ == "__main__":
    main()
