"""Facts about how elements hang together, beyond single values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Final

from symbody.errors import Problem
from symbody.model.body import Body
from symbody.model.constraint import ConstraintElement
from symbody.model.constraints.couplings import Gear, JointCoupling, Stop
from symbody.model.contacts.contact import Contact
from symbody.model.declarations.element_fields import Connection
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.joints.orientation import Free
from symbody.model.naming import GROUND

# Elements whose names are symbols, and unique among these.
AMONG_SYMBOLS: Final = ("signal", "block")
_POINT_OF_CONTACT: Final = re.compile(r"(.+?)(?: friction| friction \d+| \d+)")


def collect_constraints(elements: Iterable[Element]) -> Iterator[ConstraintElement | Contact]:
    """Yield what makes equations: constraints, rigid contacts, and rigid limits and play as stops."""
    for element in elements:
        yield from _stops(element)
        if isinstance(element, ConstraintElement) and not (isinstance(element, Gear) and element.backlash):
            yield element
        elif isinstance(element, Contact) and element.is_rigid:
            yield element


def _stops(element: Element) -> tuple[Stop, ...]:
    return element.stops if isinstance(element, Joint | Gear) else ()


def duplicate_elements(elements: Sequence[Element], labels: Mapping[int, str]) -> list[Problem]:
    """Return a problem for each name that several elements have."""
    sites: dict[str, list[int]] = {}
    for k, element in enumerate(elements):
        if element.kind not in AMONG_SYMBOLS:
            for each in (element, *_stops(element)):
                sites.setdefault(each.name, []).append(k)
    rigid = {each.name for each in elements if isinstance(each, Contact) and each.is_rigid}
    points = [
        Problem(
            "names.duplicate",
            f"{labels[places[0]]}, name",
            f"{name!r} is also what a point of contact {point[1]} is called",
            "the points of a rigid contact and the friction in them are named after it",
            "rename one of the two",
        )
        for name, places in sites.items()
        if (point := _POINT_OF_CONTACT.fullmatch(name)) and point[1] in rigid
    ]
    return points + [
        Problem(
            "names.duplicate",
            "; ".join(f"{labels[k]}, name" for k in places),
            f"{len(places)} elements are named {name!r}",
            "bodies, joints, forces and the ends of limits share one set of names",
            "rename all but one",
        )
        for name, places in sites.items()
        if len(places) > 1
    ]


def one_body_problems(connections: Mapping[str, Connection]) -> list[Problem]:
    """Return the connections, given by label, whose two ends are on one body and must not be."""
    return [
        Problem(code, f"{label}, between", what.format(value=connection.start.body), why, fix)
        for label, connection in connections.items()
        if connection.start.body == connection.end.body
        for code, what, fix, why in filter(None, [connection.on_one_body])
    ]


def coupling_problems(couplings: Mapping[str, JointCoupling], joints: Iterable[Joint]) -> list[Problem]:
    """Return a problem for each coupled coordinate that is not the angle or displacement it has to be."""
    listed = list(joints)
    known = {name for joint in listed for name in joint.coordinates}
    angles = {name for joint in listed for name in joint.angle_coordinates}
    lengths = {name for joint in listed for name in joint.translation_coordinates} - angles
    problems = []
    for label, coupling in couplings.items():
        for k, name in enumerate(coupling.coupled):
            is_angle = k >= coupling.displacements
            if name in known and name not in (angles if is_angle else lengths):
                quantity, article = ("angle", "an") if is_angle else ("displacement", "a")
                problems.append(
                    Problem(
                        "model.not_an_angle" if is_angle else "model.not_a_displacement",
                        f"{label}, coupled[{k}]",
                        f"{name} is not {article} {quantity}",
                        "the other values of this constraint would have different units",
                        f'name the {quantity} of a joint, or write type = "equation"',
                    )
                )
    return problems


def floating_problems(bodies: Iterable[Body], joints: Iterable[Joint]) -> list[Problem]:
    """Return a problem for each group of bodies joined to each other and not to ground.

    A single body without any joint is free, and no problem.
    """
    group = {GROUND: GROUND} | {body.name: body.name for body in bodies}
    for joint in joints:
        low, high = _root(group, joint.start.body), _root(group, joint.end.body)
        group[high if low == GROUND else low] = low if low == GROUND else high
    members: dict[str, list[str]] = {}
    for name in group:
        members.setdefault(_root(group, name), []).append(name)
    return [
        Problem(
            "model.no_ground",
            f"body {names[0]}",
            f"no chain of joints connects ground to {', '.join(names[:8])}{' ...' * (len(names) > 8)}",
            "these bodies are connected only to each other",
            f'add a joint with between = ["ground", "{names[0]}"]; use a free joint if they float',
        )
        for root, names in members.items()
        if root != GROUND and len(names) > 1
    ]


def over_driven_problems(joints: Mapping[str, Joint]) -> list[Problem]:
    """Return a problem for each loop, of joints given by label, whose every joint is driven."""
    held = {
        label: joint
        for label, joint in joints.items()
        if joint.motions and joint.motions.keys() >= set(joint.coordinates)
    }
    group = {address.body: address.body for joint in held.values() for address in (joint.start, joint.end)}
    forest: dict[str, Joint] = {}
    problems = []
    for label, joint in held.items():
        low, high = _root(group, joint.start.body), _root(group, joint.end.body)
        group[high] = low
        if low != high:
            forest[label] = joint
            continue
        around = {label, *_tree_path(forest, joint.start.body, joint.end.body)}
        problems.append(
            _over_driven_problem({place: other for place, other in held.items() if place in around})
        )
    return problems


def free_joints(bodies: Iterable[Body], joints: Iterable[Joint]) -> list[Joint]:
    """Return for each body without any joint the free joint that stands for its motion.

    It bears the body's name and leads from ground, with a quaternion.
    """
    joined = {address.body for joint in joints for address in (joint.start, joint.end)}
    names = dict.fromkeys(body.name for body in bodies)  # two of one name are told elsewhere
    return [Free(name, GROUND, name) for name in names if name not in joined]


def _tree_path(forest: Mapping[str, Joint], start: str, end: str) -> list[str]:
    """Return the labels of the joints on the way between two bodies of one tree."""
    near: dict[str, list[tuple[str, str]]] = {}
    for label, joint in forest.items():
        for here, there in ((joint.start.body, joint.end.body), (joint.end.body, joint.start.body)):
            near.setdefault(here, []).append((label, there))
    come: dict[str, tuple[str, str]] = {start: ("", "")}
    waiting = [start]
    for body in waiting:
        for label, there in near.get(body, ()):
            if there not in come:
                come[there] = (label, body)
                waiting.append(there)
    way = []
    while end != start:
        label, end = come[end]
        way.append(label)
    return way


def _over_driven_problem(loop: Mapping[str, Joint]) -> Problem:
    return Problem(
        "model.over_driven",
        "; ".join(
            f"{label}, {joint.coordinate_path('motion', next(iter(joint.motions)))}"
            for label, joint in loop.items()
        ),
        f"no joint of the loop {', '.join(joint.name for joint in loop.values())} is left free",
        "a loop relates its coordinates to each other, so these motions contradict or repeat each other",
        "remove motion from some of them: a loop can be driven in as many coordinates as it has degrees of "
        "freedom",
    )


def _root(group: dict[str, str], name: str) -> str:
    while group[name] != name:
        group[name] = group[group[name]]
        name = group[name]
    return name
