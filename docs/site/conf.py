"""Settings of the documentation site: ``python -m sphinx -W -b html -c docs/site docs docs/_build``."""

from __future__ import annotations

import sys
from pathlib import Path

import symbody

sys.path.insert(0, str(Path(__file__).parent))

project = "symbody"
author = "The symbody authors"
copyright = author  # noqa: A001, the name Sphinx reads
release = version = symbody.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "moving_pictures",
    "dark_pictures",
    "generated_pages",
    "heading_levels",
    "index_words",
    "search_words",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["site", "_build"]
nitpicky = False

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_fence_as_directive = ["math"]  # GitHub typesets blocks in math, too
myst_heading_anchors = 4

napoleon_google_docstring = False
napoleon_numpy_docstring = True
napoleon_use_rtype = False
napoleon_use_ivar = True
napoleon_use_param = False  # types of arguments are sentences; they are no references
autodoc_typehints = "none"  # the docstrings give types, shapes and units
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = "symbody"
_PAGES = "../../src/symbody/display"
html_static_path = ["static", f"{_PAGES}/maths.css", f"{_PAGES}/maths.woff2"]  # formulas as in pages
html_css_files = ["maths.css", "symbody.css"]
html_js_files = ["accessible.js", "search_text.js"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
suppress_warnings = ["ref.python"]  # an attribute "name" of one class is no reference to that of another
