"""`Recursive`: equations of motion by recursions along one tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from symbody.arguments import checked_fields


@checked_fields
@dataclass(frozen=True, slots=True)
class Recursive:
    """Formulation by recursive Newton-Euler, composite and articulated bodies along one tree.

    Where the rotation tree is not the translation tree, or speeds are eliminated, virtual work takes its
    place, with a note.

    Attributes
    ----------
    method : str
        How accelerations of a tree without constraints are solved for: "articulated" bodies, the factors of
        the "composite" mass matrix, or "" for the one with fewer operations.
    aligned : bool
        Whether the axes of links are put along joints and common normals.
    regrouped : bool
        Whether the mass that a parent can carry as well is reckoned to it: base parameters.
    """

    method: Literal["", "articulated", "composite"] = ""
    aligned: bool = True
    regrouped: bool = True
