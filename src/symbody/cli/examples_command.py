"""``symbody examples``: the examples that come with the package."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from symbody.cli.overwriting import refuse_overwriting
from symbody.errors import Problem, UsageError, nearest
from symbody.formats.model_files import example_names, example_text, examples_folder


def examples(
    name: Annotated[
        str | None, typer.Argument(help="An example; without a name, all examples are listed.")
    ] = None,
    copy: Annotated[
        Path | None, typer.Option("--copy", help="Folder to copy the example's files to.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> None:
    """List the examples, print one, or copy its files."""
    folder = examples_folder()
    known = example_names(folder)
    if name is None:
        typer.echo("\n".join(known))
    elif name not in known:
        alike = [other for other in known if name in other] or known
        raise UsageError(
            Problem("cli.unknown_example", name, f"there is no example {name!r}", "", nearest(name, alike))
        )
    elif copy is None:
        typer.echo(example_text(folder / name), nl=False)
    else:
        typer.echo("\n".join(_copy_files(folder / name, copy, force)))


def _copy_files(source: Path, target: Path, force: bool) -> list[str]:
    target.mkdir(parents=True, exist_ok=True)
    files = sorted(path for path in source.iterdir() if path.is_file())
    for path in files:
        refuse_overwriting(target / path.name, force)
    return [str(shutil.copyfile(path, target / path.name)) for path in files]
