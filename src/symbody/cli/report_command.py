"""``symbody report``: the derivation of a mechanism as a page, LaTeX, Markdown or a notebook."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from symbody.cli.forming import form_file
from symbody.cli.options import Force, Initials, Inputs, ModelFile, Pairs, Settings, Substitute, Tree, option
from symbody.cli.overwriting import refuse_overwriting
from symbody.cli.settings import Settled, read_pairs
from symbody.cli.stages import StageBar
from symbody.errors import Problem, UsageError
from symbody.report.save_report import SECTIONS, save_report
from symbody.simulation.simulate import simulate


def report(
    model: ModelFile,
    out: Annotated[
        Path | None,
        option("--out", "-o", text=".html, .tex, .md or .ipynb; default: a page next to the model."),
    ] = None,
    end: Annotated[float | None, option("--end", "-t", text="Include a motion up to this time in s.")] = None,
    sections: Annotated[
        Pairs, option("--section", metavar="NAME", text=f"{', '.join(SECTIONS)}; repeatable. Default: all.")
    ] = None,
    title: Annotated[str | None, option("--title", text="Title; default: the name of the model.")] = None,
    template: Annotated[
        Path | None,
        option("--template", metavar="FILE", text="Template file around the report, with {{ body }} in it."),
    ] = None,
    parameters: Settings = None,
    inputs: Inputs = None,
    initial: Initials = None,
    tree: Tree = None,
    substitute: Substitute = False,
    force: Force = False,
) -> None:
    """Write the derivation of a mechanism in the order of a textbook."""
    target = model.with_suffix(".html") if out is None else out
    refuse_overwriting(target, force)
    if end is None and "motion" in (sections or ()):
        what = "there is no motion to show"
        raise UsageError(
            Problem("report.no_motion", "--section motion", what, fix="add --end with a time in s")
        )
    bar = StageBar()
    with bar.stage("forming the equations"):
        eqs = form_file(model, tree, substitute)
        pairs = [
            read_pairs(parameters, "--set"),
            read_pairs(inputs, "--input"),
            read_pairs(initial, "--initial"),
        ]
        given = Settled.resolve(eqs, *pairs)
    run = None
    if end is not None:
        with bar.stage("computing the motion"):
            run = simulate(
                eqs, (0.0, end), parameters=given.parameters, inputs=given.laws(), initial=given.initial
            )
    with bar.stage("writing"):
        save_report(
            eqs, target, run, sections=sections, parameters=given.parameters, title=title, template=template
        )
    typer.echo(str(target))
