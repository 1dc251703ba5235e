"""How values show themselves in notebooks: they look it up in a table that the room `display` fills."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, Final

VIEWS: Final[dict[type, Callable[[Any], str]]] = {}
# Loaded by its name, when something is shown: the rooms that are shown stand below the one that shows them.
_ROOM: Final = "symbody.display.views"


class Displayed:
    """A value that notebooks show as HTML."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        """Return the HTML of the nearest class that has a view."""
        import_module(_ROOM)
        return next(VIEWS[kind](self) for kind in type(self).__mro__ if kind in VIEWS)
