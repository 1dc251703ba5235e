"""Functional mock-up units: mechanisms in other tools, with exact derivatives."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
