"""From a topology to its links: axes chosen, relative motions formed, masses reckoned to parents."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symbody.equations.kinematics.motion import Kinematics, Shifting, Turning, form_kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use, quasi_vector
from symbody.equations.recursive.axes import Placed, place_axes
from symbody.equations.recursive.links import GROUND, Column, Fixed, Link, RelativeMotion, Tree
from symbody.equations.recursive.placing import Hinge, Pose, hinges_and_groups
from symbody.equations.recursive.pseudo_inertia import PseudoInertia, added, empty, of_body
from symbody.equations.recursive.turned import Symmetric
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.graph.topology import Topology
from symbody.model.body import Body
from symbody.vectors.matrix import Triple, apply_matrix, identity, product, transpose
from symbody.vectors.rotation import EulerParameters, Turn
from symbody.vectors.vector import Vector, components, vector

# The two frames of a joint's own kinematics.
_NEAR, _FAR = "ground", "far"


def form_tree(
    topology: Topology, names: Names, rates: Mapping[int, int], uses: Sequence[Use], *, align: bool = True
) -> Tree:
    """Return the links of a mechanism whose rotation tree is its translation tree.

    Parameters
    ----------
    rates : mapping of node to node
        q' in terms of u.
    align : bool
        Whether axes are put along joints and common normals; else they are those of the joints' frames.
    """
    graph = names.graph
    hinges, groups = hinges_and_groups(topology, names, {use.joint.name: use for use in uses}, align)
    following: dict[str, list[Hinge]] = {}
    for hinge in hinges:
        following.setdefault(hinge.parent, []).append(hinge)
    zero = number(graph, 0)
    still = Pose(identity(graph), (zero, zero, zero))
    numbers, poses = {"ground": GROUND}, {"ground": still}
    links = []
    for hinge in hinges:
        group = hinge.branch.child
        placed = place_axes(hinge, poses[hinge.parent], following.get(group, ()))
        links.append(_link(names, rates, hinge, placed, numbers[hinge.parent], poses[hinge.parent]))
        numbers[group], poses[group] = len(links) - 1, placed.pose
    bodies = {}
    for body, (group, pose) in groups.items():
        here = poses[group].inverse.then(pose)
        bodies[body] = Fixed(numbers[group], here.axes, here.at)
    return Tree(_with_masses(names, topology.model.bodies, links, bodies), bodies)


def body_mass(names: Names, body: Body) -> PseudoInertia:
    """Return the mass distribution of a body about its center of mass, in its axes."""
    where = f"body {body.name}"
    moments, products = names.triple(body.inertia, where), names.triple(body.products, where)
    return of_body(Symmetric(*moments, *products), names.expression(body.mass, where))


def ground_mass(names: Names, bodies: Sequence[Body], tree: Tree) -> PseudoInertia:
    """Return the mass distribution of the bodies that are fixed to ground."""
    total = empty(names.graph)
    for body in bodies:
        place = tree.bodies[body.name]
        if place.link == GROUND:
            total = total.plus(body_mass(names, body).moved((place.axes,), place.at))
    return total


def regrouped(graph: Graph, tree: Tree) -> tuple[Tree, PseudoInertia]:
    """Return the same tree with all that a parent can carry reckoned to it, and what ground carries."""
    total = [link.inertia for link in tree.links]
    ground = empty(graph)
    for k in reversed(range(len(tree.links))):
        link = tree.links[k]
        total[k], moved = total[k].split(link.motion.turning, link.motion.sliding)
        moved = moved.moved(link.steps, link.arm)
        if link.parent == GROUND:
            ground = ground.plus(moved)
        else:
            total[link.parent] = total[link.parent].plus(moved)
    links = tuple(replace(link, inertia=kept) for link, kept in zip(tree.links, total, strict=True))
    return replace(tree, links=links), ground


def _with_masses(
    names: Names, bodies: Sequence[Body], links: Sequence[Link], places: Mapping[str, Fixed]
) -> tuple[Link, ...]:
    total = [link.inertia for link in links]
    for body in bodies:
        place = places[body.name]
        if place.link != GROUND:
            mass = body_mass(names, body).moved((place.axes,), place.at)
            total[place.link] = total[place.link].plus(mass)
    return tuple(replace(link, inertia=mass) for link, mass in zip(links, total, strict=True))


def _link(
    names: Names, rates: Mapping[int, int], hinge: Hinge, placed: Placed, index: int, parent: Pose
) -> Link:
    near = parent.inverse.then(hinge.near)
    axes = product(near.axes, placed.law)
    kinematics = _own_kinematics(names, rates, hinge, placed)
    x, y, z = components(kinematics.tree, kinematics.arm(_NEAR, _FAR), _NEAR)
    return Link(
        joint=hinge.use.joint.name,
        parent=index,
        steps=placed.steps,
        arm=added(near.at, apply_matrix(axes, (x, y, z + placed.slide))),
        motion=_motion(kinematics, hinge),
        inertia=empty(names.graph),
    )


def _own_kinematics(names: Names, rates: Mapping[int, int], hinge: Hinge, placed: Placed) -> Kinematics:
    """Return the kinematics of one joint alone, from near to far frame, in the axes of its law."""
    joint, forward = hinge.use.joint, hinge.branch.forward
    frames = {"start": _NEAR, "end": _FAR} if forward else {"start": _FAR, "end": _NEAR}
    sign, back = 1 if forward else -1, transpose(placed.law)

    def inside(frame: str, parts: Triple) -> Vector:
        return vector(frames[frame], apply_matrix(back, parts)) * sign

    steps: tuple[Turn | EulerParameters, ...] = hinge.steps
    if hinge.turning == "z":
        steps = tuple(Turn(_z(names.graph), step.angle) for step in steps if isinstance(step, Turn))
    turning, sliding = joint.rotation_speeds, joint.translation_speeds
    w = None if turning is None else inside(turning.resolved_in, quasi_vector(names, turning))
    shift = inside(joint.shift_in, names.triple(joint.shift(), f"joint {joint.name}"))
    v = None
    if sliding is not None:
        v = (frames["start"], inside(sliding.resolved_in, quasi_vector(names, sliding)))
    return form_kinematics(
        names.graph,
        [Turning(_FAR, _NEAR, steps, w)],
        [Shifting(_FAR, _NEAR, _FAR, shift, v)],
        rates,
        [names.graph.symbol(speed) for speed in hinge.use.speeds],
        spread=False,
    )


def _motion(kinematics: Kinematics, hinge: Hinge) -> RelativeMotion:
    w, v = kinematics.angular_velocities[_FAR], kinematics.velocities[_FAR]

    def here(a: Vector) -> Triple:
        return components(kinematics.tree, a, kinematics.tree.home(_FAR))

    columns = tuple(Column(u, here(w.partial(u)), here(v.partial(u))) for u in kinematics.speeds)
    return RelativeMotion(
        columns=columns,
        w=here(w.value),
        v=here(v.value),
        alpha=here(w.bias),
        a=here(v.bias),
        turning=hinge.turning,
        sliding=hinge.sliding,
    )


def _z(graph: Graph) -> Triple:
    zero: Expr = number(graph, 0)
    return (zero, zero, number(graph, 1))
