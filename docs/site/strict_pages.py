# Pages without scripts and styles inside: `musher view` serves them with the same strict
# Content-Security-Policy as the robot's page, and any web server may.

import hashlib
import os
import re
from pathlib import Path

# Debian's package of the theme has its script as a module, which imports one that is none, and takes a style
# sheet from another package by a path that only Debian's web servers have.
MODULE = re.compile(r'<script (src="[^"]*_static/scripts/furo.js")>')
PLAIN = 'import Gumshoe from "./gumshoe-patched.js";'
IMPORT = re.compile(r"@import url\((/javascript/[^)]*)\);")
HIDDEN = '<svg xmlns="http://www.w3.org/2000/svg" style="display: none;">'

INLINE = re.compile(r"<(script|style)>(.*?)</\1>", re.DOTALL)


def take_out(app, error):
    if error is not None or app.builder.format != "html":
        return
    root = Path(app.outdir)
    script = root / "_static" / "scripts" / "furo.js"
    script.write_text(script.read_text(encoding="utf-8").replace(
        PLAIN, 'import "./gumshoe-patched.js";\nconst Gumshoe = window.Gumshoe;'), encoding="utf-8")
    for sheet in root.glob("_static/**/*.css"):
        text = sheet.read_text(encoding="utf-8")
        if IMPORT.search(text):
            sheet.write_text(IMPORT.sub(lambda found: Path("/usr/share" + found[1]).read_text(encoding="utf-8"), text),
                             encoding="utf-8")
    for page in root.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        up = os.path.relpath(root / "_static", page.parent)

        def replace(match):
            kind, content = match[1], match[2]
            suffix = {"script": "js", "style": "css"}[kind]
            name = f"inline-{hashlib.sha256(content.encode()).hexdigest()[:12]}.{suffix}"
            (root / "_static" / name).write_text(content, encoding="utf-8")
            if kind == "script":
                return f'<script src="{up}/{name}"></script>'
            return f'<link rel="stylesheet" href="{up}/{name}">'

        replaced = INLINE.sub(replace, text).replace(HIDDEN, HIDDEN.replace('style="display: none;"', 'class="icons"'))
        replaced = MODULE.sub(r'<script type="module" \1>', replaced)
        if replaced != text:
            page.write_text(replaced, encoding="utf-8")


def setup(app):
    app.connect("build-finished", take_out)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
