"""How values show themselves in notebooks: they look it up in tables that the room `display` fills."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, Final

# HTML of a value by its class, and LaTeX with its delimiters of those that are formulas.
VIEWS: Final[dict[type, Callable[[Any], str]]] = {}
LATEX_VIEWS: Final[dict[type, Callable[[Any], str | None]]] = {}
# Loaded by its name, when something is shown: the rooms that are shown stand below the one that shows them.
_ROOM: Final = "symbody.display.views"


class Displayed:
    """A value that notebooks show as HTML, documents made from them as LaTeX, and terminals as text."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the HTML of the nearest class that has a view."""
        import_module(_ROOM)
        return next(VIEWS[kind](self) for kind in type(self).__mro__ if kind in VIEWS)

    def _repr_latex_(self) -> str | None:
        """Return LaTeX with its delimiters; None for what is a table, not a formula."""
        import_module(_ROOM)
        views = (LATEX_VIEWS[kind](self) for kind in type(self).__mro__ if kind in LATEX_VIEWS)
        return next(views, None)

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> Mapping[str, str]:
        """Return all forms, from which a notebook and its exporters choose."""
        forms = {"text/plain": str(self), "text/html": self._repr_html_(), "text/latex": self._repr_latex_()}
        return {kind: text for kind, text in forms.items() if text is not None}
