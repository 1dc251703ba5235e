"""Bodies that strike each other at random: momentum stays, energy and work balance, losses are losses."""

from __future__ import annotations

import random

import numpy as np
import pytest

import symbody as sb
from symbody.model.contacts.contact_shapes import PAIRS
from tests.contacts.pairs import Floats

SHAPES = {"sphere": {"sphere": 0.2}, "capsule": {"capsule": (0.12, 0.3)}, "box": {"box": (0.3, 0.25, 0.35)}}
FAST, ALL = range(4), range(4, 30)


def scene(seed: int, *, shuffled: bool = False) -> sb.Model:
    """One to six bodies about the origin that fly towards it, up to ten contacts, a floor for some."""
    chance = random.Random(seed)
    count = chance.randint(1, 6)
    words = [chance.choice(sorted(SHAPES)) for _ in range(count)]
    bodies, initial = [], {}
    for k in range(count):
        bodies.append(sb.Body(f"B{k}", mass=chance.uniform(0.5, 2), inertia=(0.02, 0.025, 0.03)))
        at = np.array([0.5 * (k % 2), 0.5 * (k // 2 % 2), 0.55 * (k // 4)]) + 0.3
        for letter, place in zip("xyz", at, strict=True):
            initial[f"B{k}_{letter}"] = place
            initial[f"B{k}_v{letter}"] = (0.5 - place) * chance.uniform(2, 6)
            initial[f"B{k}_w{letter}"] = chance.uniform(-3, 3)
    law = sb.NormalForce(stiffness=1e5, exponent=chance.choice([1, 1.5]), dissipation=chance.choice([0, 0.3]))
    friction = chance.choice([None, sb.Friction(mu=0.4, v0=0.05)])
    pairs = [
        (j, k) for j in range(count) for k in range(j) if {(words[j], words[k]), (words[k], words[j])} & PAIRS
    ]
    contacts = [
        sb.Contact(f"C{j}{k}", bodies[j], bodies[k], [SHAPES[words[j]], SHAPES[words[k]]], normal=law,
                   friction=friction)
        for j, k in chance.sample(pairs, min(10, len(pairs)))
    ]  # fmt: skip
    if count < 3:
        contacts += [
            sb.Contact(
                f"F{k}", "ground", bodies[k], ["plane", SHAPES[words[k]]], normal=law, friction=friction
            )
            for k in range(count)
        ]
    parts = [*bodies, *contacts]
    if shuffled:
        parts.reverse()
    gravity = (0, 0, -9.81 if count < 3 else 0)
    return sb.Model("scene", parts, initial=initial, gravity=gravity)


def momenta(run: sb.Trajectory, model: sb.Model) -> Floats:
    """Momentum and angular momentum about the origin, (6, N)."""
    total = np.zeros((6, len(run.t)))
    for body in model.bodies:
        m, I = float(body.mass.text), np.diag([float(x.text) for x in body.inertia])
        r, v, w, R = (run[f"frame {kind} {body.name}"] for kind in ("r", "v", "w", "R"))
        total[:3] += m * v
        spin = np.einsum("ijn,jk,lkn,ln->in", R, I, R, w)
        total[3:] += np.cross(r, m * v, axis=0) + spin
    return total


@pytest.mark.parametrize("seed", [*FAST, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in ALL)])
def test_laws_hold_on_random_scenes(seed: int) -> None:
    model = scene(seed)
    run = sb.simulate(sb.form_equations(model), 0.3, times=np.linspace(0, 0.3, 61), rtol=1e-9)
    assert run.status is sb.Status.SUCCESS
    gaps = np.array([run[f"gap {each.name}"] for each in model.elements if isinstance(each, sb.Contact)])
    scale = run["kinetic_energy"].max()
    assert np.ptp(run["energy"] - run["work"]) < 1e-5 * scale
    assert np.diff(run["work"]).max() < 1e-7 * scale and run["power"].max() < 1e-5 * scale
    if len(model.bodies) > 2:
        found = momenta(run, model)
        size = np.abs(found).max()
        np.testing.assert_allclose(found, np.repeat(found[:, :1], 61, axis=1), atol=1e-7 * size)
    assert gaps.min() < 0


@pytest.mark.parametrize("seed", [3, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in range(5, 10))])
def test_the_order_of_bodies_and_contacts_means_nothing(seed: int) -> None:
    one, two = (sb.form_equations(scene(seed, shuffled=shuffled)) for shuffled in (False, True))
    first, second = (sb.simulate(eqs, 0.1, times=[0, 0.1], rtol=1e-10) for eqs in (one, two))
    for name in one.coordinate_names:
        assert second[name][-1] == pytest.approx(first[name][-1], abs=1e-7)
