"""Words under which people look for a page that says it in others: entries of the search of the site."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.logging import getLogger

# By page. Results hold all words of a question, so that "natural frequency" takes both.
WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "code_generation": "export simulink embedded microcontroller",
        "constraints": "cam follower pulley chain pinion",
        "contact": "collision impact touch floor foot bump clearance half-space penalty",
        "film": "video movie record screenshot render picture export",
        "fmu": "cosimulation exchange export",
        "forces": "actuator load gravity spring constant coefficient",
        "friction": "coulomb stiction",
        "how_to/check_a_model": "debug wrong validate verify error",
        "how_to/events_and_friction": "contact collision bumper limit end stop bounce hit",
        "how_to/initial_values": "initial conditions start starting position velocity",
        "how_to/linear_models": "bode nyquist frequency step response open loop margin poles zeros gain",
        "how_to/reactions": "bearing load pin force joint internal",
        "how_to/show_motion": "video movie record animate",
        "index_reduction": "dae differential algebraic",
        "inverse_dynamics": "required torque motor drive constant speed given motion",
        "joints": "hinge pin slider ball cardan hooke rotational translational fixed rigid",
        "kinematic_analysis": "dead center point toggle limit position stroke workspace mechanical advantage",
        "linearization": "natural frequency eigenfrequency resonance modal shape transfer function",
        "how_to/controller": "pid margin design loop shaping step response",
        "how_to/units": "millimeter mm inch degrees kilogram rpm si",
        "model_file": "kilogram center gravity moment default value keyword",
        "plots": "graph chart figure diagram",
        "robots": "arm manipulator panda",
        "signals": "controller saturation servo filter step setpoint dead zone",
        "simulate": "solver integrate run results save export csv excel step size",
        "sweeps": "monte carlo parametric study variation optimization",
        "tutorial/6_equilibrium_and_vibration": "natural frequency resonance modal static rest",
        "tutorial/10_controller": "feedback pid step response balance",
    }
)


def _add_words(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Enter the words of a page as its keywords, which the index of the search holds."""
    if docname in WORDS:
        doctree += nodes.meta(name="keywords", content=", ".join(WORDS[docname].split()))


def _check_pages(app: Sphinx, env: BuildEnvironment) -> None:
    for page in sorted(WORDS.keys() - env.found_docs):
        getLogger(__name__).warning("search_words.py has words for %s, which is no page", page)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the extension."""
    app.connect("doctree-resolved", _add_words)
    app.connect("env-updated", _check_pages)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
