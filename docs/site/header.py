# ```{header} actuator/machine_actuator.hpp``` shows how a header is included, and the comment at its top: what it
# is for, an example, its threads and errors.

from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective


def top_comment(text):
    lines = []
    for line in text.splitlines()[1:]:  # behind #pragma once
        if not line.startswith("//"):
            break
        lines.append(line[2:])
    return lines


def as_markdown(lines):
    """Text is indented by one space; what has more, and does not continue a list, is code or a drawing."""
    code, in_list = False, False
    for line in lines:
        text = line[1:] if line.startswith(" ") else line
        indented = text.startswith("  ")
        if text.lstrip().startswith(("- ", "1.", "2.", "3.")):
            in_list = True
        elif text and not indented:
            in_list = False
        if indented and not code and not in_list:
            code = True
            yield "```"
        elif code and text and not indented:
            code = False
            yield "```"
            yield ""
        yield text[2:] if code else text
    if code:
        yield "```"


class Header(SphinxDirective):
    required_arguments = 1

    def run(self):
        name = self.arguments[0]
        path = Path(self.env.srcdir) / name
        if not path.is_file():
            raise self.error(f"there is no {name}")
        self.env.note_dependency(str(path))
        include = f'#include "musher/{name}"'
        block = nodes.literal_block(include, include, language="cpp")
        holder = nodes.container()
        text = list(as_markdown(top_comment(path.read_text(encoding="utf-8"))))
        self.state.nested_parse(StringList(text, source=name), self.content_offset, holder)
        return [block] + holder.children


def setup(app):
    app.add_directive("header", Header)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
