"""The models that come with symbody: the order in which they are offered, their titles and summaries."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

# From the simplest on; others follow by their names.
_ORDER: Final = (
    "spring_mass_damper", "slider_crank", "projectile", "four_bar", "cart_pole", "rr_robot", "spinning_top",
    "quarter_car", "cart_pole_pid", "dc_motor_arm", "spatial_four_bar", "robot_arm", "stewart_platform",
    "spinning_top_omega", "bicycle", "four_legs", "parameter_fit",
)  # fmt: skip
_PARTS: Final = frozenset({"leg"})  # of other examples: nothing by themselves
_GROUPS: Final = ("linkages", "drives", "motions", "contacts")
_CAPITALS: Final = frozenset({"rr", "dc", "pid", "urdf"})
_SMALL: Final = frozenset({"a", "an", "and", "of", "on", "the", "with", "by", "in", "to", "from", "between"})
CARDS: Final = Path(__file__).parent / "cards"  # NAME.webp, NAME_dark.webp of each entry: docs/draw_cards.py
_WORD: Final = re.compile(r"[A-Za-z']+")


@dataclass(frozen=True, slots=True)
class Entry:
    """A model of the catalogue.

    Attributes
    ----------
    name : str
        By which it is opened: of the gallery with its folder, ``"linkages/watt"``.
    group : str
        "examples", or the folder of the gallery.
    """

    name: str
    path: Path
    group: str

    def describe(self) -> dict[str, str]:
        """Return what a card says: name, group, title, and a summary without the text of the file."""
        title, summary = self.path.stem.replace("_", " "), ""
        if self.path.suffix == ".toml":
            lines = self.path.read_text(encoding="utf-8").splitlines()
            named = next((line for line in lines if line.startswith("name")), "")
            title = named.partition('"')[2].rpartition('"')[0] or title
            summary = _comment(lines)
        summary = summary or _script_summary(self.path.with_suffix(".py"))
        return {"name": self.name, "group": self.group, "title": in_title_case(title), "summary": summary}


def catalog(examples: Path) -> Iterator[Entry]:
    """Return all models of a folder of examples, the simplest first, then those of the gallery."""
    found = {path.stem: path for kind in ("toml", "urdf") for path in sorted(examples.glob(f"*/*.{kind}"))}
    shown = [*(stem for stem in _ORDER if stem in found), *sorted(found.keys() - {*_ORDER, *_PARTS})]
    yield from (Entry(stem, found[stem], "examples") for stem in shown)
    for group in _GROUPS:
        paths = sorted((examples / "gallery" / group).glob("*.toml"))
        yield from (Entry(f"{group}/{path.stem}", path, group) for path in paths)


def in_title_case(text: str) -> str:
    """Return a title whose words begin with capitals, but short ones between others.

    >>> in_title_case("four-bar of the RR robot")
    'Four-Bar of the RR Robot'
    """

    def write_word(match: re.Match[str]) -> str:
        word = match.group()
        if word.lower() in _CAPITALS:
            return word.upper()
        return word if word in _SMALL and match.start() > 0 else word[0].upper() + word[1:]

    return _WORD.sub(write_word, text.replace("_", " "))


def _comment(lines: list[str]) -> str:
    """Return the comment at the beginning of a file, in one line."""
    count = next((k for k, line in enumerate(lines) if not line.startswith("#")), len(lines))
    return " ".join(line.lstrip("# ") for line in lines[:count])


def _script_summary(script: Path) -> str:
    """Return the first sentence of a script's second paragraph: what its mechanism is."""
    if not script.is_file():
        return ""
    text = ast.get_docstring(ast.parse(script.read_text(encoding="utf-8"))) or ""
    paragraphs = [" ".join(each.split()) for each in text.split("\n\n")]
    about = paragraphs[1].removeprefix("Description ") if len(paragraphs) > 1 else ""
    return re.split(r"(?<=[.;:])\s", about, maxsplit=1)[0].rstrip(";:")
