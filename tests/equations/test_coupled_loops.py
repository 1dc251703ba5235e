"""Two spatial loops that share bodies: every choice of trees gives the same accelerations and reactions.

Two cranks about skew axes hold a platform by rods with ball joints at both ends, and the platform turns about an
oblique pin: 12 joints' worth of freedoms, two loops that meet in the platform. It stands in no file.
"""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb

EPS = np.finfo(float).eps
BODIES = ("Plate", "Crank1", "Rod1", "Crank2", "Rod2")
JOINTS = ("pin", "axle1", "low1", "high1", "axle2", "low2", "high2")
OUTPUTS = [
    *(f"frame {kind} {body} ground ground" for body in BODIES for kind in ("vdot", "wdot")),
    *(f"reaction {joint}" for joint in JOINTS),
]


def mechanism() -> sb.Model:
    plate = sb.Body("Plate", 2, (0.3, 0.4, 0.5), (0.02, -0.01, 0.03), frames={
        "pin": sb.Frame(at=(-0.3, 0, 0)), "a": sb.Frame(at=(0.4, 0.3, 0.1)), "b": sb.Frame(at=(0.4, -0.3, 0))})  # fmt: skip
    ends = {"low": sb.Frame(at=(0, 0, -0.35)), "high": sb.Frame(at=(0, 0, 0.35))}
    elements: list[sb.Body | sb.Revolute | sb.Spherical | sb.SpringDamper] = [plate]
    for k in (1, 2):
        elements.append(
            sb.Body(f"Crank{k}", 0.5, (0.02, 0.03, 0.04), frames={"tip": sb.Frame(at=("r", 0, 0))})
        )
        elements.append(sb.Body(f"Rod{k}", 0.3, (0.05, 0.05, 0.01), frames=ends))
    elements.append(sb.Revolute("pin", "ground.pin", "Plate.pin", axis=(1, 2, 2), coordinate="tilt"))
    for k, corner in ((1, "a"), (2, "b")):
        turn = sb.Drive(applied="T") if k == 1 else sb.Drive(damping=0.2)
        elements.append(sb.Revolute(f"axle{k}", f"ground.g{k}", f"Crank{k}", axis=(0, 1, k), coordinate=f"q{k}",
                                    torque=turn))  # fmt: skip
        elements.append(sb.Spherical(f"low{k}", f"Crank{k}.tip", f"Rod{k}.low", angles="312",
                                     coordinates=[f"{c}{k}" for c in "abc"]))  # fmt: skip
        elements.append(sb.Spherical(f"high{k}", f"Plate.{corner}", f"Rod{k}.high", angles="123",
                                     coordinates=[f"{c}{k}" for c in "def"], tree=False))  # fmt: skip
    elements.append(sb.SpringDamper("spring", "ground", "Plate.a", stiffness=40, free=0.5))
    ground = {
        "pin": sb.Frame(at=(-0.3, 0, 0.9)),
        "g1": sb.Frame(at=(0.2, 0.35, 0.2)),
        "g2": sb.Frame(at=(0.25, -0.3, 0.15), rotate=[("x", 0.3)]),
    }
    return sb.Model(
        "coupled loops", elements, gravity=(0.5, -1, -9), parameters={"r": 0.2}, inputs=["T"], ground=ground
    )


def motions(eqs: sb.EquationSet, state: sb.State) -> dict[str, np.ndarray]:
    f = sb.compile(eqs, OUTPUTS)
    found = f(0.0, list(state.q.values()), list(state.u.values()), [0.7])
    return dict(zip(OUTPUTS, found, strict=True))


def placed_like(eqs: sb.EquationSet, other: sb.EquationSet, state: sb.State) -> sb.State:
    """The same configuration and motion in the variables of another choice of trees."""
    names = [f"frame {kind} {body} ground ground" for body in BODIES for kind in ("r", "v", "w")]
    there = dict(
        zip(
            names,
            sb.compile(other, names)(0, list(state.q.values()), list(state.u.values()), [0.0]),
            strict=True,
        )
    )
    guess, rates = {}, {}
    for body in BODIES:
        turn = np.asarray(state[f"frame R {body} ground"])
        w = np.sqrt(1 + np.trace(turn)) / 2
        quaternion = (
            w,
            *((turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / (4 * w)),
        )
        guess |= {
            f"{body}_{c}": x
            for c, x in zip(("x", "y", "z"), there[f"frame r {body} ground ground"], strict=True)
        }
        guess |= {f"{body}_{c}": x for c, x in zip(("qw", "qx", "qy", "qz"), quaternion, strict=True)}
        own = turn.T @ there[f"frame w {body} ground ground"]
        rates |= {
            f"{body}_{c}": x
            for c, x in zip(("vx", "vy", "vz"), there[f"frame v {body} ground ground"], strict=True)
        }
        rates |= {f"{body}_{c}": x for c, x in zip(("wx", "wy", "wz"), own, strict=True)}
    known = {name: float(state[name]) for name in eqs.coordinate_names if name not in guess}
    guess = {name: float(x) for name, x in guess.items() if name in eqs.coordinate_names} | known
    speeds = {name: float(rates[name]) if name in rates else float(state[name]) for name in eqs.speed_names}
    return sb.assemble(eqs, {}, guess | speeds, inputs={"T": 0.7})


TREES = (
    sb.Trees(["pin", "high1", "low1", "high2", "axle2"], ["pin", "high1", "low1", "high2", "low2"]),
    sb.Trees(["pin", "axle1", "low1", "axle2", "low2"], ["pin", "axle1", "high1", "axle2", "high2"]),
    "absolute",
)


@pytest.mark.parametrize(
    ("seed", "trees"),
    [
        pytest.param(0, TREES[:1], marks=pytest.mark.exhaustive),
        *(pytest.param(seed, TREES, marks=pytest.mark.exhaustive) for seed in range(10)),
    ],
    ids=["two trees", *map(str, range(10))],
)
def test_every_choice_of_trees_agrees(seed: int, trees: tuple[sb.Trees | str, ...]) -> None:
    model = mechanism()
    first = sb.form_equations(model)
    assert first.degrees_of_freedom == 3  # the plate tilts; each rod spins about itself
    random = np.random.default_rng(seed)
    guess = {name: 0.2 * random.standard_normal() for name in first.coordinate_names}
    rates = {name: random.standard_normal() for name in first.speed_names}
    state = sb.assemble(first, {}, guess | rates, inputs={"T": 0.7})
    here = motions(first, state)
    for tree in trees:
        eqs = sb.form_equations(model, tree=tree)  # type: ignore[arg-type]
        other = placed_like(eqs, first, state)
        there = motions(eqs, other)
        saddle = sb.compile(eqs, ["mass_matrix", "jacobian"])(
            0, list(other.q.values()), list(other.u.values()), [0.7]
        )
        matrix = np.block([[saddle[0], -saddle[1].T], [saddle[1], np.zeros((len(saddle[1]),) * 2)]])
        largest = max(float(np.abs(x).max()) for x in here.values())
        bound = 100 * EPS * np.linalg.cond(matrix) * largest
        for name in OUTPUTS:
            assert np.abs(here[name] - there[name]).max() < bound, (tree, name)
