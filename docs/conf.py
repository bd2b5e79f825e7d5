"""How Sphinx builds the site. `.ci/site` builds and checks it."""

import gc
import os
import shutil
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as for commands
gc.set_threshold(50_000, 20, 20)  # as for tests: pages are large trees, which stay

DOCS = Path(__file__).parent
for notebook in (DOCS.parent / "notebooks").glob("*.ipynb"):
    shutil.copy2(notebook, DOCS / "tutorials")  # with its times: Sphinx reads anew what has changed
sys.path.insert(0, str(DOCS / "ext"))

from camopt import __version__  # noqa: E402
from camopt.core.numerics.workspace import keep_freed_memory  # noqa: E402
from camopt.show.drawing.style import RC_SETTINGS  # noqa: E402

keep_freed_memory()

project = "camopt"
author = "The camopt developers"
copyright = author
version = release = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_click",
    "matplotlib.sphinxext.plot_directive",
    "mathml",
    "validation",
    "reference",
]
templates_path = ["templates"]
exclude_patterns = [
    "_build",
    "ext",
    "templates",
    "paper",
    "gallery",
    "examples/**/*.ipynb",
    "examples/**/*.py",
    "examples/**/*.md5",
    "sg_execution_times.rst",
    "**/sg_execution_times.rst",
]
nitpicky = True
nitpick_ignore_regex = [("py:.*", r"(?!camopt\b).*")]  # other packages: their sites are not asked at a build

# notebooks, and pages with a kernel in their head, run at the build: an error or a message there ends it
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist", "attrs_inline", "fieldlist"]
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_in_temp = True
nb_execution_timeout = 900
nb_execution_excludepatterns = ["tutorials/*.ipynb"] if tags.has("quick") else []  # noqa: F821
nb_output_stderr = "warn"
nb_execution_show_tb = True

autosummary_generate = ["reference/python/index.rst"]  # which the extension reference writes
autodoc_typehints = "none"  # the section Parameters tells
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
smartquotes = False  # y'' is a derivative

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"main_job\.py$" if tags.has("quick") else r"\.py$",  # noqa: F821
    "subsection_order": [f"gallery/{room}" for room in ("cams", "smallest", "laws", "loads", "part")],
    "image_scrapers": ("matplotlib", "sheets.scrape"),
    "reset_modules": ("matplotlib", "sheets.dress"),
    "abort_on_example_error": True,
    "download_all_examples": False,
    "copyfile_regex": r"",
    "ignore_repr_types": "matplotlib|EmptyFigure|list|tuple",
    "thumbnail_size": (480, 336),
    "parallel": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 3,
    "remove_config_comments": True,
}

plot_formats = [("png", 180)]
plot_rcparams = RC_SETTINGS
plot_apply_rcparams = True
plot_html_show_formats = False
plot_html_show_source_link = False

html_math_renderer = "mathml"
html_title = "camopt"
html_theme = "pydata_sphinx_theme"
html_static_path = ["static"]
html_css_files = ["camopt.css"]
html_theme_options = {
    "logo": {"text": "camopt"},
    "icon_links": [],
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "tango",
    "pygments_dark_style": "github-dark",
    "navigation_with_keys": True,
    "header_links_before_dropdown": 6,
}
html_sidebars = {page: [] for page in ("index", "architecture", "nomenclature", "cheat-sheet", "changelog")}
html_show_sourcelink = False
html_copy_source = False
html_domain_indices = False
