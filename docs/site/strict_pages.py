# Pages without scripts and styles inside: `musher view` serves them with the same strict
# Content-Security-Policy as the robot's page, and any web server may.

import hashlib
import os
import re
from pathlib import Path

INLINE = re.compile(r"<(script|style)>(.*?)</\1>", re.DOTALL)


def take_out(app, error):
    if error is not None or app.builder.format != "html":
        return
    root = Path(app.outdir)
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

        replaced = INLINE.sub(replace, text)
        if replaced != text:
            page.write_text(replaced, encoding="utf-8")


def setup(app):
    app.connect("build-finished", take_out)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
