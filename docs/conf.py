"""The documentation site: `scripts/docs` builds it. Everything it shows, it holds itself."""

import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "_ext")]

import viscache  # noqa: E402

project = "viscache"
author = "The viscache authors"
project_copyright = "The viscache authors, Apache-2.0"
version = release = viscache.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "signatures",
    "source_pages",
    "figure_gallery",
    "missed_goals",
    "notebook_list",
    "self_contained",
]
exclude_patterns = ["_ext"]

# Prose: Markdown, with links to every heading
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3

# API: signatures from the code, the rest from numpy docstrings
autodoc_default_options = {"members": True, "member-order": "bysource"}
autodoc_typehints = "signature"
autodoc_preserve_defaults = False  # signatures of `of_shot` have no source
autodoc_class_signature = "mixed"
napoleon_google_docstring = False
napoleon_use_rtype = False
python_maximum_signature_line_length = 88
add_module_names = False
# `c_e` in a docstring is a link where it names something on these pages, else code
default_role = "py:known"

# References must resolve, except for types that other packages document
nitpicky = True
nitpick_ignore_regex = [
    ("py:obj", ".*"),
    ("py:exc", ".*"),
    ("py:class", r"(?!viscache\.).*"),
    ("py:class", r"viscache\.settings\.vismaps\.RecordCache"),
    ("py:class", r"viscache\.(_core|scenes\.builder)\.(?!Camera$).*"),
]

html_theme = "furo"
html_title = f"viscache {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True, "top_of_page_buttons": []}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
pygments_style = "friendly"
pygments_dark_style = "monokai"

# Results of `viscache reproduce all -o DIR` to show in the gallery
viscache_figures = os.environ.get("VISCACHE_DOCS_FIGURES", "")
# Notebooks with outputs that `scripts/run_notebooks.py DIR` made
viscache_notebooks = os.environ.get("VISCACHE_DOCS_NOTEBOOKS", "")
