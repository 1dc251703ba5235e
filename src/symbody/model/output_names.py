"""The grammar of outputs' names: which words begin them, and what stands behind each.

Whoever reads or rewrites the name of an output goes by these tables: the equations that make it, and parts
whose elements get other names.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.model.constraint import ConstraintElement
from symbody.model.constraints import Distance
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.loads.forces import SpringDamper
from symbody.model.loads.springs import Bushing, TorsionSpring

# Whole names: nothing follows them, and all of the mechanism is meant.
WHOLE_OUTPUTS: Final = frozenset(
    "udot qdot xdot signal_rates A B lambda mass_matrix forcing gravity_forcing bias inverse_dynamics "
    "kinetic_energy potential_energy energy power constraints velocity_constraints gamma jacobian "
    "position_jacobian position_residual position_move velocity_residual velocity_move friction_residual "
    "friction_margin friction_reserve mode_responses alignment".split()
)
_SPRINGS: Final = (SpringDamper, TorsionSpring, Bushing)
# First words, and the kinds of elements of which one follows; its coordinate or an entry may stand behind it.
ELEMENT_OUTPUTS: Final[Mapping[str, tuple[type[Element], ...]]] = MappingProxyType(
    {
        "reaction": (Joint, ConstraintElement),
        "effort": (Joint, *_SPRINGS),
        "length": _SPRINGS,
        "angle": _SPRINGS,
        **dict.fromkeys(("friction", "friction_normal", "friction_reserve"), (Joint,)),
        **dict.fromkeys(
            "rope_tension rope_length rope_slack rope_slack_dot rope_slack_ddot rope_size".split(),
            (Distance,),
        ),
    }
)
# The first word behind which a kind of motion and frames stand: END, REFERENCE and, but for R, RESOLVED_IN.
FRAME_OUTPUT: Final = "frame"
FRAME_KINDS: Final = ("r", "v", "vdot", "R", "w", "wdot")
# What may be differentiated by, beside symbols: all coordinates, speeds, inputs, states of signals.
DERIVATIVE_GROUPS: Final = ("q", "u", "r", "s")

_MULTIPLIER: Final = "lambda_"
_ROW: Final = re.compile(r"_(?:\d+|motion(?:_\d+)?|stick)")
_DERIVATIVE: Final = re.compile(
    r"d\s+(?P<output>.+?)\s*/\s*d\s*(?:\((?P<list>[^/]*)\)|(?P<one>[^/()]+))\s*", re.S
)


class DerivativeRequest(NamedTuple):
    """An output, the words it is differentiated by, and whether that is one symbol, which adds no axis."""

    output: str
    by: tuple[str, ...]
    alone: bool


class FrameRequest(NamedTuple):
    """A kind of motion, the frames it is between and resolved in, and the entry that is asked for."""

    kind: str
    frames: tuple[str, ...]
    entry: str


def parse_derivative(name: str) -> DerivativeRequest | None:
    """Return the request that a name like ``d udot/d q`` contains; None if it is not a derivative."""
    found = _DERIVATIVE.fullmatch(name.strip())
    if found is None:
        return None
    if found["one"] is not None:
        word = found["one"].strip()
        return DerivativeRequest(found["output"], (word,), word not in DERIVATIVE_GROUPS)
    return DerivativeRequest(found["output"], tuple(word.strip() for word in found["list"].split(",")), False)


def parse_frame(text: str, frames: Collection[str]) -> FrameRequest | None:
    """Return the request behind the word ``frame``; None if the number of words fits no motion.

    Parameters
    ----------
    frames : collection of str
        Known names of frames, which may contain blanks.
    """
    words = output_words(text, frames)
    most = 3 if words[:1] == ["R"] else 4
    is_entry = len(words) > 2 and set(words[-1]) <= set("xyz")
    entry = words.pop() if is_entry and (words[-1] not in frames or len(words) > most) else ""
    return FrameRequest(words[0], tuple(words[1:]), entry) if 2 <= len(words) <= most else None


def is_multiplier(name: str, elements: Iterable[str]) -> bool:
    """Return whether a name is that of a multiplier of one of some elements.

    >>> is_multiplier("lambda_rod_2", ["rod"]), is_multiplier("lambda_max", ["rod"])
    (True, False)
    """
    text = name.removeprefix(_MULTIPLIER)
    return text != name and any(
        text.startswith(element) and _ROW.fullmatch(text, len(element)) for element in elements
    )


def output_words(text: str, known: Iterable[str]) -> list[str]:
    """Return the words of a text: what is quoted, the longest known name, or all up to the next blank."""
    names = sorted(known, key=len, reverse=True)
    words = []
    rest = text.strip()
    while rest:
        if rest.startswith('"'):
            word, _, rest = rest[1:].partition('"')
        else:
            word = next((name for name in names if f"{rest} ".startswith(f"{name} ")), rest.split()[0])
            rest = rest[len(word) :]
        words.append(word)
        rest = rest.strip()
    return words
