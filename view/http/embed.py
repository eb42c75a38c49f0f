#!/usr/bin/env python3
"""Writes a C++ source with the content of files: embed.py FUNCTION FOLDER OUTPUT FILE...

The function, with its namespace, returns a table of musher::http::Asset. Each path begins with '/'
and is relative to the folder.
"""

import hashlib
import pathlib
import sys

TYPES = {
    ".css": "text/css; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".ico": "image/x-icon",
    ".jpg": "image/jpeg",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".mjs": "text/javascript; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}
LINE = 4096  # bytes of a string literal


def literal(content):
    """C++ string literals of the bytes; octal escapes have three digits and so an end."""
    plain = set(range(0x20, 0x7F)) - set(b'"\\?')
    lines = []
    for begin in range(0, len(content), LINE):
        text = "".join(
            chr(byte) if byte in plain else "\\n" if byte == 0x0A else f"\\{byte:03o}"
            for byte in content[begin:begin + LINE])
        lines.append(f'    "{text}"')
    return "\n".join(lines) or '    ""'


def main():
    function, folder, output, *files = sys.argv[1:]
    name_space, _, name = function.rpartition("::")
    tables = []
    for file in sorted(files):
        path = pathlib.Path(file)
        if path.suffix not in TYPES:
            known = ", ".join(sorted(TYPES))
            sys.exit(f"embed.py: {file}: the type of '{path.suffix}' is not known; known: {known}")
        content = path.read_bytes()
        etag = hashlib.sha256(content).hexdigest()[:16]
        tables.append(
            f'    {{"/{path.relative_to(folder).as_posix()}", "{TYPES[path.suffix]}",\n'
            f'     "\\"{etag}\\"",\n     std::string_view(\n{literal(content)},\n'
            f"         {len(content)})}},\n")
    pathlib.Path(output).write_text(
        "// Made by embed.py.\n#include <array>\n#include <span>\n\n"
        '#include "musher/view/http/assets.hpp"\n\n'
        f"namespace {name_space} {{\n\nstd::span<const musher::http::Asset> {name}() {{\n"
        f"  static constexpr std::array<musher::http::Asset, {len(tables)}> kFiles = {{{{\n"
        f"{''.join(tables)}  }}}};\n  return kFiles;\n}}\n\n}}  // namespace {name_space}\n",
        encoding="utf-8")


if __name__ == "__main__":
    main()
