"""That all engines compute the same of a robot, before anything is timed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, Final

import numpy as np

from benchmarks.robot_calls import TASKS, Compiled, InC, InCpp, InMujoco
from benchmarks.robot_states import Floats, States

# States at which engines are compared, and the largest difference that rounding explains: mass matrices of
# humanoids have conditions of 1e6 to 1e8.
COMPARED: Final = 100
ALLOWED: Final = 1e-6

# What deviates: by task, the largest difference of a state over its largest result.
Differences = dict[str, float]


def pinocchio_differences(ours: Compiled, cpp: InCpp | None) -> Differences:
    """Return how far symbody's results, and those of the program in C++, are from Pinocchio's in Python."""
    states = ours.states
    pin: Any = import_module("pinocchio")
    model = states.pin_model
    data = model.createData()
    expected: dict[str, list[list[Floats]]] = {name: [] for name in TASKS}
    for k in range(min(COMPARED, len(states.q))):
        q, v, tau, a = states.pin_q[k], states.pin_v[k], states.pin_tau[k], states.pin_a[k]
        expected["forward dynamics"].append([np.array(pin.aba(model, data, q, v, tau))])
        expected["inverse dynamics"].append([np.array(pin.rnea(model, data, q, v, a))])
        upper = np.triu(np.array(pin.crba(model, data, q)))
        expected["mass matrix"].append([upper + np.triu(upper, 1).T])
        pin.computeABADerivatives(model, data, q, v, tau)
        driven = np.array(data.Minv)[:, states.driven]
        expected["derivatives"].append([np.array(x) for x in (data.ddq, data.ddq_dq, data.ddq_dv)] + [driven])
    found = {
        name: largest(_in_order(ours, name), [np.array(x) for x in zip(*values, strict=True)])
        for name, values in expected.items()
    }
    if cpp is not None:
        aba, _ = cpp.results()
        count = len(expected["forward dynamics"])
        again = largest([aba[:count]], [np.array([x for (x,) in expected["forward dynamics"]])])
        found["forward dynamics"] = max(found["forward dynamics"], again)
    return found


def casadi_differences(ours: Compiled, peer: InC) -> Differences:
    """Return how far the results of CasADi's C are from symbody's."""
    found: Differences = {}
    for name, calls in peer.calls.items():
        own = [x[:COMPARED] for x in ours.results(name)]
        theirs = [calls.results(*(x[:COMPARED] for x in ours.inputs(name)))[k] for k in range(len(own))]
        found[name] = largest([x.reshape(len(x), -1) for x in own], theirs)
    return found


def mujoco_differences(ours: Compiled, peer: InMujoco) -> Differences:
    """Return how far MuJoCo's results are from symbody's, where both have the same axes."""
    calls, found = peer.calls, {}
    kept = [k for k in range(len(calls.order)) if k not in calls.turned]
    for name, inverse in (("forward dynamics", False), ("inverse dynamics", True)):
        own = ours.results(name)[0][:COMPARED][:, calls.order[kept]]
        theirs = np.array([calls.result(k, inverse)[kept] for k in range(len(own))])
        found[name] = largest([own], [theirs])
    return found


def largest(found: list[Floats], expected: list[Floats]) -> float:
    """Return the largest difference at a state, relative to its largest value; nan where one is nan."""
    worst = 0.0
    for one, other in zip(found, expected, strict=True):
        flat, reference = one.reshape(len(one), -1), other.reshape(len(other), -1)
        if reference.shape[1]:
            size = np.abs(reference).max(axis=1)
            worst = float(np.maximum(worst, (np.abs(flat - reference).max(axis=1) / size).max()))
    return worst


def wrong(differences: Mapping[str, float], who: str) -> Iterator[str]:
    """Yield a line for each task whose results differ by more than roundings."""
    for task, difference in differences.items():
        if not difference < ALLOWED:
            yield f"{who}, {task}: results differ by {difference:.0e}, so it is not timed"


def _in_order(ours: Compiled, name: str) -> list[Floats]:
    """Return symbody's results in Pinocchio's order and directions."""
    states, order = ours.states, ours.states.order
    found = [x[:COMPARED] for x in ours.results(name)]
    if name == "mass matrix":
        return [found[0][:, order][:, :, order]]
    if name != "derivatives":
        return [found[0][:, order]]
    udot, slopes = found
    n_q, n_u = states.q.shape[1], states.u.shape[1]
    by_q = np.einsum("kij,kjl->kil", slopes[:, order, :n_q], _tangents(states)[: len(slopes)])
    by_u = slopes[:, order, n_q : n_q + n_u][:, :, order]
    by_r = slopes[:, order, n_q + n_u :]
    return [udot[:, order], by_q, by_u, by_r]


def _tangents(states: States) -> Floats:
    """Return how coordinates change along Pinocchio's v, apart from shifts of the base: no u' reads them."""
    names, speeds = states.eqs.coordinate_names, states.eqs.speed_names
    found = np.zeros((len(states.q), len(names), len(speeds)))
    for column, speed in enumerate(speeds[k] for k in states.order):
        if speed.removesuffix("_dot") in names:
            found[:, names.index(speed.removesuffix("_dot")), column] = 1.0
        elif speed == "base_wx":
            rows = [names.index(f"base_{part}") for part in ("qw", "qx", "qy", "qz")]
            w, x, y, z = states.q[:, rows].T
            turns = 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
            for k, row in enumerate(rows):
                found[:, row, column : column + 3] = turns[k].T
    return found
