"""Sphinx configuration of the documentation; ``make docs`` builds it, and a warning is an error."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

from cutgap import formulations

sys.path.insert(0, str(Path(__file__).parent))
from modelling import states_model, with_models

# Its names are loaded on first use, and autodoc only sees what is there.
vars(formulations).update({name: getattr(formulations, name) for name in formulations.__all__})

BAR = re.compile(r"``.*?``|\|")
"""A bar, or a literal, in which bars are left alone."""
LAST_LINE = re.compile(r"\n\n```$", re.MULTILINE)
"""The end of a block with prompts: doctest asks for an empty line after the last output."""

project = "cutgap"
author = "the authors of cutgap"
release = version = version_of("cutgap")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
exclude_patterns = ["build", "lessons/*.ipynb"]

html_theme = "furo"
# The default underlines the names of modules as if they were links.
pygments_dark_style = "github-dark"
html_title = "cutgap"
html_show_sourcelink = False
html_copy_source = False
html_show_copyright = False
html_static_path = ["site.css"]
html_css_files = ["site.css"]
# Links that lead nowhere are warnings, and so errors; names in signatures are not all documented.
nitpicky = True
nitpick_ignore_regex = [(r"py:.*", r".*")]

myst_heading_anchors = 3

# A page is what its cells print today, so nothing is taken from a cache.
nb_execution_mode = "force"
nb_execution_timeout = 300
nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_code_prompt_show = "Show the code"
nb_code_prompt_hide = "Hide the code"
# The default leaves tables out.
nb_render_markdown_format = "myst"
nb_merge_streams = True

autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_ivar = True


def as_written(app: Any, what: str, name: str, obj: object, options: Any, lines: list[str]) -> None:
    """Show the docstring of a module that is a model with aligned equations exactly as it stands.

    Elsewhere a bar is an absolute value, which reStructuredText would take for a substitution.
    """
    if what == "module" and states_model("\n".join(lines)):
        lines[:] = [".. code-block:: text", "", *(f"   {line}" for line in lines), ""]
    else:
        lines[:] = [BAR.sub(lambda bar: bar[0] if bar[0] != "|" else "\\|", line) for line in lines]


def leave_out(app: Any, what: str, name: str, obj: object, skip: bool, options: Any) -> bool | None:
    """Leave out fields of a tuple without a docstring of their own, of which Python tells the number alone."""
    return (getattr(obj, "__doc__", None) or "").startswith("Alias for field number") or None


def prepare(app: Any, docname: str, source: list[str]) -> None:
    """Put the models of the code into the page that asks for them; end blocks at their last line."""
    if docname == "models":
        source[0] = with_models(source[0])
    source[0] = LAST_LINE.sub("\n```", source[0])


def setup(app: Any) -> None:
    """Called by Sphinx."""
    app.connect("source-read", prepare)
    app.connect("autodoc-skip-member", leave_out)
    app.connect("autodoc-process-docstring", as_written)
