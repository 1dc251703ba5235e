"""Draw the film at the top of the README: `python docs/draw_readme.py` writes docs/pictures/four_bar.gif."""

from __future__ import annotations

import runpy
from pathlib import Path

import symbody as sb

HERE = Path(__file__).parent
SCRIPT = HERE.parent / "examples" / "gallery" / "linkages" / "crank_rocker.py"
FILM = HERE / "pictures" / "four_bar.gif"


def main() -> None:
    """Write one turn of the crank: the film ends where it begins."""
    run = runpy.run_path(str(SCRIPT))["motion"]()
    sb.save_animation(run, FILM, times=(0, 1), speed=0.4, fps=25, size=(640, 340), traces=["Coupler.P"])


if __name__ == "__main__":
    main()
