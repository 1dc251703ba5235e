"""Forward dynamics compiled by XLA: the JAX that `generate_code` writes, and MuJoCo's MJX.

MJX is made for thousands of states at once on a graphics card; this is what a single state costs.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import jax
import mujoco.mjx
import numpy as np

import symbody as sb
from benchmarks.robot_calls import spent
from benchmarks.robot_states import States

jax.config.update("jax_enable_x64", True)

# Calls by task, the number of states, and what preparing took [s].
Calls = tuple[Mapping[str, Callable[[int], Any]], int, Mapping[str, float]]

_TASK = "forward dynamics"


def ours(states: States) -> Calls:
    """Return the function that symbody writes."""
    start = spent()
    names: dict[str, Any] = {}
    exec(sb.generate_code(states.fresh(), "udot", "jax", parameters={}), names)
    return _compiled(lambda q, u, r: names["f"](0.0, q, u, r), (states.q, states.u, states.r), start)


def mjx(calls: Any) -> Calls:
    """Return MJX's forward dynamics of the model that MuJoCo has, without constraints and contacts."""
    start = spent()
    model, data = mujoco.mjx.put_model(calls.model), mujoco.mjx.make_data(calls.model)

    def accelerations(q: Any, v: Any, tau: Any) -> Any:
        return mujoco.mjx.forward(model, data.replace(qpos=q, qvel=v, qfrc_applied=tau)).qacc

    return _compiled(accelerations, (calls.q, calls.u, calls.tau), start)


def _compiled(f: Any, groups: tuple[Any, ...], start: float) -> Calls:
    compiled = jax.jit(f).lower(*(group[0] for group in groups)).compile()
    took = spent() - start
    a, b, c = ([jax.numpy.asarray(row) for row in group] for group in groups)
    return {_TASK: lambda k: np.asarray(compiled(a[k], b[k], c[k]))}, len(a), {_TASK: took}
