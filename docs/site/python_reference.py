# ```{python_reference} python/musher/_machine.py Machine Outcome``` shows these classes, functions and objects of a
# file of the Python package: signatures and docstrings. It reads the file and imports nothing, so the site needs no
# built extension. Classes of the extension ("Tick = _native.FsmTick") are read from its stub.

import ast
import inspect
import json
import re
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective


def module_of(path):
    """The module from which a user imports what is in this file."""
    return "musher" if path.stem.startswith("_") else f"musher.{path.stem}"


def as_markdown(docstring):
    """A docstring as Markdown: what is indented is code in both; <name> is no HTML."""
    for line in inspect.cleandoc(docstring or "").splitlines():
        parts = line.split("`")
        if not line.startswith("    "):
            parts[::2] = [part.replace("<", "&lt;").replace("*", "\\*").replace("_", "\\_") for part in parts[::2]]
        yield "`".join(parts)


def type_text(annotation):
    """A type; one in quotes, as a class that is defined later has it, without them."""
    return annotation.value if isinstance(annotation, ast.Constant) else ast.unparse(annotation)


def signature(function, skip):
    """(name: str = "") -> None; without the first `skip` arguments."""
    arguments = function.args
    arguments.args = arguments.args[skip:]
    for argument in arguments.args + arguments.kwonlyargs:
        if argument.annotation is not None:
            argument.annotation = ast.Name(type_text(argument.annotation))
    returns = f" -> {type_text(function.returns)}" if function.returns is not None else ""
    return f"({ast.unparse(arguments)}){returns}"


def target_of(node):
    return node.target if isinstance(node, ast.AnnAssign) else node.targets[0]


def with_stub(path):
    """The text of a file, and behind it the stub of the extension with the names that the file gives its classes."""
    text = path.read_text(encoding="utf-8")
    stub = path.with_name("_native.pyi").read_text(encoding="utf-8")
    for name, native in re.findall(r"^(\w+) = _native\.([A-Z]\w+)$", text, re.MULTILINE):
        stub = re.sub(rf"\b{native}\b", name, stub)
    return text + stub


def described(kind, head, options, inside, fence="````"):
    return [f"{fence}{{py:{kind}}} {head}", *options, "", *inside, "", fence]


class Reference:
    def __init__(self, path):
        text = with_stub(path)
        self.lines = text.splitlines()
        self.tree = ast.parse(text)

    def text(self, name):
        """What the file calls `name`; None if there is no such thing."""
        for node in self.tree.body:
            if isinstance(node, ast.ClassDef) and node.name == name:
                return self.class_(node)
            if isinstance(node, ast.FunctionDef) and node.name == name:
                return self.function(node)
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name and not self.is_native(node):
                return self.attribute(node, name, "data")
        return None

    @staticmethod
    def is_native(node):
        return ast.unparse(node.value).startswith("_native.")

    def comment(self, node):
        """Of an attribute: behind it, or in the lines above that begin with #:."""
        behind = self.lines[node.end_lineno - 1][node.end_col_offset:].partition("#")[2].strip(": ")
        above, line = [], node.lineno - 2
        while self.lines[line].strip().startswith("#:"):
            above.insert(0, self.lines[line].strip()[2:].strip())
            line -= 1
        return behind or " ".join(above)

    def attribute(self, node, name, kind="attribute"):
        options = []
        if isinstance(node, ast.AnnAssign):
            options.append(f":type: {json.dumps(type_text(node.annotation))}")
        if isinstance(node.value, ast.Constant):
            options.append(f":value: {json.dumps(ast.unparse(node.value))}")
        return described(kind, name, options, as_markdown(self.comment(node)))

    def function(self, node):
        docstring = as_markdown(ast.get_docstring(node, clean=False))
        return described("function", node.name + signature(node, 0), [], docstring)

    def method(self, node):
        decorators = [ast.unparse(decorator) for decorator in node.decorator_list]
        docstring = as_markdown(ast.get_docstring(node, clean=False))
        if "property" in decorators:
            return described("property", node.name, [f":type: {json.dumps(type_text(node.returns))}"], docstring)
        options = [f":{decorator}:" for decorator in decorators if decorator in ("staticmethod", "classmethod")]
        head = node.name + signature(node, 0 if "staticmethod" in decorators else 1)
        return described("method", head, options, docstring)

    def class_(self, node):
        head, inside, attributes = node.name, list(as_markdown(ast.get_docstring(node, clean=False))), set()
        bases = [ast.unparse(base) for base in node.bases if not ast.unparse(base).startswith("Generic[")]
        if bases:
            inside += ["", "Derived from " + ", ".join(f"`{base}`" for base in bases) + "."]
        for member in node.body:
            inside.append("")
            if isinstance(member, (ast.Assign, ast.AnnAssign)):
                name = ast.unparse(target_of(member))
                attributes.add(name)
                if not name.startswith("_"):
                    inside += self.attribute(member, name)
            elif isinstance(member, ast.FunctionDef) and member.name == "__init__":
                member.returns = None
                head += signature(member, 1)
                for line in member.body:
                    name = ast.unparse(target_of(line)) if isinstance(line, (ast.Assign, ast.AnnAssign)) else ""
                    own = name.removeprefix("self.")
                    if name != own and not own.startswith("_") and own not in attributes:
                        inside += self.attribute(line, own)
            elif isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                inside += self.method(member)
        return described("class", head, [], inside, "`````")


class PythonReference(SphinxDirective):
    required_arguments = 1
    optional_arguments = 1
    final_argument_whitespace = True

    def run(self):
        name, names = self.arguments[0], " ".join(self.arguments[1:]).split()
        path = Path(self.env.srcdir) / name
        if not path.is_file():
            raise self.error(f"there is no {name}")
        self.env.note_dependency(str(path))
        reference = Reference(path)
        text = ["```{py:currentmodule} " + module_of(path), "```", "",
                *as_markdown(ast.get_docstring(reference.tree, clean=False))]
        for wanted in names:
            definition = reference.text(wanted)
            if definition is None:
                raise self.error(f"{name} has no {wanted}")
            text += ["", *definition]
        holder = nodes.container()
        self.state.nested_parse(StringList(text, source=name), self.content_offset, holder)
        return holder.children


def setup(app):
    app.add_directive("python_reference", PythonReference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
