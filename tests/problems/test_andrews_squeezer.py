"""Andrews' squeezing mechanism: seven bodies, three loops, 30 ms, against the published solution.

Data, initial values and the solution at t = 0.03 s are those of the Test Set for IVP Solvers (Mazzia and Magherini,
University of Bari), computed there to 14 digits with PSIDE; the mechanism is that of Schiehlen, Multibody Systems
Handbook (1990), and of Hairer and Wanner, Solving Ordinary Differential Equations II, section VII.7.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from symbody.formats import model_from_toml

NUMBERS = {
    "m1": 0.04325, "m2": 0.00365, "m3": 0.02373, "m4": 0.00706, "m5": 0.07050, "m6": 0.00706, "m7": 0.05498,
    "I1": 2.194e-6, "I2": 4.410e-7, "I3": 5.255e-6, "I4": 5.667e-7, "I5": 1.169e-5, "I6": 5.667e-7, "I7": 1.912e-5,
    "xa": -0.06934, "ya": -0.00227, "xb": -0.03635, "yb": 0.03273, "xc": 0.014, "yc": 0.072, "c0": 4530.0,
    "l0": 0.07785, "d": 0.028, "da": 0.0115, "e": 0.02, "ea": 0.01421, "rr": 0.007, "ra": 0.00092, "ss": 0.035,
    "sa": 0.01874, "sb": 0.01043, "sc": 0.018, "sd": 0.02, "ta": 0.02308, "tb": 0.00916, "u": 0.04, "ua": 0.01228,
    "ub": 0.00449, "zf": 0.02, "zt": 0.04, "fa": 0.01421, "mom": 0.033,
}  # fmt: skip

# Number of each body, and its frames relative to its centre of mass.
BODIES = {
    1: {"O": ("-ra", "0"), "E": ("rr - ra", "0")},
    2: {"E": ("da", "0"), "F": ("da - d", "0")},
    3: {"B": ("-sb", "sa"), "F": ("-sb", "sa - ss"), "D": ("sd - sb", "sa - sc")},
    4: {"G": ("0", "e - ea"), "F": ("0", "-ea")},
    5: {"A": ("-ta", "-tb"), "G": ("zt - ta", "-tb")},
    6: {"H": ("fa - zf", "0"), "F": ("fa", "0")},
    7: {"A": ("ub", "ua"), "H": ("ub", "ua - u")},
}
# Coordinate, and the frames it turns; without a coordinate they close the loops.
JOINTS = (
    ("beta", "ground", "K1.O"), ("Theta", "K1.E", "K2.E"), ("gamma", "ground.B", "K3.B"), ("Phi", "K5.G", "K4.G"),
    ("delta", "ground.A", "K5.A"), ("Omega", "K7.H", "K6.H"), ("epsilon", "ground.A", "K7.A"),
    ("", "K2.F", "K3.F"), ("", "K2.F", "K4.F"), ("", "K2.F", "K6.F"),
)  # fmt: skip

START = {
    "beta": -0.0617138900142764496358948458001, "Theta": 0.0, "gamma": 0.455279819163070380255912382449,
    "Phi": 0.222668390165885884674473185609, "delta": 0.487364979543842550225598953530,
    "Omega": -0.222668390165885884674473185609, "epsilon": 1.23054744454982119249735015568,
}  # fmt: skip
END = {
    "beta": 0.1581077119629904e2, "Theta": -0.1575637105984298e2, "gamma": 0.4082224013073101e-1,
    "Phi": -0.5347301163226948, "delta": 0.5244099658805304, "Omega": 0.5347301163226948,
    "epsilon": 0.1048080741042263e1, "beta_dot": 0.1139920302151208e4, "Theta_dot": -0.1424379294994111e4,
    "gamma_dot": 0.1103291221937134e2, "Phi_dot": 0.1929337464421385e2, "delta_dot": 0.5735699284790808,
    "Omega_dot": -0.1929337464421385e2, "epsilon_dot": 0.3231791658026955,
}  # fmt: skip


@cache
def squeezer() -> sb.EquationSet:
    lines = ['name = "squeezer"', 'gravity = ["0", "0", "0"]', "[parameters]"]
    lines += [f"{name} = {value!r}" for name, value in NUMBERS.items()]
    lines.append("[ground.frames]")
    lines += [f'{k} = {{ at = ["x{k.lower()}", "y{k.lower()}", "0"] }}' for k in "ABC"]
    for k, frames in BODIES.items():
        lines += [
            "[[body]]",
            f'name = "K{k}"',
            f'mass = "m{k}"',
            f'inertia = ["0", "0", "I{k}"]',
            "[body.frames]",
        ]
        lines += [f'{frame} = {{ at = ["{x}", "{y}", "0"] }}' for frame, (x, y) in frames.items()]
    for k, (coordinate, start, end) in enumerate(JOINTS):
        lines += [
            "[[joint]]",
            f'name = "J{k}"',
            'type = "revolute"',
            f'between = ["{start}", "{end}"]',
            'axis = "z"',
        ]
        lines += [f'coordinate = "{coordinate}"'] if coordinate else []
        lines += ['torque = { applied = "mom" }'] if coordinate == "beta" else []
    lines += [
        "[[spring]]",
        'name = "spring"',
        'between = ["ground.C", "K3.D"]',
        'stiffness = "c0"',
        'free = "l0"',
    ]
    return sb.form_equations(model_from_toml("\n".join(lines)))


def largest_error(run: sb.Trajectory) -> float:
    """Over all coordinates and speeds at the end, relative to the larger of 1 and the value."""
    return max(abs(run[name][-1] - value) / max(1.0, abs(value)) for name, value in END.items())


def test_first_accelerations_are_those_published() -> None:
    first = sb.assemble(squeezer(), START)
    # The initial values are given to 30 digits; assembled from rounded ones they close to rounding.
    assert first.residual < 1e-16
    # 1e-10: the condition of the system, some 1e5, times rounding.
    assert first["beta_ddot"] == pytest.approx(14222.4439199541138705911625887, rel=1e-10)
    assert first["Theta_ddot"] == pytest.approx(-10666.8329399655854029433719415, rel=1e-10)
    for name in ("gamma", "Phi", "delta", "Omega", "epsilon"):
        assert abs(first[f"{name}_ddot"]) < 1e-10 * 14222


# Errors grow about 1e3 fold in 30 ms. Explicit steps at 1e-13 and Partition at 1e-12 agree to 1e-11 with each other,
# and differ from the published values by 1e-9 in the angles and 3e-8 in the rates: that is how good these are.
@pytest.mark.parametrize(
    ("options", "rtol", "tolerance"),
    [
        ({}, 1e-11, 1e-7),
        pytest.param({"integrator": sb.Stiff()}, 1e-11, 1e-6, marks=pytest.mark.exhaustive),
        pytest.param({"constraints": sb.GGL()}, 1e-10, 1e-5, marks=pytest.mark.exhaustive),
        pytest.param({"constraints": sb.Partition()}, 1e-11, 1e-7, marks=pytest.mark.exhaustive),
    ],
)
def test_solution_at_30_ms(
    options: dict[str, sb.Stiff | sb.GGL | sb.Partition], rtol: float, tolerance: float
) -> None:
    run = sb.simulate(
        squeezer(), 0.03, START, times=np.linspace(0.0, 0.03, 7), rtol=rtol, atol=rtol, **options
    )
    assert run.success
    assert largest_error(run) < tolerance
