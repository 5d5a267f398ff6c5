"""How Sphinx builds the pages: `make docs`, warnings are errors."""

project = "comotion"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
exclude_patterns = []
html_theme = "furo"
html_title = "comotion"
html_show_copyright = False
myst_heading_anchors = 3
myst_enable_extensions = ["dollarmath"]
suppress_warnings = ["myst.header"]  # decision records begin with their title alone
