"""Symbolic multibody dynamics: model file, readable equations, fast code, motion.

The names below are listed in the order of the flow in ``__init__.pyi`` and load on first use,
so that ``import symbody`` costs nothing.
"""

from importlib import import_module

import lazy_loader

__version__ = "0.1.0"

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    """Return a public name; an unknown one is refused with those that are spelt alike."""
    if name in __all__ or name.startswith("_"):
        return _load(name)
    try:
        return _load(name)
    except AttributeError as error:
        # loaded when they are needed, as all else
        nearest = import_module("symbody.errors").nearest
        others = import_module("symbody.model.declarations.field").OTHER_NAMES
        word = others.get(name.lower(), "").title().replace("_", "")
        cure = f"in symbody it is called {word!r}" if word in __all__ else nearest(name, __all__)
        text = f"symbody has no {name!r}; {cure}"
        raise AttributeError(text, name=name) from error
