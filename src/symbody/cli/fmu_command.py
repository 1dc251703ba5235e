"""``symbody fmu``: a model file as a functional mock-up unit."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, cast

import typer

from symbody.cli.forming import form_file
from symbody.cli.options import Force, Initials, ModelFile, Pairs, Settings, Substitute, Tree, option
from symbody.cli.overwriting import refuse_overwriting
from symbody.cli.settings import Settled, read_pairs
from symbody.fmu.binaries import Version
from symbody.fmu.export import save_fmu


def fmu(
    model: ModelFile,
    out: Annotated[Path | None, option("--out", "-o", text="Archive; default: next to the model.")] = None,
    version: Annotated[str, option("--version", text="Version of the standard: 3.0 or 2.0.")] = "3.0",
    outputs: Annotated[
        Pairs, option("--output", metavar="OUTPUT", text="Output in addition to the states; repeatable.")
    ] = None,
    platforms: Annotated[
        Pairs,
        option(
            "--platform", metavar="NAME", text="x86_64-windows, ..., or all; repeatable. Default: this one."
        ),
    ] = None,
    parameters: Settings = None,
    initial: Initials = None,
    fixed: Annotated[
        Pairs,
        option("--fixed", metavar="NAME", text="A parameter that is set only before the motion; repeatable."),
    ] = None,
    no_sources: Annotated[bool, typer.Option("--no-sources", help="Leave out the C sources.")] = False,
    tree: Tree = None,
    substitute: Substitute = False,
    force: Force = False,
) -> None:
    """Write an FMU, which simulation tools import, for model exchange and co-simulation."""
    target = model.with_suffix(".fmu") if out is None else out
    refuse_overwriting(target, force)
    eqs = form_file(model, tree, substitute)
    given = Settled.resolve(eqs, read_pairs(parameters, "--set"), {}, read_pairs(initial, "--initial"))
    chosen: str | list[str] | None = "all" if "all" in (platforms or ()) else platforms
    made = save_fmu(
        eqs, target, cast(Version, version), outputs=outputs or (), initial=given.initial,
        parameters=given.parameters, fixed=fixed or (), platforms=chosen, sources=not no_sources,
    )  # fmt: skip
    where = ", ".join(made.platforms) or "sources only"
    typer.echo(f"{made.path}: FMI {made.version}, {len(made.variables)} variables, {where}")
    for note in made.notes:
        typer.echo(f"note: {note}")
