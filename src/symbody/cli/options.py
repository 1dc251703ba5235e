"""What the commands have in common: their arguments and options."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer


class TreeWord(StrEnum):
    """Which coordinates the equations are formed in."""

    JOINTS = "joints"
    ABSOLUTE = "absolute"


def option(*flags: str, text: str, metavar: str | None = None) -> Any:
    """Return an option with its help."""
    return typer.Option(*flags, help=text, metavar=metavar)


ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="The model file.")]
Pairs = list[str] | None
Settings = Annotated[
    Pairs,
    option("--set", "-p", metavar="NAME=VALUE", text="A parameter, input or value at start; repeatable."),
]
Inputs = Annotated[
    Pairs,
    option("--input", "-i", metavar="NAME=EXPRESSION", text="F='sin(t)', F=@run.csv[t,F]; repeatable."),
]
Initials = Annotated[
    Pairs, option("--initial", metavar="NAME=VALUE", text="x or x_dot at start; repeatable.")
]
Tree = Annotated[
    TreeWord | None,
    typer.Option(
        "--tree", help="Coordinates of the joints, or of free bodies; by default as the model says."
    ),
]
Substitute = Annotated[
    bool,
    typer.Option("--substitute", help="Put gears, belts, racks and <mimic> into the equations."),
]
Force = Annotated[bool, option("--force", text="Overwrite existing files.")]
