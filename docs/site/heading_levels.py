"""The captions of the navigation are headings; programs that read pages aloud need their level."""

from __future__ import annotations

from typing import Any

from sphinx.application import Sphinx

_AFTER_THEME = 900  # the theme makes the navigation in the same event


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the level to each page."""
    app.connect("html-page-context", _add_levels, priority=_AFTER_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _add_levels(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    tree = context.get("furo_navigation_tree")
    if isinstance(tree, str):
        context["furo_navigation_tree"] = tree.replace('role="heading"', 'role="heading" aria-level="2"')
