"""`Weld`: no freedom."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.declarations.element_fields import element
from symbody.model.declarations.joint_fields import TREE, TreeMembership
from symbody.model.joint import Joint


@final
@element
class Weld(Joint):
    """Holds two frames together.

    Examples
    --------
    >>> import symbody as sb
    >>> tool = sb.Body("Tool", mass="m")
    >>> weld = sb.Weld("flange", "Wrist", tool)
    """

    law: ClassVar[str] = "R = 1, d = 0"

    tree: TreeMembership = TREE
