"""Show a mechanism of the gallery: `python examples/gallery/show.py watt`.

Prints how far its motion is from the closed form, and writes watt.html, which plays the motion in any
browser. With `--live` the page simulates, and bodies can be pulled in it. Without a name all are listed.
"""

import argparse
import runpy
from pathlib import Path

import numpy as np

import symbody as sb

SCRIPTS = {path.stem: path for path in sorted(Path(__file__).parent.glob("*/*.py"))}


def main():
    """Show the mechanism that is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("name", nargs="?", choices=SCRIPTS, metavar="NAME")
    parser.add_argument("--live", action="store_true", help="a page that simulates")
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    words = parser.parse_args()
    if words.name is None:
        print(*SCRIPTS, sep="\n")
        return
    entry = runpy.run_path(str(SCRIPTS[words.name]))
    run, page = entry["motion"](), Path(f"{words.name}.html")
    computed, formula = entry["comparison"](run)
    difference = np.abs(np.asarray(computed) - formula).max()
    print(f"{words.name}: {difference:.1e} from the closed form, {entry['TOLERANCE']:g} allowed")
    shown = sb.form_equations(entry["model"]()) if words.live else run
    view = entry["LOOK"].get("view", "auto")
    view = view if isinstance(view, str) else "auto"
    drawn = {"traces": entry["LOOK"].get("traces", ()), "vectors": entry["LOOK"].get("vectors")}
    sb.animate(shown, page, live=words.live, view=view, **drawn)
    print(page.resolve())
    if words.open:
        import webbrowser

        webbrowser.open(page.resolve().as_uri())


if __name__ == "__main__":
    main()
