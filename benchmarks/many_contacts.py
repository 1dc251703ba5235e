"""Balls that fall into a pit of four planes: one step of `MoreauJean` beside one of MuJoCo.

A heap of balls has no motion that two programs could agree on, so that work stands beside what a step leaves
undone: how far shapes overlap, and of ours by how much impulses miss their laws. MuJoCo's contacts are soft,
and as stiff as its steps allow; it looks for pairs that are near, symbody measures all.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from time import process_time
from typing import Any, Final

import numpy as np

import symbody as sb
from benchmarks.contact_problems import GRAVITY
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, processor_seconds

RADIUS: Final = 0.1  # m
MU: Final = 0.3
STEP: Final = 2e-3  # s
END: Final = 1.5  # s
SLOPE: Final = 0.5  # rad, of the planes
TOLERANCES: Final = (1e-3, 1e-6)
COUNTS: Final = (8, 27)
MANY: Final = (64,)  # minutes to form and compile


def places(count: int) -> list[tuple[float, float, float]]:
    """Return where the balls begin: in a cube above the pit, not quite regularly [m]."""
    side, chance = int(np.ceil(count ** (1 / 3) - 1e-9)), random.Random(1)
    found = []
    for k in range(count):
        across = [(i - (side - 1) / 2) * 2.3 * RADIUS for i in (k % side, k // side % side)]
        height = 2.3 * RADIUS * (1 + k // side**2) + 0.6 * (side - 1) * RADIUS
        x, y, z = (value + chance.uniform(-0.005, 0.005) for value in (*across, height))
        found.append((x, y, z))
    return found


def pit_model(count: int) -> sb.Model:
    """Return the balls and the pit."""
    parts: list[Any] = []
    initial: dict[str, float] = {}
    turns = {"e": ("y", -SLOPE), "w": ("y", SLOPE), "n": ("x", SLOPE), "s": ("x", -SLOPE)}
    friction, sphere = sb.Friction(mu=MU), {"sphere": RADIUS}
    for k, place in enumerate(places(count)):
        parts.append(sb.Free(f"m{k}", "ground", sb.Body(f"Ball{k}", mass=1, inertia=(0.4 * RADIUS**2,) * 3)))
        initial |= {f"m{k}_{letter}": x for letter, x in zip("xyz", place, strict=True)}
    for side in turns:
        shapes: list[Any] = ["plane", sphere]
        parts.append(
            sb.Contact(f"wall_{side}", f"ground.{side}", "Ball*", shapes, normal="rigid", friction=friction)
        )
    pair: list[Any] = [sphere, sphere]
    parts.append(sb.Contact("pair", "Ball*", "Ball*", pair, normal="rigid", friction=friction))
    frames = {side: sb.Frame(rotate=[turn]) for side, turn in turns.items()}
    return sb.Model("pit", parts, gravity=(0, 0, -GRAVITY), ground=frames, initial=initial)


def pit_scene(count: int) -> str:
    """Return the same in MuJoCo's XML, its contacts as stiff as its steps allow."""
    turns = {(0, -SLOPE, 0), (0, SLOPE, 0), (SLOPE, 0, 0), (-SLOPE, 0, 0)}
    rubs = f'friction="{MU}" condim="3" solref="{2 * STEP} 1"'
    walls = "".join(
        f'<geom type="plane" size="0 0 1" euler="{a} {b} {c}" {rubs}/>' for a, b, c in sorted(turns)
    )
    balls = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom type="sphere" size="{RADIUS}" mass="1" {rubs}/></body>'
        for x, y, z in places(count)
    )
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 {-GRAVITY}" timestep="{STEP}"/>'
        f"<worldbody>{walls}{balls}</worldbody></mujoco>"
    )


def peer(count: int) -> tuple[float, float]:
    """Return MuJoCo's time of a step, and by how much shapes overlap at most in the last quarter [s, m]."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(pit_scene(count))
    data = mujoco.MjData(model)
    steps, deepest = round(END / STEP), 0.0
    mujoco.mj_step(model, data)

    def go() -> None:
        for _ in range(steps):
            mujoco.mj_step(model, data)

    seconds = processor_seconds(go)
    for _ in range(steps // 4):
        mujoco.mj_step(model, data)
        deepest = max(deepest, -float(np.min(data.contact.dist, initial=0.0)))
    return seconds / steps, deepest


def rows_of(count: int) -> Iterator[tuple[str, ...]]:
    """Yield the rows of a table for so many balls."""
    theirs = peer(count) if find_spec("mujoco") is not None else None
    made: list[sb.EquationSet] = []
    forming = processor_seconds(lambda: made.append(sb.form_equations(pit_model(count))))
    (eqs,) = made
    word = str(count)
    for tolerance in TOLERANCES:
        method = sb.MoreauJean(step=STEP, tolerance=tolerance)
        compiling = processor_seconds(partial(sb.simulate, eqs, STEP, integrator=method))
        begun = process_time()
        run = sb.simulate(eqs, END, integrator=method, times=[0.0, END])
        spent = (process_time() - begun) / round(END / STEP)
        ratio = ratio_text(spent, theirs and theirs[0])
        first = f"{seconds_text(forming)} + {seconds_text(compiling)}" if tolerance == TOLERANCES[0] else ""
        missed = f"{run.statistics.residual:.0e}"
        deepest = max(0.0, *(-float(run[f"gap pair_Ball{j}_Ball{k}"][-1]) for j, k in ((0, 1), (1, 2))))
        yield (
            word,
            f"symbody, {tolerance:.0e}",
            first,
            seconds_text(spent) + ratio,
            missed,
            f"{deepest:.0e}",
        )
        word = ""
    if theirs is not None:
        yield ("", "MuJoCo", "", seconds_text(theirs[0]), "", f"{theirs[1]:.0e}")


def tables(settings: Settings) -> Iterator[Table]:
    """Yield the table of balls in a pit; of many balls if there is time."""
    counts = (*COUNTS, *MANY) if settings.long else COUNTS
    rows = tuple(row for count in counts for row in rows_of(count))
    notes = (
        f"steps of {STEP * 1e3:g} ms, {END:g} s of motion; in brackets over MuJoCo's; contacts are "
        f"n (n - 1)/2 of n balls, and 4 n with the pit",
    )
    columns = ("balls", "law, tolerance", "form, first run", "one step", "residual", "overlap [m]")
    yield Table("contacts: balls in a pit", columns, rows, notes)
