"""The site that ``make docs`` builds: these pages, the docstrings, the examples as they run, the saved benchmarks."""

from __future__ import annotations

import sys
from pathlib import Path

import holdfast

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_site"), str(HERE.parent / "tools")]

project = "holdfast"
author = "The holdfast authors"
copyright = author
version = release = holdfast.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_gallery.gen_gallery",
    "site_pages",
]
exclude_patterns = ["_site", "_templates", "gallery/*.ipynb", "gallery/*.py"]
templates_path = ["_templates"]
nitpicky = False

myst_enable_extensions = ["html_image"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autosummary_generate = ["files/names.md"]
autosummary_ignore_module_all = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/\d\d_|/notebooks/",
    "within_subsection_order": "FileNameSortKey",
    "reset_argv": "gallery_pictures.arguments",
    "remove_config_comments": True,
    "image_scrapers": ("gallery_pictures.pictures",),
    "capture_repr": ("_repr_html_",),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 3600,
    "write_computation_times": False,
}

html_theme = "furo"
html_title = "holdfast"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
