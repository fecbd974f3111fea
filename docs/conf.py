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
    "sphinx_gallery.gen_gallery",
    "site_pages",
]
exclude_patterns = ["_site", "gallery/*.ipynb", "gallery/*.py"]
nitpicky = False
suppress_warnings = ["misc.highlighting_failure"]  # JSON with parts left out

myst_enable_extensions = ["html_image"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Bool", "EngineChoice", "Float", "Int")}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"

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
