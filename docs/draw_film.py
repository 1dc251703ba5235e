"""Draw mechanisms by save_animation: `python docs/draw_film.py` writes film_*.svg and footprints*.png."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import symbody as sb

PICTURES = Path(__file__).parent / "pictures"
TOP = Path(__file__).parents[1] / "examples" / "spinning_top" / "spinning_top.toml"


def four_bar() -> sb.Model:
    """Return a crank, a coupler with a point beside it, a rocker, and a spring at the rocker."""

    def bar(name: str, length: float, mass: float, **more: sb.Frame) -> sb.Body:
        ends = {"A": sb.Frame(at=(-length / 2, 0, 0)), "B": sb.Frame(at=(length / 2, 0, 0))}
        return sb.Body(name, mass=mass, inertia=(0, 0, mass * length**2 / 12), frames=ends | more)

    return sb.Model(
        "four-bar",
        [
            bar("Crank", 0.2, 1.0),
            bar("Coupler", 0.6, 3.0, P=sb.Frame(at=(0.05, 0.25, 0))),
            bar("Rocker", 0.5, 2.5),
            sb.Revolute("O", "ground", "Crank.A", coordinate="alpha"),
            sb.Revolute("A", "Crank.B", "Coupler.A", coordinate="beta"),
            sb.Revolute("C", "ground.pier", "Rocker.A", coordinate="gamma"),
            sb.Revolute("B", "Coupler.B", "Rocker.B"),
            sb.SpringDamper("spring", "ground.post", "Rocker.B", stiffness=60, free=0.3),
        ],
        gravity=(0, -9.81, 0),
        ground={"pier": sb.Frame(at=(0.7, 0, 0)), "post": sb.Frame(at=(1.0, 0.3, 0))},
        initial={"alpha": 1.0, "beta": -0.4, "gamma": 2.0, "alpha_dot": 12.0},
    )


def hopper() -> sb.Trajectory:
    """Return a springy leg with a foot that is thrown forward and hops twice."""
    foot = sb.Body("Foot", mass=0.8, inertia=(0.01,) * 3, shapes=[sb.Sphere(0.05, color="dimgray")])
    trunk = sb.Body("Trunk", mass=8, inertia=(0.2,) * 3, shapes=[sb.Box((0.3, 0.16, 0.14), color="orange")])
    floor = sb.Contact(
        "foot", "ground", foot, ["plane", {"sphere": 0.05}], normal="rigid", friction=sb.Friction(mu=0.02)
    )
    leg = sb.Drive(stiffness=2500, free=0.6, damping=2)
    parts = [
        sb.Cartesian("move", "ground", foot, coordinates=["x", "y", "z"]),
        sb.Prismatic("leg", foot, trunk, axis="z", coordinate="s", force=leg),
        floor,
    ]
    model = sb.Model("hopper", [foot, trunk, *parts], gravity=(0, 0, -9.81))
    start = {"z": 0.35, "s": 0.6, "x_dot": 0.8}
    return sb.simulate(sb.form_equations(model), 2.6, start)


def main() -> None:
    """Write the pictures, for light and for dark pages."""
    run = sb.simulate(sb.form_equations(four_bar()), 1.0)
    size = (560, 330)
    hops = hopper()
    top = sb.simulate(sb.form_equations(sb.load_model(TOP)), 1.5)
    for dark, end in ((False, ""), (True, "_dark")):
        sb.save_animation(
            run,
            PICTURES / f"film_four_bar{end}.svg",
            times=(0.0, 0.1, 0.2),
            traces=["Coupler.P"],
            labels=True,
            size=size,
            dark=dark,
        )
        sb.save_animation(
            hops,
            PICTURES / f"footprints{end}.png",
            times=(0.0, 0.33, 0.7, 1.3, 1.62),
            vectors=["foot"],
            view=(0.2, -1.0, 0.3),
            size=(820, 400),
            ghosts=0.3,
            dark=dark,
        )
        sb.save_animation(
            top,
            PICTURES / f"film_top{end}.svg",
            times=np.linspace(0, 1.5, 4),
            traces=["Top"],
            size=size,
            dark=dark,
        )


if __name__ == "__main__":
    main()
