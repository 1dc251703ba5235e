"""`Weld`: no freedom."""

from __future__ import annotations

from typing import ClassVar, final

from symbody.model.element_fields import element
from symbody.model.joint import Joint
from symbody.model.joint_fields import TREE, TreeMembership


@final
@element
class Weld(Joint):
    """Holds two frames together."""

    law: ClassVar[str] = "R = 1, d = 0"

    tree: TreeMembership = TREE
