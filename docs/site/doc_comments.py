#!/usr/bin/env python3
"""Copies the headers that the pages of docs/api name to a folder, with comments as Doxygen reads them.

    doc_comments.py SOURCE OUT

Comments of Musher are plain text in "//": what stands before a declaration belongs to it, and so does what
follows on its line. Nothing in them is a command of Doxygen or HTML.
"""

import re
import sys
from pathlib import Path

HEADER = re.compile(r"^```\{header\} (\S+)$", re.MULTILINE)
OPENING = re.compile(r"^(\s*)//( ?)(.*)$")
TRAILING = re.compile(r"^(.*[^\s/].*?[;,{}>)\w\"])(\s+)// (.*)$")


def literal(text):
    return re.sub(r"`([^`]+)`", r"<tt>\1</tt>", re.sub(r"([\\@<>#%&\"])", r"\\\1", text))


def converted(text):
    lines, head, trailing_at = [], True, None
    for line in text.splitlines():
        opening = OPENING.match(line)
        if head and (opening or line == "#pragma once" or not line.strip()):
            lines.append("")  # the page shows the comment of the file itself
            continue
        head = False
        if opening:
            continues = trailing_at is not None and len(opening[1]) >= trailing_at
            if not continues:
                trailing_at = None
            lines.append(f"{opening[1]}{'///<' if continues else '///'} {literal(opening[3])}")
            continue
        trailing_at = None
        trailing = TRAILING.match(line)
        if trailing and not line.lstrip().startswith("#") and "namespace" not in trailing[1]:
            trailing_at = len(trailing[1]) + len(trailing[2])
            line = f"{trailing[1]}{trailing[2]}///< {literal(trailing[3])}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def main(source, out):
    pages = sorted((source / "docs" / "api").glob("*.md"))
    headers = {name for page in pages for name in HEADER.findall(page.read_text(encoding="utf-8"))}
    for name in sorted(headers):
        if not (source / name).is_file():
            sys.exit(f"doc_comments: docs/api names {name}, which does not exist")
        target = out / name
        text = converted((source / name).read_text(encoding="utf-8"))
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
