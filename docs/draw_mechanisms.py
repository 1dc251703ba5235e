"""Draw the mechanisms with a check: `python docs/draw_mechanisms.py` renews pictures, files and their page.

Each script of examples/gallery gives a mechanism, its motion, a comparison with a closed form, and how it
looks. Its picture is docs/pictures/gallery/NAME.png, its model file lies beside it, and docs/mechanisms.md is
made of the first lines of all scripts. Names of scripts as arguments draw these alone, then the page of all.
`--pages DIR` writes a folder instead: a page of each, which simulates or plays, and an index with pictures.
"""

from __future__ import annotations

import argparse
import ast
import html
import os
import runpy
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

from matplotlib.figure import Figure

import symbody as sb

HERE: Final = Path(__file__).resolve().parent
PICTURES: Final = HERE / "pictures" / "gallery"
EXAMPLES: Final = HERE.parent / "examples"
MECHANISMS: Final = sorted(EXAMPLES.glob("gallery/*/*.py"))
HEADINGS: Final[Mapping[str, str]] = {"linkages": "Linkages", "drives": "Drives", "motions": "Motions"}
WIDTH: Final = "100"  # of lines of equations, on whatever screen
MOST_LINES: Final = 17  # of equations that the page shows
# Why no page simulates these: they are played as they were computed.
PLAYED: Final[Mapping[str, str]] = {
    "bennett": "its constraints follow from others in closed loops only",
    "block_and_tackle": "the blocks would meet",
    "cycloid_drive": "its two pins repeat each other",
    "geneva": "its constraint changes with the phase",
    "hill_muscle": "the elbow would turn through",
    "rimless_wheel": "each landing is an event",
    "stick_slip": "its friction sticks",
}
HEAD: Final = """# Mechanisms with a check

{count} mechanisms, each a script of one screen that builds it, moves it, and compares the motion with a
closed form, from a publication or derived beside it. One command shows each, prints how close the two are,
and writes its page:

```sh
python examples/gallery/show.py watt         # plays the motion
python examples/gallery/show.py watt --live  # simulates in the page, and bodies can be pulled
```

In Python:

```python
import runpy

entry = runpy.run_path("examples/gallery/linkages/watt.py")
run = entry["motion"]()
computed, formula = entry["comparison"](run)
print(abs(computed - formula).max() < entry["TOLERANCE"])
```

The model files beside the scripts go into [the editor](builder.md) and all
[commands](reference/command_line.md), such as `symbody equations watt.toml`. `pytest -m "" tests/gallery`
repeats all comparisons, `python docs/draw_mechanisms.py` draws pictures, model files and this page anew, and
with `--pages DIR` it writes the pages of all motions to a folder that needs no network.
"""
CARD: Final = """:::{{grid-item-card}} {title}
:img-top: pictures/gallery/{name}.png
:link: gallery-{name}
:link-type: ref
:class-title: sd-fs-6
:::
"""


INDEX: Final = """<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>Mechanisms</title>
<style>
body {{ font-family: sans-serif; margin: 2rem auto; max-width: 80rem; padding: 0 1rem; }}
main {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: 1rem; }}
a {{ border: 1px solid #ccc; border-radius: 0.4rem; color: #222; padding: 0.5rem; text-decoration: none; }}
a:hover, a:focus {{ border-color: #06c; }}
img {{ width: 100%; }}
</style>
<h1>Mechanisms</h1>
<main>
{figures}
</main>
</html>
"""
FIGURE: Final = '<a href="{name}.html"><img src="{name}.png" alt="">{title}</a>'


@cache
def script_of(path: Path) -> Mapping[str, Any]:
    """Return the names of a script."""
    return runpy.run_path(str(path))


def draw_mechanism(path: Path) -> None:
    """Write the picture of a mechanism: as its script draws it, or as its bodies look."""
    entry = script_of(path)
    run, picture = entry["motion"](), PICTURES / f"{path.stem}.png"
    if "draw" not in entry:
        sb.save_animation(run, picture, size=(600, 400), progress=False, **entry["LOOK"])
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
    texts = [
        text.replace("Check: ", "**Check**: ").replace("^", r"\^").replace("*(", r"\*(")
        for text in paragraphs
    ]
    return title.rstrip("."), texts


def equations_lines(path: Path) -> Iterator[str]:
    """Yield the equations of motion, or how many there are."""
    os.environ["COLUMNS"] = WIDTH
    eqs = sb.form_equations(script_of(path)["model"]())
    lines = str(eqs).splitlines()
    if len(lines) <= MOST_LINES:
        yield from (":::{dropdown} Equations", "```text", *lines, "```", ":::", "")
        return
    speeds, multipliers = len(eqs.speed_names), len(eqs.multiplier_names)
    yield f"Equations: {speeds} of motion with {multipliers} multipliers, {len(lines)} lines.\n"


def mechanism_lines(path: Path) -> Iterator[str]:
    """Yield what the page says about one mechanism."""
    title, paragraphs = title_and_text(path)
    folder = Path("..") / path.parent.relative_to(EXAMPLES.parent)
    files = " · ".join(f"[{name}]({(folder / name).as_posix()})" for name in (path.name, f"{path.stem}.toml"))
    page = f"not live: {PLAYED[path.stem]}" if path.stem in PLAYED else "also `--live`"
    yield f"(gallery-{path.stem})=\n"
    yield f"### {title}\n"
    yield f"![{title}](pictures/gallery/{path.stem}.png)\n"
    yield from (f"{text}\n" for text in paragraphs)
    yield from equations_lines(path)
    yield f"`python examples/gallery/show.py {path.stem}` · {page} · {files}\n"


def mechanisms_page() -> str:
    """Return the page of the mechanisms with a check as Markdown: cards, then each mechanism."""
    lines = [HEAD.format(count=len(MECHANISMS))]
    groups = {group: [path for path in MECHANISMS if path.parent.name == group] for group in HEADINGS}
    for group, paths in groups.items():
        lines += [f"**{HEADINGS[group]}**\n", "::::{grid} 2 3 4 4\n:gutter: 2\n"]
        lines += [CARD.format(title=title_and_text(path)[0], name=path.stem) for path in paths]
        lines.append("::::\n")
    for group, paths in groups.items():
        lines.append(f"## {HEADINGS[group]}\n")
        for path in paths:
            lines += mechanism_lines(path)
    return "\n".join(lines)


def write_motion_page(path: Path, page: Path) -> None:
    """Write a page of a mechanism that simulates; one that plays where none can."""
    entry = script_of(path)
    live = path.stem not in PLAYED
    shown = sb.form_equations(entry["model"]()) if live else entry["motion"]()
    look, title = entry["LOOK"], title_and_text(path)[0]
    view: Any = look.get("view", "auto")  # pages know names of views alone
    view = view if isinstance(view, str) else "isometric"
    sb.animate(shown, page, live=live, title=title, traces=look.get("traces", ()), view=view)


def write_pages(paths: Sequence[Path], folder: Path) -> None:
    """Write a page of each mechanism to a folder, and index.html with their pictures; all work offline."""
    folder.mkdir(parents=True, exist_ok=True)
    figures = []
    for path in paths:
        write_motion_page(path, folder / f"{path.stem}.html")
        shutil.copy(PICTURES / f"{path.stem}.png", folder)
        title = html.escape(title_and_text(path)[0])
        figures.append(FIGURE.format(name=path.stem, title=title))
        print(path.stem, flush=True)
    (folder / "index.html").write_text(INDEX.format(figures="\n".join(figures)), encoding="utf-8")


def main() -> None:
    """Draw the mechanisms that are named, or all; then the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help="scripts of examples/gallery without .py; none: all")
    parser.add_argument("--pages", type=Path, metavar="DIR", help="write pages of the motions to a folder")
    words = parser.parse_args()
    paths = [path for path in MECHANISMS if not words.names or path.stem in words.names]
    if words.pages is not None:
        write_pages(paths, words.pages)
        return
    for path in paths:
        draw_mechanism(path)
        path.with_suffix(".toml").write_text(model_text(path), encoding="utf-8")
        print(path.stem, flush=True)
    (HERE / "mechanisms.md").write_text(mechanisms_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
