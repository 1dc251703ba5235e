"""The files that the build of the package makes from ``frontend/``, and why they may be missing."""

from __future__ import annotations

from importlib.resources import files
from typing import Final

from symbody.errors import EnvironmentFault, Problem

_FOLDER: Final = "pages"
_REASON: Final = "missing.txt"  # written by hatch_build.py


def built_file(name: str) -> str:
    """Return the text of a file that the build of the package made from ``frontend/``.

    Raises
    ------
    EnvironmentFault
        If it is missing.
    """
    try:
        return (files("symbody.visual") / _FOLDER / name).read_text(encoding="utf-8")
    except OSError:
        raise EnvironmentFault(
            Problem("animation.no_pages", name, "this installation does not include the pages that show "
                                                "motions",
                    why_no_pages(),
                    "install Node and run `pip install` again in the folder of the sources, or install a "
                    "released package; save_animation works without these pages")
        ) from None  # fmt: skip


def why_no_pages() -> str:
    """Return why pages may be missing, with what the build of the package noted if it did."""
    usual = (
        "they are built when symbody is installed from its sources, which needs Node 20 or later, or a "
        "network connection to download it"
    )
    try:
        noted = (files("symbody.visual") / _FOLDER / _REASON).read_text(encoding="utf-8").strip()
    except OSError:
        return usual
    return f"{usual}; during this installation: {noted}"
