"""What a user writes in a first week, fully typed: it is checked by mypy --strict against the installed package."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import symbody as sb

Floats = NDArray[np.float64]


def double_pendulum(lengths: tuple[float, float]) -> sb.Model:
    links = [
        sb.Body(
            f"Link{k}",
            mass=f"m{k}",
            inertia=(0, 0, f"m{k}*l{k}^2/12"),
            frames={"base": sb.Frame(at=(f"-l{k}/2", 0, 0)), "tip": sb.Frame(at=(f"l{k}/2", 0, 0))},
        )
        for k in (1, 2)
    ]
    motor = sb.Drive(applied="T", damping="d")
    pins = [
        sb.Revolute("A", "ground", "Link1.base", coordinate="theta1", torque=motor),
        sb.Revolute("B", links[0]["tip"], links[1]["base"], coordinate="theta2"),
    ]
    values: dict[str, float | str] = {"m1": 1.0, "m2": "m1/2", "d": 0.1}
    values |= {f"l{k}": length for k, length in enumerate(lengths, start=1)}
    return sb.Model("double pendulum", [*links, *pins], (0, -9.81, 0), values, ["T"], {"theta1": "30 deg"})


def largest_speed(run: sb.Trajectory, name: str) -> float:
    speeds: Floats = run[f"{name}_dot"]
    return float(np.abs(speeds).max())


def describe(eqs: sb.EquationSet) -> str:
    rest: sb.Equilibrium = sb.find_equilibrium(eqs, {"theta1": "-90 deg"})
    modes = rest.linearization.modes
    frequencies: list[float] = [mode.frequency for mode in modes if mode.eigenvalue.imag > 0.0]
    return f"{rest}\n{len(frequencies)} frequencies, the first {frequencies[0]:.3g} rad/s\n{eqs.text(greek=True)}"


def main() -> None:
    eqs = sb.form_equations(double_pendulum((1.0, 0.8)))
    print(describe(eqs))
    run = sb.simulate(eqs, 5.0, inputs={"T": "0.2*sin(3*t)"}, events=sb.Event("theta1", direction="rising"))
    names: list[str] = [name for name in run if name.startswith("theta")]
    print(run.status.value, {name: float(run[name][-1]) for name in names}, largest_speed(run, "theta2"))
    udot = sb.compile(eqs, "udot")
    accelerations: Floats = udot(0.0, run.q[:, 0], run.u[:, 0], [0.0])
    sweep = sb.sweep(eqs, 1.0, parameters={"m1": np.linspace(0.5, 2.0, 5)})
    ends: Floats = sweep["theta1"][:, -1]
    print(accelerations, ends, sb.generate_code(eqs, ["xdot"], language="c").count("\n"))
    run.to_csv("pendulum.csv", "theta1", "reaction A", names="outputs")
    sb.save_plot(sb.plot(run, "theta1", "theta2"), "pendulum.png")


if __name__ == "__main__":
    main()
