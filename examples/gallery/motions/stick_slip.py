"""Block on a belt that sticks and slips.

A spring holds a block back on a moving belt. The belt carries it along until the spring breaks it away, it
slides back, sticks again: why bows sound, doors creak and brakes squeal.

Check: the times of all switches. The block breaks away at a pull `mu_s m g`, slides as an oscillator
about `mu m g/k` for `2 (pi - atan(A w/V))/w`, `A = (mu_s - mu) m g/k`, as it starts and ends at the speed
`V` of the belt, `A` beyond and `A` before the middle, and sticks for `2 A/V`. Derived here.
"""

import math

import numpy as np

import symbody as sb

MASS, STIFFNESS, SPEED = 1.5, 40.0, 0.3
STATIC, SLIDING = 0.3, 0.2
TOLERANCE = 1e-6  # s
LOOK = {}


def model():
    """Return the mechanism."""
    friction = sb.Friction(mu=SLIDING, mu_static=STATIC)
    box = sb.Box((0.16, 0.12, 0.16), at=(0, 0.06, 0), color="orange")
    parts = [
        sb.Body("Belt", shapes=[sb.Box((9.0, 0.04, 0.3), at=(-2, -0.02, 0), color="gray", opacity=0.5)]),
        sb.Body("Block", MASS, frames={"hook": sb.Frame((-0.08, 0.06, 0))}, shapes=[box]),
        sb.Prismatic("drive", "ground", "Belt", coordinate="belt", motion=f"{SPEED}*t"),
        sb.Prismatic("contact", "Belt", "Block", coordinate="slip", friction=friction),
        sb.SpringDamper("spring", "ground.post", "Block.hook", stiffness=STIFFNESS, free=0.5),
    ]
    post = {"post": sb.Frame((-0.58, 0.06, 0))}
    return sb.Model("stick and slip", parts, gravity=(0, -9.81, 0), ground=post)


def motion():
    """Return ten seconds; the block is at rest on the belt at first, the spring relaxed."""
    return sb.simulate(sb.form_equations(model()), 10.0, rtol=1e-10, atol=1e-12)


def comparison(run):
    """Return the times of the switches, and those of the closed form."""
    A, omega = (STATIC - SLIDING) * MASS * 9.81 / STIFFNESS, math.sqrt(STIFFNESS / MASS)
    slip, stick = 2 * (math.pi - math.atan(A * omega / SPEED)) / omega, 2 * A / SPEED
    first = STATIC * MASS * 9.81 / (STIFFNESS * SPEED)
    k = np.arange(len(run.events))
    return np.array([event.t for event in run.events]), first + k // 2 * (slip + stick) + k % 2 * slip


def draw(run, ax):
    """Draw the stretch of the spring over time, and the switches of the closed form."""
    place = "frame r Block ground ground x"
    t = np.linspace(0, run.t[-1], 1001)
    ax.plot(t, run.at(t)[place], color="C0", label="motion")
    times = comparison(run)[1]
    stretch = run.at(times)[place]
    ax.plot(times[::2], stretch[::2], "^", color="C1", label="breaks away")
    ax.plot(times[1::2], stretch[1::2], "v", color="C3", label="sticks")
    ax.set(xlabel="t [s]", ylabel="stretch of the spring [m]", ylim=(0.0, 0.17), title="Marks: closed form")
    ax.legend(loc="upper center", ncols=3)
