"""An arm on a motor, with signals as each test wants them."""

from __future__ import annotations

from collections.abc import Iterable

import symbody as sb
from symbody.model.element import Element

VALUES = {"m": 1, "J": "0.01", "l": "0.3", "g": "9.81", "km": "0.1", "b": "0.01", "R": 1, "L": "0.5"}


def arm(*parts: Element, torque: str = "km*i", inputs: Iterable[str] = (), **more: object) -> sb.Model:
    """An arm in the plane, turned by `torque`, with further parts."""
    frames = {"base": sb.Frame(at=("-l", 0, 0)), "tip": sb.Frame(at=("l", 0, 0))}
    body = sb.Body("Arm", mass="m", inertia=(0, 0, "J"), frames=frames)
    drive = sb.Drive(applied=torque, damping="b")
    motor = sb.Revolute("motor", "ground", "Arm.base", coordinate="theta", torque=drive)
    return sb.Model(
        "arm", [body, motor, *parts], gravity=(0, "-g", 0), parameters=VALUES, inputs=inputs, **more
    )


def dc_motor_arm() -> sb.Model:
    """The arm with the current of a DC motor as a state."""
    return arm(sb.Signal("i", rate="(V - R*i - km*theta_dot)/L", initial=2), inputs=["V"])
