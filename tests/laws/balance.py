"""Laws: Newton and Euler for every body and for the whole, with loads computed by NumPy; energy by power."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import symbody as sb
from symbody.expr.calculus import gradient
from symbody.expr.graph import TIME
from symbody.expr.sequences.sequence import Roots
from tests.laws.agreement import SYSTEM
from tests.laws.consistent_states import State
from tests.laws.contact_wrenches import contact_errors, contact_outputs, coupled_efforts, wrench_on_end
from tests.laws.evaluation import EPS, arguments, condition, evaluator, values_at
from tests.laws.joint_laws import effort_wrench
from tests.laws.motion import frame_place
from tests.laws.parts import ContactPart, JointPart, Mechanism, law_value
from tests.laws.rotations import Array, unit

# Body or ground to force and torque about its centre of mass (ground: origin), in ground axes.
Wrenches = dict[str, tuple[Array, Array]]


def add(
    wrenches: Wrenches, state: State, body: str, force: Array, torque: Array, point: Array | None = None
) -> None:
    """Add a force in a point (the centre of mass by default) and a torque on a body."""
    old_force, old_torque = wrenches.get(body, (np.zeros(3), np.zeros(3)))
    arm = np.zeros(3) if point is None else point - state.places[body][0]
    wrenches[body] = (old_force + force, old_torque + torque + np.cross(arm, force))


def applied(mechanism: Mechanism, state: State) -> Wrenches:
    """Gravity, springs, forces and torques; not what acts in joints."""
    found: Wrenches = {}
    zero = np.zeros(3)
    for body in mechanism.bodies:
        add(found, state, body.name, body.mass * np.array(mechanism.gravity), zero)
    for spring in mechanism.springs:
        (a, v_a), (b, v_b) = (_point(mechanism, state, address) for address in (spring.start, spring.end))
        arm = b - a
        length = float(np.linalg.norm(arm))
        rate = float((v_b - v_a) @ arm) / length
        push = (
            law_value(spring.applied, state.known)
            - spring.stiffness * (length - spring.free)
            - spring.damping * rate
        )
        add(found, state, spring.end.partition(".")[0], push * arm / length, zero, b)
        add(found, state, spring.start.partition(".")[0], -push * arm / length, zero, a)
    for load in mechanism.loads:
        axes = frame_place(mechanism, state.places, load.resolved_in)[1]
        vector = axes @ np.array([law_value(law, state.known) for law in load.vector])
        point = _point(mechanism, state, load.on)[0]
        for target, sign in ((load.on.partition(".")[0], 1), (load.reaction_on, -1)):
            if load.is_force:
                add(found, state, target, sign * vector, zero, point)
            else:
                add(found, state, target, zero, sign * vector)
    return found


def _point(mechanism: Mechanism, state: State, address: str) -> tuple[Array, Array]:
    """Place and velocity of a frame's origin."""
    body = address.partition(".")[0]
    r = frame_place(mechanism, state.places, address)[0]
    v, w = state.twists[body]
    return r, v + np.cross(w, r - state.places[body][0])


def effort_outputs(mechanism: Mechanism) -> dict[tuple[str, str], str]:
    """The output of the effort along each driven or prescribed coordinate."""
    return {
        (joint.name, name): f"effort {joint.name}" + (f" {name}" if len(joint.names) > 1 else "")
        for joint in mechanism.joints
        for name in joint.names
        if name in joint.drives or name in joint.motions
    }


def balance_errors(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> dict[str, float]:
    """What is left of Newton's and Euler's law for each body and the whole, in units of eps cond scale."""
    efforts = effort_outputs(mechanism)
    motion = {
        body.name: [f"frame {kind} {body.name} ground ground" for kind in ("vdot", "wdot")]
        for body in mechanism.bodies
    }
    outputs = [*SYSTEM, *(f"reaction {joint.name}" for joint in mechanism.joints), *efforts.values()]
    outputs += contact_outputs(mechanism)
    found = values_at(eqs, state, [*outputs, *(output for pair in motion.values() for output in pair)])
    accelerations = {name: (found[pair[0]], found[pair[1]]) for name, pair in motion.items()}
    wrenches = applied(mechanism, state)
    size = _size(mechanism, wrenches)
    coupled = coupled_efforts(mechanism, eqs, state, found)
    for joint in mechanism.joints:
        along = {name: float(found[word]) for (owner, name), word in efforts.items() if owner == joint.name}
        if joint.armature:
            name = joint.names[0]
            rotor = joint.armature * second_rate(mechanism, state, joint, accelerations)
            along[name] = along.get(name, 0.0) - rotor
        along |= {name: along.get(name, 0.0) + coupled[name] for name in joint.names if name in coupled}
        size = max(
            size, _add_joint(mechanism, state, wrenches, joint, found[f"reaction {joint.name}"], along)
        )
    errors: dict[str, float] = {}
    for contact in mechanism.contacts:
        size = max(size, _add_contact(mechanism, state, wrenches, contact, found))
        own = contact_errors(mechanism, state, contact, found)
        errors |= {law: error / (EPS * condition(found).number) for law, error in own.items()}
    least = EPS * condition(found).number * size
    return errors | _left_over(mechanism, state, wrenches, accelerations, least)


def _left_over(
    mechanism: Mechanism,
    state: State,
    wrenches: Wrenches,
    accelerations: dict[str, tuple[Array, Array]],
    unit: float,
) -> dict[str, float]:
    length = mechanism.units.length
    errors: dict[str, float] = {}
    whole = np.zeros((2, 3))
    for body in mechanism.bodies:
        vdot, wdot = accelerations[body.name]
        force, torque = wrenches[body.name]
        r, axes = state.places[body.name]
        tensor = axes @ body.tensor @ axes.T
        w = state.twists[body.name][1]
        momentum, spin = body.mass * vdot, tensor @ wdot + np.cross(w, tensor @ w)
        errors[f"force on {body.name}"] = float(np.abs(momentum - force).max() / unit)
        errors[f"torque on {body.name}"] = float(np.abs(spin - torque).max() / (unit * length))
        whole += [momentum, spin + np.cross(r, momentum)]
    # What acts between bodies cancels: the whole is moved by gravity and by what ground gives.
    force, torque = wrenches.get("ground", (np.zeros(3), np.zeros(3)))
    gravity = np.array(mechanism.gravity)
    weight = sum((body.mass for body in mechanism.bodies), 0.0) * gravity
    lever = sum((np.cross(state.places[b.name][0], b.mass * gravity) for b in mechanism.bodies), np.zeros(3))
    reach = max(length, *(float(np.linalg.norm(state.places[b.name][0])) for b in mechanism.bodies))
    errors["momentum"] = float(np.abs(whole[0] - weight + force).max() / unit)
    errors["angular momentum"] = float(np.abs(whole[1] - lever + torque).max() / (unit * reach))
    return errors


def second_rate(
    mechanism: Mechanism, state: State, joint: JointPart, accelerations: dict[str, tuple[Array, Array]]
) -> float:
    """The second rate of a revolute or prismatic coordinate, from the accelerations of its two bodies."""
    (r_s, v_s, a_s, w_s, e_s), (r_e, v_e, a_e, w_e, e_e) = (
        _moving(mechanism, state, address, accelerations) for address in (joint.start, joint.end)
    )
    axis = frame_place(mechanism, state.places, joint.start)[1] @ unit(joint.axis)
    if joint.kind == "revolute":
        return float(axis @ (e_e - e_s))
    arm, slide = r_e - r_s, v_e - v_s
    relative = a_e - a_s - np.cross(e_s, arm) - np.cross(w_s, np.cross(w_s, arm))
    return float(axis @ (relative - 2 * np.cross(w_s, slide - np.cross(w_s, arm))))


def _moving(
    mechanism: Mechanism, state: State, address: str, accelerations: dict[str, tuple[Array, Array]]
) -> tuple[Array, Array, Array, Array, Array]:
    """Place, velocity and acceleration of a frame's origin; angular velocity and acceleration."""
    body = address.partition(".")[0]
    r, v = _point(mechanism, state, address)
    w = state.twists[body][1]
    vdot, wdot = accelerations.get(body, (np.zeros(3), np.zeros(3)))
    arm = r - state.places[body][0]
    return r, v, vdot + np.cross(wdot, arm) + np.cross(w, np.cross(w, arm)), w, wdot


def _size(mechanism: Mechanism, wrenches: Wrenches) -> float:
    """The largest force; torques count by the unit of length."""
    least = max(body.mass for body in mechanism.bodies) * mechanism.units.acceleration
    length = mechanism.units.length
    return max(least, *(float(max(np.abs(f).max(), np.abs(t).max() / length)) for f, t in wrenches.values()))


def _add_joint(
    mechanism: Mechanism,
    state: State,
    wrenches: Wrenches,
    joint: JointPart,
    reaction: Array,
    efforts: dict[str, float],
) -> float:
    """Add what a joint does to its two bodies, and return the size of it."""
    axes = frame_place(mechanism, state.places, joint.start)[1]
    point = frame_place(mechanism, state.places, joint.end)[0]
    force, moment = effort_wrench(joint, efforts)
    force, moment = axes @ (force + reaction[:3]), axes @ (moment + reaction[3:])
    for address, sign in ((joint.end, 1), (joint.start, -1)):
        add(wrenches, state, address.partition(".")[0], sign * force, sign * moment, point)
    return float(max(np.abs(force).max(), np.abs(moment).max() / mechanism.units.length))


def _add_contact(
    mechanism: Mechanism,
    state: State,
    wrenches: Wrenches,
    contact: ContactPart,
    found: Mapping[str, Array],
) -> float:
    """Add what a contact does to its two bodies, and return the size of it."""
    force, moment = wrench_on_end(mechanism, state, contact, found)
    point = frame_place(mechanism, state.places, contact.end)[0]
    for address, sign in ((contact.end, 1), (contact.start, -1)):
        add(wrenches, state, address.partition(".")[0], sign * force, sign * moment, point)
    return float(max(np.abs(force).max(), np.abs(moment).max() / mechanism.units.length))


def energy_error(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> float:
    """The difference of the energy's rate and the power, in units of eps cond scale.

    The rate is the total derivative along q' and u', with partial derivatives from the graph; the scale is the
    sum of its terms' sizes.
    """
    graph = eqs.formed.graph
    names = eqs.formed.names
    by = [names.value(name).index for name in (*eqs.coordinate_names, *eqs.speed_names)] + [
        graph.symbol(TIME)
    ]
    slopes = gradient(graph, eqs.roots("energy").nodes[0], by)
    roots = Roots("slopes", (len(by),), tuple(slopes))
    found = evaluator(eqs, [*SYSTEM, "qdot", "power", "kinetic_energy", roots])(*arguments(eqs, state))
    rates = np.concatenate([found["qdot"], found["udot"], [1.0]])
    terms = found["slopes"] * rates
    least = max(body.mass for body in mechanism.bodies) * mechanism.units.length**2 / mechanism.units.time**3
    scale = max(float(np.abs(terms).sum()), abs(float(found["power"])), least)
    return float(abs(terms.sum() - found["power"]) / (EPS * condition(found).number * scale))
