"""The documentation site: `python -m sphinx -W docs build/site`, from the root of the repository.

Pages are the Markdown files of this folder, in the order of index.md. What is written by hand stands there alone; the
settings of all plugins (reference/), the functions of the Python API and the picture of the rooms are made from the code
when the site is built. The site loads nothing from the network, when it is built or read.
"""

import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS.parent), str(DOCS / "extensions")]

project = "ksmea-bench"
author = "The ksmea-bench authors"
copyright = author
language = "en"

extensions = ["myst_parser", "sphinx.ext.autodoc", "docstrings", "filled_pages", "mathml", "pictures"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["examples", "extensions", "figures"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4  # as GitHub makes them, so that [links](page.md#to-a-heading) hold in both places
myst_links_external_new_tab = False

nitpicky = True
nitpick_ignore_regex = [
    # Types of other libraries, whose pages lie on the network, and of the inner modules, which have none.
    (r"py:.*", r"(np|numpy|pd|pandas|matplotlib|pathlib|collections|contextlib|typing|dataclasses|abc)(\..*)?"),
    (r"py:.*", r"(Axes|Figure|Path|Any|Mapping|Sequence|Callable|ClassVar|Generic|Self|Iterable|Iterator)"),
    (r"py:.*", r"(ksmea|bench)\.[a-z_]+(\..*)?"),
    (
        r"py:.*",
        r".*(Array|Record|Indices|Seen|Data|Seed|Streams|Observable|Layout|Load|Parameters?|Mode|Campbell|Campaign)",
    ),
    (r"py:exc", r"(BudgetSpent|Unsuited)"),  # in inner modules
    (r"py:.*", r"(optional|ndarray|array|dtype.*|float64|complex128|AbstractContextManager|ABC)"),
]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
add_module_names = False
maximum_signature_line_length = 100
toc_object_entries = False

html_theme = "furo"
html_title = "ksmea-bench"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("copy.js", {"defer": "defer"})]
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
pygments_style = "tango"
pygments_dark_style = "monokai"
