"""What to write for a text that names no output: one in the words of everyday, or one without quotes."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from types import MappingProxyType
from typing import Final

from symbody.errors import nearest
from symbody.model.output_names import FRAME_OUTPUT, MOTION_WORDS

_KINDS: Final = MappingProxyType({word: kind for kind, words in MOTION_WORDS.items() for word in words})
_FRAME: Final = rf"{FRAME_OUTPUT} (?:{'|'.join(MOTION_WORDS)})(?: [^\W\d][\w.]*){{1,4}}"


def frame_cure(name: str, frames: Collection[str]) -> str:
    """Return the output of a frame's motion that was probably meant, or ``""``.

    Parameters
    ----------
    frames : collection of str
        Bodies and frames as outputs name them: ``"Arm"``, ``"Arm.tip"``.

    >>> frame_cure("position tip", ["ground", "Arm", "Arm.tip"])
    "did you mean 'frame r Arm.tip'?"
    """
    if place := _full_name(name, frames):
        return f"did you mean 'frame r {place}'?"
    words = name.split()
    for count in (2, 1):
        kind, rest = _KINDS.get(" ".join(words[:count])), " ".join(words[count:])
        if kind is None or not rest:
            continue
        place = _full_name(rest, frames)
        if place:
            return f"did you mean 'frame {kind} {place}'?"
        return f"write 'frame {kind} END' with a body or frame for END: {nearest(rest, frames)}"
    return ""


def _full_name(name: str, frames: Collection[str]) -> str:
    """Return the frame of this name, with its body in front; empty if there is none or more than one."""
    if name in frames:
        return name
    ending = [frame for frame in frames if frame.endswith(f".{name}")]
    return ending[0] if len(ending) == 1 else ""


def quotation_cure(text: str, outputs: Iterable[str]) -> str:
    """Return what to type where outputs inside a formula lack their quotes; empty where none do.

    >>> quotation_cure("2*reaction A Fx", ["reaction A", "reaction A Fx"])
    "inside a formula, write outputs in single quotes: 2*'reaction A Fx'"
    >>> quotation_cure("[reaction A Fx]^2", ["reaction A", "reaction A Fx"])
    "inside a formula, write outputs in single quotes: 'reaction A Fx'^2"
    """
    if re.search(r"[-+*/^(<>,]", text) is None:
        return ""
    names = sorted((name for name in outputs if " " in name), key=len, reverse=True)
    words = "|".join([*map(re.escape, names), _FRAME])
    bare = rf"(?<![\w'])(?:\"({words})\"|\[({words})\]|({words}))(?![\w'])"
    quoted = re.sub(bare, lambda found: f"'{found[1] or found[2] or found[3]}'", text)
    return "" if quoted == text else f"inside a formula, write outputs in single quotes: {quoted}"
