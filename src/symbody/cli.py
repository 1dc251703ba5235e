"""The command line: ``symbody simulate``, ``equations``, ``check``, ``code``, ``examples``.

Exit codes: 0 done, 2 usage, 3 model, 4 numerics, 5 environment, 130 interrupted.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

import symbody
from symbody.codegen.compile import generate_code
from symbody.equations.display import display_equations, latex_equations
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.errors import EnvironmentFault, Problem, SymbodyError, UsageError, nearest
from symbody.formats.native import load_model
from symbody.model.model import Model

app = typer.Typer(
    name="symbody",
    help="From the description of a mechanism to equations of motion, code and motion.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
)

ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.toml", help="The model file.")]
Assignments = Annotated[
    list[str] | None, typer.Option("--set", "-p", metavar="NAME=VALUE", help="Override a parameter; repeatable.")
]


@app.command()
def equations(
    model: ModelFile,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX instead of text.")] = False,
) -> None:
    """Print the equations of motion."""
    eqs = form_equations(load_model(model))
    lines = latex_equations(eqs.formed) if latex else display_equations(eqs.formed)
    for line in lines:
        typer.echo(line)


@app.command()
def check(model: ModelFile) -> None:
    """Read a model and say what it is: bodies, joints, degrees of freedom, notes."""
    loaded = load_model(model)
    eqs = form_equations(loaded)
    for line in summary(loaded, eqs):
        typer.echo(line)


@app.command()
def code(
    model: ModelFile,
    output: Annotated[
        list[str] | None, typer.Option("--output", "-o", help="What to compute; repeatable. Default: xdot.")
    ] = None,
    language: Annotated[str, typer.Option("--language", "-l", help="Target language: c.")] = "c",
    out: Annotated[Path | None, typer.Option("--out", help="File to write; default: standard output.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
) -> None:
    """Print source code that evaluates the equations."""
    text = generate_code(form_equations(load_model(model)), output or ["xdot"], language)
    if out is None:
        typer.echo(text, nl=False)
    else:
        _refuse_overwriting(out, force)
        out.write_text(text, encoding="utf-8", newline="\n")


@app.command()
def simulate(
    model: ModelFile,
    end: Annotated[float, typer.Option("--end", "-t", help="End time [s].")] = 10.0,
    parameters: Assignments = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", "-i", metavar="NAME=EXPRESSION", help="An input, e.g. F='sin(t)'; repeatable."),
    ] = None,
    initial: Annotated[
        list[str] | None,
        typer.Option("--initial", metavar="NAME=VALUE", help="Initial value of x or x_dot; repeatable."),
    ] = None,
    curves: Annotated[
        list[str] | None, typer.Option("--show", "-s", help="What to plot; repeatable. Default: coordinates.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Plot file; default: beside the model.")] = None,
    csv: Annotated[Path | None, typer.Option("--csv", help="Also write the states as CSV.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-8,
    atol: Annotated[float, typer.Option(help="Absolute tolerance.")] = 1e-10,
) -> None:
    """Form the equations, print them, compute the motion and plot it."""
    for path in (out, csv):
        if path is not None:
            _refuse_overwriting(path, force)
    eqs = form_equations(load_model(model))
    run = symbody.simulate(
        eqs,
        end,
        parameters=_assigned(parameters, "--set"),
        inputs=_assigned(inputs, "--input"),
        initial=_assigned(initial, "--initial"),
        rtol=rtol,
        atol=atol,
    )
    picture = out if out is not None else model.with_suffix(".png")
    symbody.save_plot(symbody.plot(run, *(curves or eqs.coordinate_names), title=eqs.model.name), picture)
    if csv is not None:
        run.to_csv(csv)
    if as_json:
        typer.echo(json.dumps({"success": run.success, "status": run.status.name, "t": run.t.tolist(),
                               **{name: run[name].tolist() for name in eqs.state_names}}))  # fmt: skip
        return
    for line in [*display_equations(eqs.formed), *eqs.notes, *run.notes, repr(run), f"plot: {picture}"]:
        typer.echo(line)
    if not run.success:
        raise typer.Exit(4)


@app.command()
def examples(
    name: Annotated[str | None, typer.Argument(help="An example; without it all are listed.")] = None,
    copy: Annotated[Path | None, typer.Option("--copy", help="Folder to copy the example's files to.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> None:
    """List the examples, print one, or copy its files."""
    folder = examples_folder()
    known = sorted(path.name for path in folder.iterdir() if (path / f"{path.name}.toml").is_file())
    if name is None:
        for word in known:
            typer.echo(word)
    elif name not in known:
        raise UsageError(
            Problem("cli.unknown_example", name, f"there is no example {name!r}", "", nearest(name, known))
        )
    elif copy is None:
        typer.echo((folder / name / f"{name}.toml").read_text(encoding="utf-8"), nl=False)
    else:
        for line in _copy_files(folder / name, copy, force):
            typer.echo(line)


def summary(model: Model, eqs: EquationSet) -> list[str]:
    """Return what a model is, a line a fact."""
    joints = [f"{joint.name} ({type(joint).__name__.lower()})" for joint in model.joints]
    return [
        f"model {model.name}",
        f"bodies: {', '.join(body.name for body in model.bodies) or 'none'}",
        f"joints: {', '.join(joints) or 'none'}",
        f"coordinates: {', '.join(eqs.coordinate_names) or 'none'}",
        f"inputs: {', '.join(eqs.input_names) or 'none'}",
        f"parameters: {', '.join(eqs.parameter_names) or 'none'}",
        f"degrees of freedom: {eqs.degrees_of_freedom}",
        *(f"note: {note}" for note in eqs.notes),
    ]


def examples_folder() -> Path:
    """Return the folder of the examples, in an installed package or beside the sources."""
    package = Path(symbody.__file__).parent
    for folder in (package / "examples", package.parents[1] / "examples"):
        if folder.is_dir():
            return folder
    raise EnvironmentFault(
        Problem("cli.no_examples", str(package), "the examples are not installed", "", "install symbody again")
    )


def main() -> None:
    """Run the command line; faults of the user end in a message and an exit code, never in a traceback."""
    console = Console(stderr=True, highlight=False)
    try:
        app(standalone_mode=False)
    except SymbodyError as error:
        console.print(str(error), markup=False, soft_wrap=True)
        sys.exit(error.exit_code)
    except (KeyboardInterrupt, typer.Abort):
        console.print("interrupted")
        sys.exit(130)
    except OSError as error:
        console.print(f"[cli.file] {error.filename or ''}: {error.strerror or error}", markup=False)
        sys.exit(5)


def _assigned(pairs: Iterable[str] | None, option: str) -> dict[str, str]:
    result = {}
    for pair in pairs or ():
        name, equals, value = pair.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UsageError(
                Problem("cli.assignment", option, f"{pair!r} is not of the form NAME=VALUE", "",
                        f"type for instance {option} k=2.5")
            )  # fmt: skip
        result[name.strip()] = value.strip()
    return result


def _refuse_overwriting(path: Path, force: bool) -> None:
    if path.exists() and not force:
        raise UsageError(
            Problem("cli.file_exists", str(path), "the file exists already", "", "choose another name, or add --force")
        )


def _copy_files(source: Path, target: Path, force: bool) -> list[str]:
    target.mkdir(parents=True, exist_ok=True)
    files = sorted(path for path in source.iterdir() if path.is_file())
    for path in files:
        _refuse_overwriting(target / path.name, force)
    return [str(shutil.copyfile(path, target / path.name)) for path in files]
