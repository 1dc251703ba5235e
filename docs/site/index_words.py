"""Words that people search for, and the page that the search lists first for each.

They become main entries of the index, which the search ranks above titles, names of the reference and text;
`search_words` has words that a page is found by without being the first.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms import SphinxTransform

_BEFORE_THE_INDEX: Final = 800  # entries are gathered at 850

WORDS: Final[Mapping[str, tuple[str, ...]]] = {
    "animation": ("animate", "animation", "video"),
    "benchmarks": ("benchmark", "speed"),
    "builder": ("builder", "diagram", "editor"),
    "code_generation": ("c code", "fortran", "julia", "matlab", "modelica"),
    "comparison": ("drake", "mujoco", "pinocchio", "pydy", "sympy"),
    "constraints": ("belt", "cam", "constraint", "gear", "rolling"),
    "course/9_virtual_work": ("virtual work",),
    "course/index": ("course", "exercises"),
    "contact": ("collision", "ground contact", "hunt-crossley", "restitution"),
    "dynaflexpro": ("dynaflexpro",),
    "extending": ("extend", "plugin"),
    "forces": ("bushing", "force", "spring", "spring stiffness", "torque"),
    "fmu": ("fmi", "fmu", "simulink"),
    "friction": ("friction", "stick", "stiction"),
    "gallery": ("gallery", "mechanism"),
    "glossary": ("glossary",),
    "how_to/closed_loops": ("assembly", "closed loop", "four-bar", "loop"),
    "how_to/coming_from": ("maplesim", "simscape"),
    "how_to/controller_fmu": ("co-simulation",),
    "how_to/events_and_friction": ("bounce", "contact", "impact", "stop"),
    "how_to/fit_parameters": ("identification", "parameter fit"),
    "how_to/gymnasium_environment": ("gymnasium", "reinforcement learning"),
    "how_to/initial_values": ("initial", "initial values"),
    "how_to/keep_loops_closed": ("baumgarte", "drift"),
    "how_to/linear_models": ("bode", "frequency response", "transfer function"),
    "how_to/massless_bodies": ("massless",),
    "how_to/optimize_a_mechanism": ("optimization", "optimize"),
    "how_to/reactions": ("multiplier", "reaction"),
    "how_to/redundant_constraints": ("overconstrained", "redundant"),
    "how_to/sampled_control": ("discrete", "sample"),
    "how_to/singular_angles": ("euler angles", "gimbal lock"),
    "how_to/stiff_systems": ("stiff",),
    "how_to/units": ("units",),
    "installation": ("install", "pip"),
    "inverse_dynamics": ("inverse dynamics",),
    "joints": ("joint", "prismatic", "quaternion", "revolute", "spherical", "universal"),
    "kinematic_analysis": (
        "dead point",
        "inverse kinematics",
        "kinematics",
        "mechanical advantage",
        "singular",
    ),
    "limits": ("limits",),
    "linearization": ("eigenvalues", "linearize", "modes", "stability"),
    "mbsymba": ("mbsymba",),
    "model_file": ("model file", "toml"),
    "notation": ("jacobian", "mass matrix", "names", "outputs"),
    "notebooks": ("jupyter", "notebook"),
    "plots": ("curves", "plot"),
    "report": ("latex", "report"),
    "ropes": ("pulley", "rope"),
    "signals": ("dc motor", "motor", "pid", "signal"),
    "simulate": ("energy", "events", "integrator", "simulate", "tolerance"),
    "sweeps": ("monte carlo", "sweep"),
    "tutorial/10_controller": ("control", "controller", "lqr"),
    "tutorial/1_spring_mass_damper": ("damper", "gravity", "oscillator"),
    "tutorial/2_double_pendulum": ("pendulum",),
    "tutorial/index": ("start", "tutorial"),
    "urdf": ("robot", "ros", "urdf"),
}


class _IndexWords(SphinxTransform):
    """Puts the words of a page into the index, at its title."""

    default_priority = _BEFORE_THE_INDEX

    def apply(self, **kwargs: Any) -> None:
        words = WORDS.get(self.env.docname, ())
        section = next(iter(self.document.findall(nodes.section)), None)
        if not words or section is None:
            return
        target = section["ids"][0]
        entries = [("single", word, target, "main", None) for word in words]
        section.insert(1, addnodes.index(entries=entries, inline=False))


def setup(app: Sphinx) -> dict[str, bool]:
    """Add the words to each page, once it is read; a page that is not there is an error."""
    app.add_transform(_IndexWords)
    app.connect("env-check-consistency", _look_for_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _look_for_pages(app: Sphinx, env: Any) -> None:
    missing = sorted(WORDS.keys() - env.found_docs)
    if missing:
        raise ValueError(f"docs/site/index_words.py names pages that are not there: {', '.join(missing)}")
