"""Draw the gallery: `python docs/draw_mechanisms.py` renews pictures, model files and pages.

Each script of examples/gallery gives a mechanism, its motion, a comparison with a closed form, and how it
looks. Its pictures are docs/pictures/gallery/NAME.png and NAME_dark.png, its model file lies beside it, and
its page docs/gallery/NAME.md is made of the docstring of the script. Names of scripts as arguments draw
these alone, then the pages of all; with `--pages` only these are written. The site shows each motion in
place of its picture (docs/site/moving_pictures.py).
"""

from __future__ import annotations

import argparse
import ast
import runpy
import sys
import tempfile
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

import symbody as sb
from symbody.equations.outputs.equation_page import DIGITS_NOTE
from symbody.equations.outputs.equation_sections import SHOWN_DIGITS as DIGITS

sys.path.insert(0, str(Path(__file__).parents[1]))
from docs.typeset import with_formulas

HERE: Final = Path(__file__).resolve().parent
PICTURES: Final = HERE / "pictures" / "gallery"
EXAMPLES: Final = HERE.parent / "examples"
MECHANISMS: Final = sorted(EXAMPLES.glob("gallery/*/*.py"))
HEADINGS: Final[Mapping[str, str]] = {
    "linkages": "Linkages",
    "drives": "Drives",
    "motions": "Motions",
    "contacts": "Contacts",
}
WIDTH: Final = 100  # of lines of equations, on whatever screen
LETTERS: Final = 62  # of a typeset row
MOST_LINES: Final = 23  # of equations that the page shows
# Why no page simulates these: they are played as they were computed.
PLAYED: Final[Mapping[str, str]] = {
    "bennett": "its redundant constraints depend on the configuration",
    "block_and_tackle": "the blocks would collide",
    "cam_lift_off": "the cam turns faster without end",
    "clearance": "two corners strike within a nanosecond, which takes small tolerances",
    "cycloid_drive": "its two pins are redundant",
    "geneva": "its constraint changes with the phase",
    "hill_muscle": "the elbow would turn over",
    "rimless_wheel": "each landing is an event",
    "stick_slip": "its friction sticks",
    "walker": "each landing is an event",
}
HEAD: Final = """# Gallery

{count} mechanisms that move in your browser. Each is a script of one screen that builds the mechanism,
computes its motion and compares it with a closed form, from the literature or derived beside it.
"""
TAIL: Final = """## On your own machine

```sh
python examples/gallery/show.py watt         # prints the difference from the closed form, plays the motion
python examples/gallery/show.py watt --live  # simulates in the page, with bodies to pull
```

The model file beside each script opens in [the editor](builder.md) and works with all
[commands](reference/command_line.md), such as `symbody equations watt.toml`. From Python:

```python
import runpy

entry = runpy.run_path("examples/gallery/linkages/watt.py")
run = entry["motion"]()
computed, formula = entry["comparison"](run)
print(abs(computed - formula).max() < entry["TOLERANCE"])
```

Larger examples, vehicles and robots among them, are in `examples/`; `symbody examples` lists them.
"""
COLUMNS: Final = 4


@cache
def script_of(path: Path) -> Mapping[str, Any]:
    """Return the names of a script."""
    return runpy.run_path(str(path))


def path_of(name: str) -> Path:
    """Return the script of a mechanism by its name."""
    return next(path for path in MECHANISMS if path.stem == name)


def draw_mechanism(path: Path) -> None:
    """Write the pictures of a mechanism, light and dark: as its script draws it, or as its bodies look."""
    entry = script_of(path)
    run, picture = entry["motion"](), PICTURES / f"{path.stem}.png"
    if "draw" not in entry:
        for end in ("", "_dark"):
            file = picture.with_stem(f"{path.stem}{end}")
            look = {"size": (600, 400), "progress": False, "dark": bool(end)}
            sb.save_animation(run, file, **look, **entry["LOOK"])
        return
    figure = Figure(figsize=(6, 4), layout="constrained")
    entry["draw"](run, figure.subplots())
    figure.savefig(picture, dpi=100)


def model_text(path: Path) -> str:
    """Return the model file of a mechanism."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "model.toml"
        sb.save_model(script_of(path)["model"](), file)
        return file.read_text(encoding="utf-8")


def title_and_text(path: Path) -> tuple[str, list[str]]:
    """Return the first line of a script, and the paragraphs below it as Markdown."""
    module = ast.parse(path.read_text(encoding="utf-8"))
    title, *paragraphs = (ast.get_docstring(module) or "").split("\n\n")
    texts = [with_formulas(text.replace("Check: ", "**Check**: ")) for text in paragraphs]
    return title.rstrip("."), texts


def equations_lines(path: Path) -> Iterator[str]:
    """Yield the equations of motion, or how many there are."""
    eqs = sb.form_equations(script_of(path)["model"]())
    lines = len(eqs.text(width=WIDTH).splitlines())
    yield "## Equations of motion\n"
    if lines <= MOST_LINES:
        shown = eqs.latex(width=LETTERS, digits=DIGITS)
        if shown != eqs.latex(width=LETTERS):
            yield f"{DIGITS_NOTE.format(DIGITS)}\n"
        yield from ("```math", shown, "```", "")
        return
    speeds, multipliers = len(eqs.speed_names), len(eqs.multiplier_names)
    yield f"{speeds} equations of motion with {multipliers} multipliers, {lines} lines:"
    yield f"`symbody equations {path.stem}.toml` prints them.\n"


def mechanism_page(path: Path) -> str:
    """Return the page of one mechanism as Markdown; on the site its picture moves."""
    title, paragraphs = title_and_text(path)
    folder = Path("../..") / path.parent.relative_to(EXAMPLES.parent)
    files = " · ".join(f"[{name}]({(folder / name).as_posix()})" for name in (path.name, f"{path.stem}.toml"))
    live = "" if path.stem in PLAYED else "; `--live` simulates it in the page"
    lines = [f"# {title}\n", f"![{title}](../pictures/gallery/{path.stem}.png)\n"]
    if path.stem in PLAYED:
        lines.append(f"The motion is played as it was computed, because {PLAYED[path.stem]}.\n")
    lines += [f"{text}\n" for text in paragraphs]
    lines += equations_lines(path)
    lines.append("## Files\n")
    lines.append(f"{files}. `python examples/gallery/show.py {path.stem}` compares and plays it{live}.\n")
    return "\n".join(lines)


def gallery_page() -> str:
    """Return the page with the pictures of all mechanisms as Markdown."""
    lines = [HEAD.format(count=len(MECHANISMS))]
    for group, heading in HEADINGS.items():
        cards = [
            f"[![]({(PICTURES / path.stem).relative_to(HERE).as_posix()}.png) {title_and_text(path)[0]}]"
            f"(gallery/{path.stem}.md)"
            for path in MECHANISMS
            if path.parent.name == group
        ]
        lines += [f"## {heading}\n", "| " * COLUMNS + "|", "|---" * COLUMNS + "|"]
        for row in range(0, len(cards), COLUMNS):
            lines.append("| " + " | ".join(cards[row : row + COLUMNS]) + " |")
        names = "\n".join(f"gallery/{path.stem}" for path in MECHANISMS if path.parent.name == group)
        lines += ["", f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"]
    return "\n".join([*lines, TAIL])


def write_gallery() -> None:
    """Write the pages of the gallery."""
    (HERE / "gallery").mkdir(exist_ok=True)
    for path in MECHANISMS:
        (HERE / "gallery" / f"{path.stem}.md").write_text(mechanism_page(path), encoding="utf-8")
    (HERE / "gallery.md").write_text(gallery_page(), encoding="utf-8")


def write_motion_page(path: Path, page: Path) -> None:
    """Write a page of a mechanism that simulates; one that plays where none can."""
    entry = script_of(path)
    live = path.stem not in PLAYED
    shown = sb.form_equations(entry["model"]()) if live else entry["motion"]()
    look, title = entry["LOOK"], title_and_text(path)[0]
    view: Any = look.get("view", "auto")  # pages know names of views alone
    view = view if isinstance(view, str) else "isometric"
    drawn = {"traces": look.get("traces", ()), "vectors": look.get("vectors")}
    sb.animate(shown, page, live=live, title=title, view=view, **drawn)


def main() -> None:
    """Draw the mechanisms that are named, or all; then the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help="scripts of examples/gallery without .py; none: all")
    parser.add_argument("--pages", action="store_true", help="write the pages alone")
    words = parser.parse_args()
    paths = [path for path in MECHANISMS if not words.names or path.stem in words.names]
    for path in () if words.pages else paths:
        draw_mechanism(path)
        path.with_suffix(".toml").write_text(model_text(path), encoding="utf-8")
        print(path.stem, flush=True)
    write_gallery()


if __name__ == "__main__":
    main()
