"""Names of a model as identifiers of Modelica, between quotes where the language needs them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from symbody.codegen.identifiers import assign_identifiers

# Keywords of Modelica 3.6, section 2.3.3, then operators, functions and types that the language brings.
RESERVED: Final = frozenset(
    """
    algorithm and annotation block break class connect connector constant constrainedby der discrete
    each else elseif elsewhen encapsulated end enumeration equation expandable extends external false
    final flow for function if import impure in initial inner input loop model not operator or outer
    output package parameter partial protected public pure record redeclare replaceable return stream
    then true type when while within

    abs acos actualStream array asin assert atan atan2 backSample cardinality cat ceil change cos cosh
    cross delay diagonal div edge exp fill floor getInstanceName homotopy identity inStream integer
    interval inverse linspace log log10 matrix max min mod ndims noClock noEvent ones outerProduct pre
    previous product promote reinit rem rooted sample scalar semiLinear shiftSample sign sin sinh size
    skew smooth spatialDistribution sqrt String subSample sum superSample symmetric tan tanh terminal
    terminate time transpose vector zeros hold firstTick initialState transition activeState
    ticksInState timeInState

    Boolean Clock Complex Connections ExternalObject Integer Real StateSelect AssertionLevel
    """.split()
)

_PLAIN: Final = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_QUOTABLE: Final = re.compile(r"[A-Za-z_0-9!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]+")


def quoted_names(names: Iterable[str]) -> list[str]:
    """Return an identifier for each name, in order: the name itself, between quotes where it has to be.

    Names with letters that Modelica does not have take the nearest legal spelling. The result differs from
    name to name, also where a tool drops the quotes.

    >>> quoted_names(["theta", "der", "reaction B Fx", "θ₁"])
    ['theta', "'der'", "'reaction B Fx'", 'theta1']
    """
    wanted = list(names)
    taken = {name for name in wanted if _QUOTABLE.fullmatch(name)}
    others = [name for name in wanted if name not in taken]
    spelled = dict(zip(others, assign_identifiers(others, lambda word: word in taken), strict=True))
    return [_quote(spelled.get(name, name)) for name in wanted]


def _quote(name: str) -> str:
    return name if _PLAIN.fullmatch(name) and name not in RESERVED else f"'{name}'"
