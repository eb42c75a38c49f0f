# Diagrams of the Markdown, in Mermaid's language, as pictures of Graphviz inside the page: no script draws
# them, and they have the colours of the page. What is used of the language: flowchart, stateDiagram-v2, and
# sequenceDiagram, which becomes a list of its messages.

import html
import re
import subprocess

from docutils import nodes
from sphinx.transforms import SphinxTransform
from sphinx.util import logging

logger = logging.getLogger(__name__)

NODE = r'(\w+)(?:\["?(.*?)"?\]|\[\((.*?)\)\]|\{(.*?)\})?'
EDGE = re.compile(rf'^{NODE}\s+(?:(<?)--\s+"?(.*?)"?\s+(-->|---)|(-->))\s+(.*)$')
LONE = re.compile(rf"^{NODE}$")
STATE = re.compile(r'^state "(.*)" as (\w+)$')
STEP = re.compile(r"^(\[\*\]|\w+)\s*-->\s*(\[\*\]|\w+)\s*(?::\s*(.*))?$")
MESSAGE = re.compile(r"^(\w+)\s*-?->>\s*(\w+):\s*(.*)$")
HEAD = ('digraph {{ rankdir={}; bgcolor=transparent; node [shape=box, style=rounded, fontname="sans-serif", '
        'fontsize=11, height=0.3]; edge [fontname="sans-serif", fontsize=10, arrowsize=0.7];\n')


def quoted(text):
    return '"' + text.replace("<br/>", "\\n").replace('"', '\\"') + '"'


def flowchart(lines):
    names, edges = {}, []

    def name(key, *labels):
        label = next((label for label in labels if label), None)
        if label or key not in names:
            names[key] = label or names.get(key, key)

    for line in lines:
        while match := EDGE.match(line):
            both, label, arrow = match[5], match[6], match[7] or match[8]
            name(*match.group(1, 2, 3, 4))
            line = match[9]
            following = re.match(NODE, line)
            extra = ", dir=both" if both else ", dir=none" if arrow == "---" else ""
            edges.append(f"{match[1]} -> {following[1]} [label={quoted(label or '')}{extra}]")
        lone = LONE.match(line)
        if not lone:
            raise ValueError(line)
        name(*lone.group(1, 2, 3, 4))
    return [f"{key} [label={quoted(label.strip('()'))}]" for key, label in names.items()] + edges


def states(lines):
    labels, edges, points = {}, [], set()
    for line in lines:
        if line.startswith(("classDef", "class ", "direction")):
            continue
        if match := STATE.match(line):
            labels[match[2]] = match[1]
        elif match := STEP.match(line):
            ends = ["begin" if match[1] == "[*]" else match[1], "end" if match[2] == "[*]" else match[2]]
            points.update(end for end in ends if end in ("begin", "end"))
            edges.append(f"{ends[0]} -> {ends[1]} [label={quoted(match[3] or '')}]")
        else:
            raise ValueError(line)
    shapes = {"begin": "shape=circle, style=filled, fillcolor=black", "end": "shape=doublecircle"}
    return ([f'{point} [label="", width=0.15, height=0.15, {shapes[point]}]' for point in sorted(points)] +
            [f"{key} [label={quoted(label)}]" for key, label in labels.items()] + edges)


def messages(lines):
    names = {}
    items = []
    for line in lines:
        if line.startswith("participant "):
            key, _, label = line[len("participant "):].partition(" as ")
            names[key] = label or key
        elif match := MESSAGE.match(line):
            sender, receiver = (html.escape(names.get(key, key)) for key in (match[1], match[2]))
            who = sender if sender == receiver else f"{sender} → {receiver}"
            items.append(f"<li><b>{who}</b>: {html.escape(match[3])}</li>")
        else:
            raise ValueError(line)
    return '<ol class="messages">' + "".join(items) + "</ol>"


def drawing(text):
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    kind, rest = lines[0], lines[1:]
    if kind == "sequenceDiagram":
        return messages(rest)
    if kind.startswith("flowchart"):
        dot = HEAD.format(kind.split()[1]) + ";\n".join(flowchart(rest))
    else:
        dot = HEAD.format("LR" if "direction LR" in rest else "TB") + ";\n".join(states(rest))
    made = subprocess.run(["dot", "-Tsvg"], input=dot + "\n}\n", capture_output=True, text=True, check=True)
    svg = made.stdout[made.stdout.index("<svg"):]
    return '<div class="diagram">' + re.sub(r"<!--.*?-->\s*|<title>.*?</title>\s*", "", svg, flags=re.DOTALL) + "</div>"


class DrawDiagrams(SphinxTransform):
    default_priority = 400

    def apply(self, **kwargs):
        for block in list(self.document.findall(nodes.literal_block)):
            if block.get("language") != "mermaid":
                continue
            try:
                picture = drawing(block.astext())
            except (ValueError, IndexError, TypeError) as error:
                logger.warning("a diagram has a line that is not understood: %s", error, location=block)
                continue
            except FileNotFoundError:
                logger.warning("a diagram is not drawn: 'dot' of the package graphviz is missing", location=block)
                continue
            block.replace_self(nodes.raw("", picture, format="html"))


def setup(app):
    app.add_transform(DrawDiagrams)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
