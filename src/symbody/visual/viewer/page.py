"""The page that shows a moving mechanism in any browser: one file with everything in it."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import symbody
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.formats.writing import replace_content, writing_cure
from symbody.visual.scene import motion_to_json, scene_to_json
from symbody.visual.scene.scene import Scene, SceneMotion
from symbody.visual.viewer.built_files import built_file

PageData = dict[str, Any]

_EMPTY: Final = '<script type="application/json" id="symbody-data">null</script>'
_TITLE: Final = "<title>symbody</title>"


def page_data(scene: Scene, motion: SceneMotion, title: str, options: Mapping[str, Any]) -> PageData:
    """Return the data of a page or a notebook as JSON values."""
    return {
        "scene": scene_to_json(scene),
        "motion": motion_to_json(motion),
        "title": title,
        "options": dict(options),
    }


def page_text(data: PageData) -> str:
    """Return the page with its data.

    Raises
    ------
    EnvironmentFault
        If this installation has no pages.
    UsageError
        If a length is not finite.
    """
    return fill_page("player.html", data, {})


def fill_page(name: str, data: PageData, further: Mapping[str, str]) -> str:
    """Return a page of the package with its data; `further` replaces parts of its template.

    Raises
    ------
    EnvironmentFault
        If this installation has no pages.
    UsageError
        If a length is not finite.
    """
    parts = {
        _TITLE: f"<title>{html.escape(str(data['title']))}</title>\n"
        f'<meta name="generator" content="symbody {symbody.__version__}">',
        _EMPTY: _EMPTY.replace("null", _json_text(data)),
        **further,
    }
    # All places are looked for in the template alone: what is put in may look like one.
    template, ways = built_file(name), re.compile("|".join(re.escape(part) for part in parts))
    left = dict(parts)
    return ways.sub(lambda place: left.pop(place.group(), place.group()), template)


def write_page(path: Path, text: str) -> None:
    """Write a page in one step.

    Raises
    ------
    EnvironmentFault
        If it cannot be written; the file that was there is unchanged.
    """
    try:
        if path.is_dir():
            raise IsADirectoryError(21, "it is a directory")
        replace_content(path, text.encode("utf-8"), like=path)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise EnvironmentFault(
            Problem("animation.unwritable", str(path), f"the page cannot be written: {reason}",
                    "an existing file is unchanged", writing_cure(error))
        ) from error  # fmt: skip


def _json_text(data: PageData) -> str:
    """Return JSON in which nothing ends or begins an element of the page."""
    try:
        text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    except ValueError as error:
        raise UsageError(
            Problem("animation.not_finite", str(data["title"]), "a length of the picture is not finite", "",
                    "check the parameters that define sizes and positions")
        ) from error  # fmt: skip
    return text.replace("<", "\\u003c")
