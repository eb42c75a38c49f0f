"""The C++ header of an IDL file: its messages, services, actions and constants as musher::msg structs."""

import os
import textwrap

import idl

WIDTH = 100
TYPES = {
    "boolean": "bool", "octet": "std::uint8_t", "float": "float", "double": "double", "string": "std::string",
    "int8": "std::int8_t", "uint8": "std::uint8_t", "int16": "std::int16_t", "uint16": "std::uint16_t",
    "int32": "std::int32_t", "uint32": "std::uint32_t", "int64": "std::int64_t", "uint64": "std::uint64_t",
}


def cpp_names(files):
    """{DDS name: name in musher::msg} of all structs."""
    names, taken = {}, {}
    for file in files:
        for interface in idl.interfaces_of(file):
            if interface.cpp_name in taken:
                raise idl.Fault(f"{file.path}: {interface.ros_name} and {taken[interface.cpp_name]} are both "
                                f"'{interface.cpp_name}' in C++: give one a @cpp_name")
            taken[interface.cpp_name] = interface.ros_name
            for part, struct in interface.parts.items():
                names[struct.dds_name] = "::".join(
                    [interface.cpp_name, *part.split("_")] if part else [interface.cpp_name])
    return names


def constant_name(name):
    return "k" + "".join(word.capitalize() for word in name.split("_"))


class Lines:
    """Lines of C++ at an indentation."""

    def __init__(self):
        self.text, self.depth = [], 0

    def add(self, line="", behind=""):
        line = "  " * self.depth + line if line else ""
        if behind and len(line) + len(behind) + 5 > WIDTH:
            self.comment([behind])
            behind = ""
        self.text.append(f"{line}  // {behind}" if behind else line)

    def comment(self, lines):
        self.text += [f"{'  ' * self.depth}// {line}" for line in lines]

    def begin(self, name):
        self.add(f"struct {name} {{")
        self.depth += 1

    def end(self):
        self.depth -= 1
        self.add("};")


class Header:
    def __init__(self, file, names):
        self.file, self.names, self.lines = file, names, Lines()

    def text(self):
        includes = [f"musher/messages/{path[:-len('.idl')]}.hpp" for path in sorted(self.file.includes)]
        lines = self.lines
        lines.add("#pragma once")
        lines.comment([*self.file.comment, f"Made from messages/{self.file.path}; do not edit."])
        lines.add()
        for path in includes or ["musher/messages/cdr.hpp"]:
            lines.add(f'#include "{path}"')
        lines.add()
        lines.add("namespace musher::msg {")
        for interface in idl.interfaces_of(self.file):
            lines.add()
            self.interface(interface)
        lines.add()
        lines.add("}  // namespace musher::msg")
        return "\n".join(lines.text) + "\n"

    def interface(self, interface):
        lines, name = self.lines, interface.cpp_name
        lines.comment([interface.ros_name] if interface.parts else [])
        lines.comment(interface.comment)
        lines.begin(name)
        if interface.kind == "msg" and interface.parts:
            struct = interface.parts[""]
            self.type_name(struct.dds_name)
            self.constants(interface)
            self.fields(struct, name)
        else:
            if interface.kind != "msg":
                self.type_name(f"{interface.package}::{interface.kind}::dds_::{interface.name}_")
            self.constants(interface)
            nested = self.service if interface.kind == "srv" else self.action
            nested(interface)
        lines.end()

    def type_name(self, dds_name):
        line = f'static constexpr std::string_view kTypeName = "{dds_name}";'
        if 2 * self.lines.depth + len(line) > WIDTH:
            self.lines.add("static constexpr std::string_view kTypeName =")
            line = f'    "{dds_name}";'
        self.lines.add(line)

    def constants(self, interface):
        if not interface.constants:
            return
        if interface.parts:
            self.lines.add()
            self.lines.comment(interface.constants.comment)
        for constant in interface.constants.items:
            of = "std::string_view" if constant.type == "string" else TYPES[constant.type]
            value = f"{float(constant.value)}F" if constant.type == "float" else constant.value
            self.lines.comment(constant.before)
            self.lines.add(f"static constexpr {of} {constant_name(constant.name)} = "
                           f"{value};", constant.behind)
        if interface.parts:
            self.lines.add()

    def service(self, interface):
        for part in ("Request", "Response"):
            if part in interface.parts:
                self.part(interface.parts[part], part)

    def action(self, interface):
        lines = self.lines
        for part in ("Goal", "Result", "Feedback", "FeedbackMessage"):
            if part not in interface.parts:
                return  # constants on their own
            struct = interface.parts[part]
            lines.comment(struct.comment if part != "Goal" else [])
            lines.begin(part)
            self.type_name(struct.dds_name)
            self.fields(struct, part)
            lines.end()
        for service in ("SendGoal", "GetResult"):
            lines.comment(interface.parts[service + "_Request"].comment)
            lines.begin(service)
            self.type_name(f"{interface.package}::action::dds_::{interface.name}_{service}_")
            for part in ("Request", "Response"):
                self.part(interface.parts[f"{service}_{part}"], part)
            lines.end()

    def part(self, struct, name):
        if struct.empty:
            self.lines.add(f"using {name} = Empty;")
            return
        self.lines.comment(struct.comment if name == "Response" else [])
        self.lines.begin(name)
        self.fields(struct, name)
        self.lines.end()

    def fields(self, struct, name):
        lines, fields = self.lines, struct.own_fields
        appended = next((i for i, field in enumerate(fields) if field.appended), None)
        if appended is not None:
            lines.add(f"static constexpr std::size_t kAppended = {len(fields) - appended};")
            lines.add()
        for field in fields:
            lines.comment(field.before)
            lines.add(f"{self.field_type(field.type)} {field.name}{self.initial(field)};", field.behind)
        lines.add()
        lines.add("template <class Self>")
        lines.add("static auto Fields(Self& m) {")
        indent = "  " * (lines.depth + 1)
        lines.text += textwrap.wrap("return std::tie(" + ", ".join(f"m.{field.name}" for field in fields) + ");",
                                    WIDTH, initial_indent=indent, subsequent_indent=indent + " " * 16)
        lines.add("}")
        lines.add(f"friend bool operator==(const {name}&, const {name}&) = default;")

    def field_type(self, of):
        base = self.names[of.base] if of.nested else TYPES[of.base]
        if of.sequence:
            base = f"std::vector<{base}>"
        return f"std::array<{base}, {of.length}>" if of.length else base

    def initial(self, field):
        if field.default is not None:
            return f" = {field.default}"
        if field.type.sequence or field.type.length or field.type.nested or field.type.base == "string":
            return "{}"
        return " = false" if field.type.base == "boolean" else " = 0"


def all_interfaces(files):
    """The header that names every interface, for what is to be done with each of them."""
    interfaces = [each for file in files for each in idl.interfaces_of(file) if each.parts]
    kinds = {"msg": "Message", "srv": "Service", "action": "Action"}
    include = [f'#include "musher/messages/{file.path[:-len(".idl")]}.hpp"' for file in files]
    return "\n".join([
        "#pragma once", "// Made from the IDL in messages/; do not edit.", "", *sorted(include), "",
        "namespace musher::msg {", "",
        "// Calls visit.Message<M>(), visit.Service<S>() or visit.Action<A>() for every interface.",
        "template <class Visitor>", "void VisitInterfaces(Visitor& visit) {",
        *[f"  visit.template {kinds[each.kind]}<{each.cpp_name}>();" for each in interfaces],
        "}", "", "}  // namespace musher::msg", ""])


def headers(files):
    """{path below the include folder: text}"""
    names = cpp_names(files)
    all_of_them = {os.path.join("musher", "messages", "interfaces.hpp"): all_interfaces(files)}
    return all_of_them | {
        os.path.join("musher", "messages", file.path[:-len(".idl")] + ".hpp"): Header(file, names).text()
        for file in files}
