# The site of Musher's documentation. The Markdown files stay where they are and as they are: the
# source folder is the whole tree, of which only the pages are read.
#
#   cmake --build --preset dev --target docs      build/dev/docs/html

import os
import sys
from pathlib import Path

site = Path(__file__).resolve().parent
sys.path.insert(0, str(site))

project = "Musher"
author = "the authors of Musher"
copyright = author
version = release = os.environ.get("MUSHER_VERSION", "")
language = "en"

extensions = ["myst_parser", "sphinx_copybutton", "contents", "diagrams", "source_pages",
              "search_words", "strict_pages", "header", "python_reference"]
root_doc = "docs/README"
include_patterns = ["*.md", "controller/**", "docs/**", "examples/**", "lifecycle/**", "messages/**", "modules/**",
                    "navigation/**", "test/**", "view/**"]
exclude_patterns = ["build", "**/node_modules", ".*", "examples/new_*"]  # those are templates of `musher new`
source_suffix = {".md": "markdown"}

myst_heading_anchors = 4
smartquotes = False  # comments and docstrings have commands and code: --json, "Active"
suppress_warnings = ["myst.header"]  # a module's page may begin at any level of heading

# The reference of the C++ classes, from the XML that Doxygen has made of the installed headers.
xml = os.environ.get("MUSHER_DOXYGEN_XML")
if xml:
    extensions.append("breathe")
    breathe_projects = {"musher": xml}
    breathe_default_project = "musher"
    breathe_show_include = False
    breathe_domain_by_extension = {"hpp": "cpp"}
    primary_domain = "cpp"
    highlight_language = "none"
else:
    exclude_patterns.append("docs/api")

# Where the repository is read in a browser, "https://host/owner/musher/blob/main"; empty: the site links to
# its own copies only.
source_base_url = os.environ.get("MUSHER_SOURCE_URL", "")

copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True

html_title = "Musher"
html_theme = "furo"
templates_path = ["templates"]
html_static_path = ["static"]
html_css_files = ["site.css"]
html_js_files = []
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_domain_indices = False
html_use_index = False
html_permalinks_icon = "#"
pygments_style = "friendly"
pygments_dark_style = "monokai"
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#a33b00", "color-brand-content": "#a33b00"},
    "dark_css_variables": {"color-brand-primary": "#ff9f5a", "color-brand-content": "#ff9f5a"},
}
