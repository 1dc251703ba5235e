"""Planetary gear.

A sun, three planets on a carrier, a ring: two of the three shafts drive the third. With the ring held it is
the gear of hub motors and wind turbines; with all three shafts it divides power in hybrid cars.

Check: against the carrier sun and ring turn as two gears do, `(w_sun - w_carrier) z_s = -(w_ring -
w_carrier) z_r`, so `z_s w_sun + z_r w_ring = (z_s + z_r) w_carrier`, R. Willis, Principles of Mechanism,
1841.
"""

import numpy as np

import symbody as sb

SUN, PLANET = 24, 18  # teeth
RING = SUN + 2 * PLANET
TOLERANCE = 1e-7  # rad/s
LOOK = {"times": (0.0,), "view": (0.35, 0.5, 1.0)}


def model():
    """Return the mechanism."""
    module = 0.004  # m
    axis = module * (SUN + PLANET) / 2
    frames = {
        f"axle{k}": sb.Frame((f"{axis}*cos(2*pi*{k}/3)", f"{axis}*sin(2*pi*{k}/3)", 0)) for k in range(3)
    }
    carrier = sb.Body("Carrier", 0.5, (0.001, 0.001, 0.002), frames=frames)
    parts = [
        carrier,
        sb.Body("Sun", 0.4, (0.0005, 0.0005, 0.001)),
        sb.Body("Ring", 1.0, (0.004, 0.004, 0.008)),
        sb.Revolute("output", "ground", carrier, coordinate="phi", torque=sb.Drive(damping=0.02)),
        sb.Revolute("input", carrier, "Sun", coordinate="sun"),
        sb.Revolute("case", carrier, "Ring", coordinate="ring"),
        sb.Torque("motor", "Sun", (0, 0, 0.3)),
        sb.Torque("second motor", "Ring", (0, 0, "-0.5*cos(3*t)")),
        sb.Gear("inner", ["planet0", "ring"], f"{RING}/{PLANET}"),
    ]
    for k in range(3):
        planet = sb.Body(f"Planet{k}", 0.2, (0.0001, 0.0001, 0.0002))
        parts += [
            sb.Revolute(f"axle{k}", f"Carrier.axle{k}", planet, coordinate=f"planet{k}"),
            sb.Gear(f"outer{k}", [f"planet{k}", "sun"], f"-{SUN}/{PLANET}", offset=f"pi/{PLANET}"),
        ]
    return sb.Model("planetary gear", parts)


def motion():
    """Return two seconds under torques on sun and ring, the carrier against a brake."""
    return sb.simulate(sb.form_equations(model()), 2.0, times=np.linspace(0, 2, 201))


def comparison(run):
    """Return both sides of Willis's equation."""
    sun, ring, carrier = (run[f"frame w {body} ground ground z"] for body in ("Sun", "Ring", "Carrier"))
    return SUN * sun + RING * ring, (SUN + RING) * carrier
