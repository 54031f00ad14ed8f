"""Settings of Sphinx. Neither the build nor the pages need a network."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from pydantic import BaseModel

import longball

# The report's pages are part of the documentation. Sphinx reads what lies in its own folder.
HERE = Path(__file__).parent
shutil.copytree(
    HERE.parent / "report",
    HERE / "report",
    ignore=shutil.ignore_patterns("sections", ".resume"),
    dirs_exist_ok=True,
)

project = "longball"
author = "The longball authors"
project_copyright = "The longball authors"
version = release = longball.__version__

extensions = [
    "matplotlib.sphinxext.plot_directive",
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx-mathjax-offline",
]
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
default_role = "code"  # as docstrings write names
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
suppress_warnings = ["myst.header"]  # an included page begins with a heading of its own

# The gallery shows its code and pictures, without links to files of either.
plot_include_source = True
plot_html_show_source_link = plot_html_show_formats = False
plot_formats = [("png", 150)]

exclude_patterns = ["_build"]

html_theme = "furo"
html_title = "longball"
html_static_path = ["_static"]
html_css_files = ["longball.css"]


def escape_bars(
    _app: Any, _what: str, _name: str, it: Any, _options: Any, lines: list[str]
) -> None:
    """Let |x| of a field's description be that, and no substitution."""
    if isinstance(it, type) and issubclass(it, BaseModel):
        lines[:] = [x.replace("|", r"\|") if x.startswith("    ") else x for x in lines]


def link_to_copied_report(_app: Any, page: str, source: list[str]) -> None:
    """Rewrite links between docs and report for the copy of the report inside docs."""
    if page.startswith("report/"):
        source[0] = source[0].replace("](../docs/", "](../")
    else:
        source[0] = source[0].replace("](../report/", "](report/")


def setup(app: Any) -> None:
    """Let `escape_bars` come before numpydoc, which moves the lines."""
    app.connect("autodoc-process-docstring", escape_bars, priority=400)
    app.connect("source-read", link_to_copied_report)
