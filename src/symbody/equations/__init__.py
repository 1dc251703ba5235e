"""Equations of motion: from a model and its trees to an EquationSet."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
