"""Measure and draw work beside precision of stiff motions: `python docs/draw_stiff.py`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).parents[1]))

from rich.console import Console

from benchmarks.stiff import Point, measure, problems, table
from benchmarks.table import show
from benchmarks.timing import Settings

PICTURE = Path(__file__).parent / "pictures" / "stiff.png"
STYLES = {
    "Explicit": ("#1f4e79", "o"),
    "GeneralizedAlpha(step=h)": ("#c55a11", "s"),
    "GeneralizedAlpha": ("#e0a030", "D"),
    "Stiff (CVODE)": ("#7f7f7f", "^"),
    "SciPy Radau": ("#548235", "v"),
}


def draw(results: Mapping[str, Sequence[Point]]) -> None:
    """Write the picture of all problems."""
    figure, panels = plt.subplots(
        2, 3, figsize=(10.5, 6.6), sharex=True, sharey=True, constrained_layout=True
    )
    for panel, (name, points) in zip(panels.flat, results.items(), strict=False):
        for method, (color, marker) in STYLES.items():
            chosen = [point for point in points if point.method == method]
            panel.loglog(
                [point.error for point in chosen], [1e3 * point.seconds for point in chosen], color=color,
                marker=marker, markersize=4, linewidth=1.2, label=method,
            )  # fmt: skip
        panel.set_title(name, fontsize=10)
        panel.set_xlim(1.0, 1e-12)
        panel.set_xticks([10.0**-k for k in range(0, 13, 2)])
        panel.grid(which="major", color="#dddddd", linewidth=0.6)
        panel.tick_params(labelsize=8, labelbottom=True)
    for panel in (panels[0, 2], *panels[1, :2]):
        panel.set_xlabel("error at the end [m], of the bushing [rad]", fontsize=8)
    for panel in panels[:, 0]:
        panel.set_ylabel("processor time of a call [ms]", fontsize=8)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    panels[1, 2].axis("off")
    panels[1, 2].legend(handles, labels, loc="center", fontsize=9, frameon=False)
    figure.savefig(PICTURE, dpi=100)


def main() -> None:
    """Measure, print the tables and write the picture."""
    console = Console(width=150)
    results = {}
    for problem in problems():
        results[problem.name] = measure(problem, Settings(limit=4.0, rounds=5))
        show(table(problem.name, results[problem.name]), console)
    draw(results)


if __name__ == "__main__":
    main()
