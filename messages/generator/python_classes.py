"""The Python classes of all interfaces: <package>/msg.py, srv.py, action.py below the package `musher`.

A class names its fields for the codec (python/native/codec.hpp): name, type, count (0: one, -1: a sequence), and
its constructor takes them with their defaults, so that editors and type checkers know them.
"""

import keyword

import idl

ARRAYS = {"int8": "b", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
          "float": "f", "double": "d"}
BYTES = ("uint8", "octet")
def attribute(field):
    """A keyword of Python gets an underscore: `from_`."""
    return field.name + ("_" if keyword.iskeyword(field.name) else "")


HEAD = "# Made from the IDL in messages/ when Musher is built; do not edit.\n"


def scalar_default(field):
    if field.default is not None:
        text = field.default
        if field.type.base == "boolean":
            return {"TRUE": "True", "FALSE": "False"}.get(text.upper(), text)
        return text if field.type.base == "string" else {"NAN": 'float("nan")'}.get(text.upper(), text)
    if field.type.base == "string":
        return '""'
    if field.type.base == "boolean":
        return "False"
    return "0.0" if field.type.base in ("float", "double") else "0"


class Module:
    """The classes of one package and kind."""

    def __init__(self, package, kind, structs):
        self.package, self.kind, self.structs = package, kind, structs
        self.imports, self.classes, self.names = set(), [], []

    def reference(self, dds_name):
        """The expression for the class of a struct."""
        struct = self.structs[dds_name]
        name, part = idl.part_of(struct)
        path = name + {"Request": ".Request", "Response": ".Response", "": ""}.get(part, "." + part)
        if struct.kind == "action" and part.startswith(("SendGoal_", "GetResult_")):
            path = f"{name}.{part.replace('_', '.')}"
        if (struct.package, struct.kind) == (self.package, self.kind):
            return path
        self.imports.add((struct.package, struct.kind))
        return f"_{struct.package}_{struct.kind}.{path}"

    def annotation(self, field):
        kind = field.type
        one = {"string": "str", "boolean": "bool", "float": "float", "double": "float"}.get(kind.base, "int")
        if kind.nested:
            one = self.reference(kind.base)
        if not kind.sequence and not kind.length:
            return one
        if kind.base in BYTES:
            return "Bytes"
        return f"Sequence[{one}]"

    def default(self, field):
        """(default in the signature, expression of the value where it is None)"""
        kind = field.type
        if not kind.sequence and not kind.length:
            return (None, f"{self.reference(kind.base)}()") if kind.nested else (scalar_default(field), None)
        if kind.base in BYTES:
            return (f"bytes({kind.length})" if kind.length else 'b""'), None
        if kind.base in ARRAYS:
            return None, f'array("{ARRAYS[kind.base]}", bytes({kind.length} * array("{ARRAYS[kind.base]}").itemsize))'
        if kind.length:
            one = f"{self.reference(kind.base)}()" if kind.nested else scalar_default(field)
            return None, f"[{one} for _ in range({kind.length})]"
        return None, "[]"

    def constants(self, constants, indent):
        lines = []
        for item in constants.items if constants else []:
            kind = {"string": "str", "boolean": "bool", "float": "float", "double": "float"}.get(item.type, "int")
            value = {"TRUE": "True", "FALSE": "False"}.get(item.value, item.value)
            lines.append(f"{indent}{item.name}: ClassVar[{kind}] = {value}")
        return lines

    def struct(self, struct, name, indent, constants=None):
        fields = [] if struct.empty else struct.own_fields
        inner = indent + "    "
        lines = [f"{indent}class {name}(Message):"]
        comment = " ".join(struct.comment).replace("\\", "\\\\").replace('"', "'")
        if comment:
            lines.append(f'{inner}"""{comment}"""')
        lines.append(f"{inner}__slots__ = ({''.join(repr(attribute(field)) + ', ' for field in fields)})")
        lines += self.constants(constants, inner)
        lines.append(f'{inner}_dds_type = "{struct.dds_name}"')
        if struct.appended:
            lines.append(f"{inner}_appended = {struct.appended}")
        rows = []
        for field in fields:
            count = -1 if field.type.sequence else field.type.length
            nested = f", lambda: {self.reference(field.type.base)}" if field.type.nested else ", None"
            kind = "struct" if field.type.nested else field.type.base
            rows.append(f'("{attribute(field)}", "{kind}", {count}{nested}), ')
        lines.append(f"{inner}_fields: ClassVar[FieldTable] = ({''.join(rows)})")
        parameters, body = [], []
        for field in fields:
            default, made = self.default(field)
            kind = self.annotation(field)
            if made is None:
                parameters.append(f"{attribute(field)}: {kind} = {default}")
                body.append(f"{inner}    self.{attribute(field)}: {kind} = {attribute(field)}")
            else:
                parameters.append(f"{attribute(field)}: Optional[{kind}] = None")
                body.append(f"{inner}    self.{attribute(field)}: {kind} = {made} if {attribute(field)} is None else {attribute(field)}")
        lines.append(f"{inner}def __init__({', '.join(['self'] + parameters)}) -> None:")
        lines += body or [f"{inner}    pass"]
        return lines + [""]

    def add(self, interface):
        name = interface.name
        self.names.append(name)
        if interface.kind == "msg" and interface.parts:
            self.classes += self.struct(interface.parts[""], name, "", interface.constants) + [""]
            return
        base = {"srv": "Service", "action": "Action"}.get(interface.kind, "")
        lines = [f"class {name}({base}):" if base and interface.parts else f"class {name}:"]
        lines += self.constants(interface.constants, "    ")
        if interface.parts:
            lines.append(f'    _dds_type = "{interface.package}::{interface.kind}::dds_::{name}_"')
        for part, struct in interface.parts.items():
            if "_" not in part:
                lines += self.struct(struct, part, "    ")
        for group in ("SendGoal", "GetResult"):
            parts = {part: struct for part, struct in interface.parts.items() if part.startswith(group + "_")}
            if parts:
                lines.append(f"    class {group}(Service):")
                lines.append(f'        _dds_type = "{interface.package}::action::dds_::{name}_{group}_"')
                for part, struct in parts.items():
                    lines += self.struct(struct, part.partition("_")[2], "        ")
        self.classes += lines + [""]

    def source(self):
        imports = [f"from musher.{package} import {kind} as _{package}_{kind}" for package, kind in
                   sorted(self.imports)]
        return "\n".join([
            HEAD + f'"""{self.package}/{self.kind}"""', "", "from __future__ import annotations", "",
            "from array import array", "from typing import ClassVar, Optional, Sequence", "",
            "from musher._message import Action, Bytes, FieldTable, Message, Service", *imports, "", "",
            *self.classes,
            f"__all__ = {sorted(set(self.names))!r}", ""])


def sources(files):
    """{path: text}"""
    structs = {struct.dds_name: struct for file in files for struct in file.structs}
    modules = {}
    for file in files:
        for interface in idl.interfaces_of(file):
            key = (interface.package, interface.kind)
            modules.setdefault(key, Module(*key, structs)).add(interface)
    made = {f"{package}/{kind}.py": module.source() for (package, kind), module in modules.items()}
    for package in {package for package, _ in modules}:
        kinds = sorted(kind for of, kind in modules if of == package)
        made[f"{package}/__init__.py"] = (HEAD + f'"""The ROS 2 package {package}: {", ".join(kinds)}."""\n')
    return made
