"""What to write for an output that names a frame in the words of everyday: ``"position hand"``."""

from __future__ import annotations

from collections.abc import Collection
from types import MappingProxyType
from typing import Final

from symbody.errors import nearest
from symbody.model.output_names import MOTION_WORDS

_KINDS: Final = MappingProxyType({word: kind for kind, words in MOTION_WORDS.items() for word in words})


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
