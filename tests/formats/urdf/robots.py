"""Small robots as text."""

from __future__ import annotations

LINK = (
    '<link name="{0}"><inertial><origin xyz="0 0 -0.25"/><mass value="2"/>'
    '<inertia ixx="0.3" iyy="0.4" izz="0.2" ixy="0.01" ixz="-0.02" iyz="0.03"/></inertial></link>'
)


def robot(*parts: str, name: str = "r") -> str:
    return "\n".join([f'<robot name="{name}">', *parts, "</robot>"])


def link(name: str) -> str:
    return LINK.format(name)


def joint(name: str, kind: str, parent: str, child: str, *inside: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{"".join(inside)}</joint>'


def arm(kind: str, *inside: str) -> str:
    """One link on a base by one joint."""
    return robot('<link name="base"/>', link("A"), joint("q", kind, "base", "A", *inside))
