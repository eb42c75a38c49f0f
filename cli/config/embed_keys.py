"""Writes a C++ file with the keys of a state config as docs/reference.md explains them.

embed_keys.py REFERENCE.md OUT.cpp
"""

import json
import re
import sys

ROW = re.compile(r"^\| (.*) \|$")
KEY = re.compile(r"(?:`(\[[^`]*\])` ?)?(?:`([a-z_0-9]+)`)?$")


def plain(text: str) -> str:
    """Markdown as a terminal shows it: links as their text."""
    return re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text).replace("\\|", "|").strip()


def keys(reference: str):
    section = reference[reference.index("\n## State config"):]
    section = section[:section.index("\n## ", 5)]
    heading = ""
    for line in section.split("\n"):
        if line.startswith("### "):
            tables = re.findall(r"`(\[[^`]*\])`", line)
            heading = tables[0] if len(tables) == 1 else ""
        row = ROW.match(line)
        cells = re.split(r"(?<!\\)\|", row[1]) if row else []
        key = KEY.match(cells[0].strip()) if len(cells) == 4 else None
        if not key or not (key[1] or key[2]):
            continue
        yield [key[1] or heading, key[2] or "", *(plain(cell) for cell in cells[1:])]


def main() -> None:
    reference, out = sys.argv[1:]
    with open(reference, encoding="utf-8") as file:
        rows = list(keys(file.read()))
    if len(rows) < 80:
        sys.exit(f"{reference}: only {len(rows)} keys of a state config were found")
    with open(out, "w", encoding="utf-8") as file:
        file.write('#include "musher/cli/config/key_reference.hpp"\n\n')
        file.write("namespace musher::cli {\n\nconst std::vector<KeyReference>& AllKeys() {\n")
        file.write("  static const auto* const keys = new std::vector<KeyReference>{\n")
        for row in rows:
            file.write("      {" + ", ".join(json.dumps(cell, ensure_ascii=False) for cell in row) + "},\n")
        file.write("  };\n  return *keys;\n}\n\n}  // namespace musher::cli\n")


if __name__ == "__main__":
    main()
