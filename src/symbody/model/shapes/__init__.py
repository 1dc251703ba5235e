"""Shapes that users give bodies; they are seen, and have no influence on the motion."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
