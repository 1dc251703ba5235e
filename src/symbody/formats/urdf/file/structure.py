"""Whether links and joints form a tree; in which order they hang."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symbody.errors import Problem, nearest
from symbody.formats.urdf.file.robot import UrdfJoint, UrdfLink


def tree_problems(where: str, links: Sequence[UrdfLink], joints: Sequence[UrdfJoint]) -> list[Problem]:
    """Return everything that keeps links and joints from being a tree."""
    problems = [*_duplicates(where, "link", links), *_duplicates(where, "joint", joints)]
    known = {link.name for link in links}
    for joint in joints:
        place = f"{where}:{joint.line}, joint {joint.name}"
        for word, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in known:
                what = f"there is no {word} link {name!r}"
                problems.append(Problem("urdf.unknown_link", place, what, "", nearest(name, known)))
        if joint.parent == joint.child:
            fact = f"parent and child are both {joint.child}"
            fix = "name another link at one end"
            problems.append(Problem("urdf.self_joint", place, fact, "a joint connects two links", fix))
    problems += _two_parents(where, joints)
    problems += _mimic_problems(where, joints)
    return problems or _root_problems(where, links, joints)


def find_root(links: Sequence[UrdfLink], joints: Iterable[UrdfJoint]) -> str:
    """Return the link of a tree that is not a child."""
    children = {joint.child for joint in joints}
    return next(link.name for link in links if link.name not in children)


def outward(joints: Iterable[UrdfJoint], root: str) -> list[UrdfJoint]:
    """Return the joints of a tree, each after the one that carries it, else in the order of the file."""
    below: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    found: list[UrdfJoint] = []
    waiting = list(reversed(below.get(root, [])))
    while waiting:
        joint = waiting.pop()
        found.append(joint)
        waiting.extend(reversed(below.get(joint.child, [])))
    return found


def _duplicates(where: str, kind: str, entries: Sequence[UrdfLink | UrdfJoint]) -> list[Problem]:
    lines: dict[str, list[int]] = {}
    for entry in entries:
        lines.setdefault(entry.name, []).append(entry.line)
    return [
        Problem("urdf.duplicate", f"{where}:{found[1]}, {kind} {name}",
                f"{len(found)} {kind}s are named {name!r}; the first is in line {found[0]}",
                "one would silently win", "rename all but one")
        for name, found in lines.items()
        if len(found) > 1
    ]  # fmt: skip


def _two_parents(where: str, joints: Sequence[UrdfJoint]) -> list[Problem]:
    carriers: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        carriers.setdefault(joint.child, []).append(joint)
    return [
        Problem("urdf.two_parents", f"{where}:{found[1].line}, joint {found[1].name}",
                f"link {name} is the child of {len(found)} joints: {', '.join(j.name for j in found)}",
                "URDF describes trees; loops are closed in a separate file",
                "delete one joint, and close the loop with load_urdf(.., loops=\"loops.toml\")")
        for name, found in carriers.items()
        if len(found) > 1
    ]  # fmt: skip


def _root_problems(where: str, links: Sequence[UrdfLink], joints: Sequence[UrdfJoint]) -> list[Problem]:
    """Return cycles, and roots beside the first, of links with at most one parent each."""
    children = {joint.child for joint in joints}
    roots = [link for link in links if link.name not in children]
    if len(roots) > 1:
        return [
            Problem("urdf.two_roots", f"{where}:{roots[1].line}, link {roots[1].name}",
                    f"{len(roots)} links are not the child of any joint: "
                    f"{', '.join(r.name for r in roots[:6])}",
                    "one of them is the root, the others are not connected to it",
                    f"add joints, for instance a fixed one from {roots[0].name} to {roots[1].name}")
        ]  # fmt: skip
    reached = set() if not roots else {joint.name for joint in outward(joints, roots[0].name)}
    lost = [joint for joint in joints if joint.name not in reached]
    if not lost:
        return []
    cycle = _cycle(lost)
    shown = " -> ".join(joint.child for joint in cycle[:8]) + (" ..." if len(cycle) > 8 else "")
    what = f"links form a cycle: {shown} -> {cycle[0].child}"
    why = "URDF describes trees"
    fix = "start one of the joints at another link"
    return [Problem("urdf.cycle", f"{where}:{cycle[0].line}, joint {cycle[0].name}", what, why, fix)]


def _cycle(lost: Sequence[UrdfJoint]) -> list[UrdfJoint]:
    """Return the joints of a circle, of joints none of which hangs on a root."""
    carrier = {joint.child: joint for joint in lost}
    seen: list[UrdfJoint] = []
    joint = lost[0]
    while joint not in seen:
        seen.append(joint)
        joint = carrier[joint.parent]
    return seen[seen.index(joint) :][::-1]


def _mimic_problems(where: str, joints: Sequence[UrdfJoint]) -> list[Problem]:
    by_name = {joint.name: joint for joint in joints}
    single = [joint.name for joint in joints if joint.kind in ("revolute", "continuous", "prismatic")]
    problems = []
    for joint in joints:
        place = f"{where}:{joint.line}, joint {joint.name}, mimic"
        seen = [joint.name]
        while joint.mimic is not None:
            leader = joint.mimic.leader
            if leader in seen:
                what = f"it follows itself: {' -> '.join([*seen, leader])}"
                fix = "let one of them follow a joint outside the cycle, or none"
                problems.append(Problem("urdf.mimic_cycle", place, what, "", fix))
                break
            if leader not in single:
                what = f"{leader!r} is not a joint with one coordinate"
                problems.append(Problem("urdf.mimic_unknown", place, what, "", nearest(leader, single)))
                break
            seen.append(leader)
            joint = by_name[leader]
    return problems
