"""Accelerations of many free bodies are as exact as those of recursions: elimination alone leaves 600 roundings."""

from __future__ import annotations

import numpy as np

import symbody as sb


def branched_tree(count: int) -> sb.Model:
    """Links of 0.2 m, two on the tip of each, about axes in turn, under PD laws."""
    elements: list[object] = []
    for k in range(count):
        frames = {"near": sb.Frame(at=(-0.1, 0, 0)), "tip": sb.Frame(at=(0.1, 0, 0))}
        elements.append(sb.Body(f"B{k}", mass=1, inertia=(0.02, 0.01, 0.015), frames=frames))
        law = sb.Drive(f"20*({3 * (k % 3 + 1)}/10 - q{k}) - q{k}_dot")
        start = f"B{(k - 1) // 2}.tip" if k else "ground"
        elements.append(
            sb.Revolute(f"J{k}", start, f"B{k}.near", axis="zyx"[k % 3], coordinate=f"q{k}", torque=law)
        )
    return sb.Model("tree", elements, gravity=(0, 0, "-9.81"))


def test_free_bodies_are_solved_for_to_rounding() -> None:
    """Seventy-two rows; accelerations agree to some roundings for each of twelve bodies."""
    model, random = branched_tree(12), np.random.default_rng(0)
    recursive, free = (
        sb.compile(sb.form_equations(model, one), "udot") for one in (sb.Recursive(), sb.NewtonEuler())
    )
    for size in (0.01, 0.5):
        q, u = size * random.normal(size=(2, 12))
        exact = recursive(0.0, q, u)
        assert np.abs(free(0.0, q, u) - exact).max() < 12 * 4 * 2.2e-16 * np.abs(exact).max()
