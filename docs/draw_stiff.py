"""Measure and draw work beside precision of stiff motions: `python docs/draw_stiff.py`."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from pathlib import Path

import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).parents[1]))

from rich.console import Console

from benchmarks.precision import Diagram
from benchmarks.stiff import LIMIT, measure, summary, table
from benchmarks.stiff_problems import PROBLEMS
from benchmarks.table import show
from benchmarks.timing import Settings

PICTURE = Path(__file__).parent / "pictures" / "stiff.png"
COLUMNS = 4
STYLES = {
    "Explicit": ("#1f4e79", "o", "-"),
    "GeneralizedAlpha(step=h)": ("#c55a11", "s", "-"),
    "GeneralizedAlpha": ("#e0a030", "D", "-"),
    "Stiff (CVODE)": ("#7f7f7f", "^", "-"),
    "SciPy Radau": ("#548235", "v", "--"),
    "Exudyn": ("#7030a0", "P", "--"),
    "MuJoCo RK4": ("#c00000", "X", "--"),
    "MuJoCo implicitfast": ("#e07070", "x", "--"),
}


def draw(results: Mapping[str, Diagram]) -> None:
    """Write the picture of all problems."""
    rows = math.ceil((len(results) + 1) / COLUMNS)
    figure, panels = plt.subplots(
        rows, COLUMNS, figsize=(13.5, 3.4 * rows), sharex=True, sharey=True, constrained_layout=True
    )
    for panel, (name, diagram) in zip(panels.flat, results.items(), strict=False):
        for method, (color, marker, line) in STYLES.items():
            chosen = [point for point in diagram.points if point.method == method]
            panel.loglog(
                [point.error for point in chosen], [1e3 * point.seconds for point in chosen], color=color,
                marker=marker, markersize=4, linewidth=1.1, linestyle=line, label=method,
            )  # fmt: skip
        panel.set_title(name, fontsize=10)
        panel.set_xlim(1e-1, 1e-12)
        panel.set_xticks([10.0**-k for k in range(2, 13, 2)])
        panel.grid(which="major", color="#dddddd", linewidth=0.6)
        panel.tick_params(labelsize=8, labelbottom=True)
        panel.set_xlabel(f"error at the end [{'rad' if name == 'bushing' else 'm'}]", fontsize=8)
    for panel in panels[:, 0]:
        panel.set_ylabel("processor time of a run [ms]", fontsize=8)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    for panel in panels.flat[len(results) :]:
        panel.axis("off")
    panels.flat[len(results)].legend(handles, labels, loc="center", fontsize=9, frameon=False)
    figure.savefig(PICTURE, dpi=100)
    plt.close(figure)


def main() -> None:
    """Measure, print the tables and write the picture."""
    console = Console(width=200)
    results = {}
    for name in PROBLEMS:
        results[name] = measure(name, Settings(limit=LIMIT, rounds=3))
        show(table(name, results[name]), console)
    show(summary(results), console)
    draw(results)


if __name__ == "__main__":
    main()
