"""Every formulation that symbody has, so that a new one is in all tests of formulations by itself."""

from __future__ import annotations

import re

from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.registry import formulation_types

FORMULATIONS: tuple[Formulation, ...] = tuple(each() for each in formulation_types().values())
# Those without a limit of their own, which mechanisms placed by hand have as well.
UNLIMITED = tuple(each for each in FORMULATIONS if type(each).obstacle is Formulation.obstacle)


def name_of(formulation: Formulation | None) -> str:
    """The name of a formulation, for labels of tests."""
    words = "" if formulation is None else type(formulation).__name__
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", words) or "automatic"
