"""Draw the film at the top of the README: `python docs/draw_readme.py` writes docs/pictures/four_bar*.gif."""

from __future__ import annotations

import runpy
from pathlib import Path

import symbody as sb

HERE = Path(__file__).parent
SCRIPT = HERE.parent / "examples" / "gallery" / "linkages" / "crank_rocker.py"
FILMS = {False: HERE / "pictures" / "four_bar.gif", True: HERE / "pictures" / "four_bar_dark.gif"}


def main() -> None:
    """Write one turn of the crank, for light and dark pages: the film ends where it begins."""
    run = runpy.run_path(str(SCRIPT))["motion"]()
    look = {"speed": 0.4, "fps": 25, "size": (640, 340), "traces": ["Coupler.P"]}
    for dark, film in FILMS.items():
        sb.save_animation(run, film, times=(0, 1), dark=dark, **look)


if __name__ == "__main__":
    main()
