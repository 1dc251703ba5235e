"""The command line: ``symbody simulate``, ``animate``, ``linearize``, ``equilibrium``, ``equations``, ...

Exit codes: 0 done, 2 usage, 3 model, 4 numerics, 5 environment, 130 interrupted.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import typer

import symbody
import symbody.builder
from symbody.cli.doctor import run_doctor
from symbody.cli.examples_command import examples
from symbody.cli.flags import FlagCommand, FlagGroup
from symbody.cli.fmu_command import fmu
from symbody.cli.forming import form_file
from symbody.cli.motion_lines import motion_json, motion_lines
from symbody.cli.options import (
    Curves,
    Force,
    Initials,
    Inputs,
    ModelFile,
    Pairs,
    Settings,
    Substitute,
    Tree,
    option,
)
from symbody.cli.overwriting import refuse_overwriting
from symbody.cli.pages import open_page, read_sliders, write_live_page, write_motion_page
from symbody.cli.report_command import report
from symbody.cli.settings import Settled, read_pairs
from symbody.cli.small_motions import equilibrium_json, equilibrium_lines, linear_json, linear_lines
from symbody.cli.stages import StageBar
from symbody.cli.summary import summary
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.equation_lines import equation_lines
from symbody.equations.outputs.textbook import MOST_SPEEDS
from symbody.errors import Problem, UsageError, number_in_words
from symbody.expr.printing.wrapping import text_width
from symbody.simulation.native.run import check_memory
from symbody.simulation.programs.generate_code import generate_code
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status

_SCREEN: Final = 48  # lines of equations that are read before a motion

app = typer.Typer(
    name="symbody",
    cls=FlagGroup,
    help="From the description of a mechanism to equations of motion, code and motion.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
)
command = partial(app.command, cls=FlagCommand)
command()(fmu)
command()(report)
command()(examples)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(symbody.__version__)
        raise typer.Exit


@app.callback()
def print_about(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Stand before all commands."""


@command()
def equations(
    model: ModelFile,
    latex: Annotated[bool, typer.Option("--latex", help="Print LaTeX instead of text.")] = False,
    tree: Tree = None,
    substitute: Substitute = False,
) -> None:
    """Print the equations of motion, with the rates of coordinates and the constraints there are."""
    _print(equation_lines(form_file(model, tree, substitute).textbook, latex, width=text_width()))


@command()
def check(model: ModelFile, tree: Tree = None, substitute: Substitute = False) -> None:
    """Read a model and print what it holds: bodies, joints, trees, degrees of freedom, notes."""
    eqs = form_file(model, tree, substitute)
    _print(summary(eqs.model, eqs))


@command()
def doctor() -> None:
    """Print what is installed and where results are stored, and try each part of symbody."""
    raise typer.Exit(run_doctor())


@command()
def code(
    model: ModelFile,
    output: Annotated[
        list[str] | None,
        typer.Option(
            "--output",
            "-o",
            metavar="OUTPUT",
            help="Output to compute; repeatable. Default: xdot; for Modelica no further outputs.",
        ),
    ] = None,
    language: Annotated[
        str,
        typer.Option(
            "--language",
            "-l",
            help="c, python, fortran, matlab (or octave), julia, rust, javascript, jax, casadi, modelica.",
        ),
    ] = "c",
    out: Annotated[
        Path | None, typer.Option("--out", help="File to write; default: standard output.")
    ] = None,
    substitute: Substitute = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
) -> None:
    """Print source code that evaluates the equations."""
    default = [] if language.lower() == "modelica" else ["xdot"]
    text = generate_code(form_file(model, None, substitute), output or default, language)
    if out is None:
        typer.echo(text, nl=False)
    else:
        refuse_overwriting(out, force)
        out.write_text(text, encoding="utf-8", newline="\n")


@command()
def simulate(
    model: ModelFile,
    end: Annotated[float, option("--end", "-t", text="End time in s.")] = 10.0,
    parameters: Settings = None,
    inputs: Inputs = None,
    initial: Initials = None,
    curves: Curves = None,
    out: Annotated[Path | None, option("--out", "-o", text="Plot file; default: next to the model.")] = None,
    csv: Annotated[Path | None, option("--csv", text="Also write states and curves as CSV.")] = None,
    samples: Annotated[
        int | None, option("--samples", text="Evenly spaced samples; default: every step.")
    ] = None,
    page: Annotated[bool, option("--animate", text="Also write a page that shows the motion.")] = False,
    tree: Tree = None,
    substitute: Substitute = False,
    as_json: Annotated[bool, option("--json", text="Print the result as JSON.")] = False,
    force: Force = False,
    rtol: Annotated[float, option("--rtol", text="Relative tolerance.")] = 1e-8,
    atol: Annotated[
        float | None, option("--atol", text="Absolute tolerance; default: from the mechanism's scales.")
    ] = None,
) -> None:
    """Form the equations, print them, compute the motion and plot it."""
    picture = model.with_suffix(".png") if out is None else out
    for path in (picture, picture.with_suffix(".html")) if page else (picture,):
        refuse_overwriting(path, force, is_default=out is None)
    if csv is not None:
        refuse_overwriting(csv, force)
    _check_samples(samples)
    given = [read_pairs(parameters, "--set"), read_pairs(inputs, "--input"), read_pairs(initial, "--initial")]
    bar = StageBar()
    with bar.stage("forming the equations"):
        eqs = form_file(model, tree, substitute)
        settings = Settled.resolve(eqs, *given)
        told = [] if as_json else _introduction(eqs, model)
    _print(told)
    with bar.stage("compiling"):
        motion = _motion(eqs, end, settings, samples, rtol, atol, bar)
    with bar.stage("drawing"):
        ax = symbody.plot(motion, *(curves or eqs.coordinate_names), title=eqs.model.name)
        symbody.save_plot(ax, picture)
        if csv is not None:
            motion.to_csv(csv, *eqs.coordinate_names, *eqs.speed_names, *(curves or ()), names="outputs")
        pages = [write_motion_page(motion, picture.with_suffix(".html"), curves, None, ())] if page else []
    _print(
        [motion_json(eqs, motion)] if as_json else [*motion_lines(eqs, motion), f"plot: {picture}", *pages]
    )
    _exit_unless_done(motion)


@command()
def animate(
    model: ModelFile,
    end: Annotated[float, option("--end", "--time", "-t", text="End time in s.")] = 10.0,
    parameters: Settings = None,
    inputs: Inputs = None,
    initial: Initials = None,
    curves: Curves = None,
    vectors: Annotated[
        Pairs,
        option("--vectors", metavar="ELEMENT", text="Forces to draw: all, applied, none, names; repeatable."),
    ] = None,
    traces: Annotated[
        Pairs, option("--trace", metavar="POINT", text="Body.frame whose path is drawn; repeatable.")
    ] = None,
    out: Annotated[
        Path | None,
        option("--out", "-o", text="Page; default: next to the model, replaced if symbody wrote it."),
    ] = None,
    show: Annotated[bool, option("--open", text="Open the page in the browser.")] = False,
    live: Annotated[
        bool,
        option("--live", text="Write a live page, which simulates in the browser; bodies can be dragged."),
    ] = False,
    sliders: Annotated[
        Pairs,
        option(
            "--slider", metavar="NAME[=LOW:HIGH]", text="Live slider for a parameter, input or initial value."
        ),
    ] = None,
    tree: Tree = None,
    substitute: Substitute = False,
    force: Force = False,
) -> None:
    """Compute the motion and write a page that shows it in any browser, without a network."""
    target = model.with_suffix(".html") if out is None else out
    refuse_overwriting(target, force, is_default=out is None)
    given = [read_pairs(parameters, "--set"), read_pairs(inputs, "--input"), read_pairs(initial, "--initial")]
    if live or sliders:
        _print(
            [write_live_page(form_file(model, tree, substitute), target, read_sliders(sliders), given, show)]
        )
        return
    bar = StageBar()
    with bar.stage("forming the equations"):
        eqs = form_file(model, tree, substitute)
        settings = Settled.resolve(eqs, *given)
    with bar.stage("compiling"):
        motion = _motion(eqs, end, settings, None, 1e-8, None, bar)
    with bar.stage("drawing"):
        page = write_motion_page(motion, target, curves, vectors, traces or ())
    _print([*motion_lines(eqs, motion), page])
    if show:
        open_page(target)
    _exit_unless_done(motion)


def _check_samples(samples: int | None) -> None:
    if samples is not None and samples < 2:
        raise UsageError(
            Problem("cli.samples", "--samples", f"a motion needs more than {samples} samples", "",
                    "give 2 or more")
        )  # fmt: skip


def _exit_unless_done(motion: Trajectory) -> None:
    if not motion.success:
        raise typer.Exit(130 if motion.status is Status.INTERRUPTED else 4)


@command()
def linearize(
    model: ModelFile,
    at: Annotated[
        Pairs, option("--at", metavar="NAME=VALUE", text="Value of x or x_dot at this state; repeatable.")
    ] = None,
    parameters: Settings = None,
    inputs: Inputs = None,
    outputs: Annotated[
        Pairs, option("--output", "-o", metavar="OUTPUT", text="An output, a row of C and D; repeatable.")
    ] = None,
    independent: Annotated[
        Pairs, option("--independent", metavar="STATE", text="A state to keep; repeatable.")
    ] = None,
    cyclic: Annotated[
        Pairs,
        option("--cyclic", metavar="NAME", text="A cyclic coordinate, on which nothing depends; repeatable."),
    ] = None,
    tree: Tree = None,
    substitute: Substitute = False,
    as_json: Annotated[bool, option("--json", text="Print the result as JSON.")] = False,
) -> None:
    """Print A, B, C, D of small motions about a state, eigenvalues, and whether they are stable."""
    eqs = form_file(model, tree, substitute)
    given = Settled.resolve(
        eqs, read_pairs(parameters, "--set"), read_pairs(inputs, "--input"), read_pairs(at, "--at")
    )
    found = symbody.linearize(
        eqs,
        given.initial,
        given.parameters,
        inputs=given.inputs,
        outputs=outputs or (),
        independent=independent,
        cyclic=cyclic or (),
    )
    _print([linear_json(found)] if as_json else linear_lines(found))


@command()
def equilibrium(
    model: ModelFile,
    near: Annotated[
        Pairs, option("--near", metavar="NAME=VALUE", text="A guess of a coordinate; repeatable.")
    ] = None,
    parameters: Settings = None,
    inputs: Inputs = None,
    unknowns: Annotated[
        Pairs,
        option("--unknown", metavar="INPUT", text="An unknown input that holds the mechanism; repeatable."),
    ] = None,
    fixed: Annotated[
        Pairs, option("--fix", metavar="NAME=VALUE", text="A coordinate to hold fixed; repeatable.")
    ] = None,
    tree: Tree = None,
    substitute: Substitute = False,
    as_json: Annotated[bool, option("--json", text="Print the result as JSON.")] = False,
) -> None:
    """Print the equilibrium nearest to a guess, others found, and whether they are stable."""
    eqs = form_file(model, tree, substitute)
    given = Settled.resolve(
        eqs, read_pairs(parameters, "--set"), read_pairs(inputs, "--input"), read_pairs(near, "--near")
    )
    found = symbody.find_equilibrium(
        eqs,
        given.initial,
        given.parameters,
        inputs=given.inputs,
        unknowns=unknowns or (),
        fixed=read_pairs(fixed, "--fix"),
    )
    _print([equilibrium_json(found)] if as_json else equilibrium_lines(found))


def _motion(
    eqs: EquationSet,
    end: float,
    given: Settled,
    samples: int | None,
    rtol: float,
    atol: float | None,
    bar: StageBar,
) -> Trajectory:
    if samples is not None:
        check_memory(samples, len(eqs.state_names) + 1)
    return symbody.simulate(
        eqs,
        end,
        parameters=given.parameters,
        inputs=given.laws(),
        initial=given.initial,
        times=None if samples is None else np.linspace(0.0, end, samples),
        progress=bar,
        rtol=rtol,
        atol=atol,
    )


def _introduction(eqs: EquationSet, model: Path) -> list[str]:
    """Return the equations if they fit a screen, otherwise where they are."""
    lines = equation_lines(eqs.textbook, width=text_width()) if len(eqs.speed_names) <= MOST_SPEEDS else []
    if lines and len(lines) <= _SCREEN:
        return lines
    numbers = {
        "coordinate": eqs.coordinate_names,
        "speed": eqs.speed_names,
        "constraint": eqs.multiplier_names,
    }
    sizes = ", ".join(number_in_words(len(names), word) for word, names in numbers.items())
    return [f"{sizes}; `symbody equations {model}` prints the equations"]


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        typer.echo(line)


@command()
def builder(
    model: Annotated[Path | None, typer.Argument(metavar="MODEL", help="A model file to open.")] = None,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Print the address only; open no browser.")
    ] = False,
    port: Annotated[int | None, option("--port", text="Port of 127.0.0.1; 0 uses any free port.")] = None,
) -> None:
    """Open the diagram editor in the browser; also called edit."""
    symbody.builder.run_builder("" if model is None else model, port, not no_browser)


command("edit", hidden=True)(builder)
