"""Pages that the command line writes: of motions, and of mechanisms that simulate themselves."""

from __future__ import annotations

import webbrowser
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import symbody
from symbody.cli.options import Pairs
from symbody.cli.settings import Settled
from symbody.cli.stages import StageBar
from symbody.equations.equation_set import EquationSet
from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.simulation.results.trajectory import Trajectory

Bounds = tuple[float, float]


def write_motion_page(
    motion: Trajectory, path: Path, curves: Pairs, vectors: Pairs, traces: Iterable[str]
) -> str:
    """Write the page of a motion and return the lines to print."""
    chosen = vectors[0] if vectors is not None and len(vectors) == 1 else vectors
    symbody.animate(motion, path, curves=curves, vectors=chosen, traces=tuple(traces))
    return f"page: {path}"


def write_live_page(
    eqs: EquationSet,
    path: Path,
    sliders: Mapping[str, Bounds | None],
    given: Sequence[Mapping[str, str]],
    show: bool,
) -> str:
    """Write a page that simulates a mechanism and return the lines to print.

    Parameters
    ----------
    sliders : mapping of name to (lowest, highest) or None
        Without any, those inputs have one that have no law.
    given : three mappings of name to text
        Of ``--set``, ``--input`` and ``--initial``.
    show : bool
        Whether to open it in the browser.
    """
    settings = Settled.resolve(eqs, *given)
    usual = dict.fromkeys(name for name in eqs.input_names if name not in settings.inputs)
    bar = StageBar()
    with bar.stage("writing the page"):
        symbody.animate(
            eqs, path, live=True, sliders=sliders or usual, initial=settings.initial,
            parameters=settings.parameters, inputs=settings.inputs,
        )  # fmt: skip
    if show:
        open_page(path)
    return f"page: {path}"


def read_sliders(texts: Iterable[str] | None) -> dict[str, Bounds | None]:
    """Return ``NAME`` and ``NAME=LOW:HIGH`` texts as a mapping.

    Raises
    ------
    UsageError
        If one is not of that form.
    """
    sliders: dict[str, Bounds | None] = {}
    for text in texts or ():
        name, equals, bounds = (part.strip() for part in text.partition("="))
        low, colon, high = bounds.partition(":")
        try:
            sliders[name] = (float(low), float(high)) if equals else None
        except ValueError:
            name = ""
        if not name or (equals and not colon):
            raise UsageError(
                Problem("cli.slider", "--slider", f"{text!r} is not of the form NAME or NAME=LOW:HIGH", "",
                        "type for instance --slider m2=0.5:3")
            )  # fmt: skip
    return sliders


def open_page(path: Path) -> None:
    """Open a page in the browser.

    Raises
    ------
    EnvironmentFault
        If there is none.
    """
    if not webbrowser.open(path.resolve().as_uri()):
        fix = f"open {path} manually"
        raise EnvironmentFault(
            Problem("animation.no_browser", str(path), "no browser could be opened", fix=fix)
        )
