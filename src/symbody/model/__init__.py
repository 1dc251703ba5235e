"""The mechanism as data: bodies, joints and forces with names, formulas and places; nothing is computed.

A script builds the same values that a model file does:

>>> from symbody.model import Body, Drive, Model, Prismatic
>>> mass = Body("Mass", mass="m")
>>> slider = Prismatic("slider", "ground", mass, axis="x", coordinate="x", force=Drive(stiffness="k"))
>>> Model("oscillator", [slider], parameters={"m": 1, "k": "4*m"}).coordinates
('x',)
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
