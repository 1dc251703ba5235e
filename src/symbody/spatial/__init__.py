"""Vectors as sums of terms, each in its own frame; rotations as successive turns."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
