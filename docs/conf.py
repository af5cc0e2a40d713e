"""Sphinx builds the site of these pages and of the docstrings: ``make docs``."""

from importlib.metadata import version as version_of
from typing import Any

project = "tool0"
author = "The tool0 developers"
copyright = author
version = release = version_of("tool0")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
]
exclude_patterns = ["images"]
default_role = "code"
html_theme = "furo"
html_title = f"tool0 {version}"
html_copy_source = False

myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4

add_module_names = False
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
napoleon_use_rtype = False


def _keep_colons(_app: object, what: str, *others: Any) -> None:
    """Keep napoleon from taking the words before a colon for the type of a field."""
    if what in ("attribute", "data", "property"):
        others[-1].insert(0, "")


def setup(app: Any) -> None:
    """Connect before napoleon, whose priority is 500."""
    app.connect("autodoc-process-docstring", _keep_colons, priority=400)
