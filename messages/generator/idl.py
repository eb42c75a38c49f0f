"""Reads the IDL of messages/: its structs and constants, with their comments.

One declaration a line, in the modules <package>, msg, srv or action, dds_, as ROS 2 maps its interfaces to DDS.
What messages/README.md says about the form is checked; a line that is not of that form is a Fault.
"""

import dataclasses
import os
import re

# IDL's basic types, and the numbers that type_description_interfaces/msg/FieldType gives them.
BASIC = {
    "int8": 2, "uint8": 3, "int16": 4, "uint16": 5, "int32": 6, "uint32": 7, "int64": 8, "uint64": 9,
    "float": 10, "double": 11, "boolean": 15, "octet": 16,
}
KINDS = ("msg", "srv", "action")
# The fields that ROS 2 adds: to the requests and responses of a service, and to an empty message.
ENVELOPE = ("client_id", "sequence_number")
PLACEHOLDER = "structure_needs_at_least_one_member"
# A line's code and comment; // in quotes begins none.
LINE = re.compile(r'((?:"[^"]*"|(?!//).)*)(?://(.*))?$')
ANNOTATION = re.compile(r"@(\w+)(?:\(((?:\"[^\"]*\"|[^()])*)\))?\s*")
FIELD = re.compile(r"(?P<type>[\w:]+(?:<.+>)?)\s+(?P<name>\w+)(?:\[(?P<length>\d+)\])?;$")
CONSTANT = re.compile(r"const\s+(?P<type>\w+)\s+(?P<name>[A-Z][A-Z0-9_]*)\s*=\s*(?P<value>[^;]+);$")


# Of IDL 4.2, those that a name could be.
KEYWORDS = {"abstract", "any", "attribute", "bitset", "boolean", "case", "char", "component", "const", "context",
            "custom", "default", "double", "enum", "exception", "factory", "fixed", "float", "home", "import", "in",
            "inout", "interface", "local", "long", "map", "module", "multiple", "native", "object", "octet", "out",
            "port", "private", "provides", "public", "publishes", "raises", "readonly", "sequence", "short", "string",
            "struct", "supports", "switch", "true", "false", "truncatable", "typedef", "union", "unsigned", "uses",
            "void", "wchar", "wstring"}


class Fault(Exception):
    """A part of the IDL that the generator does not cover."""


@dataclasses.dataclass
class Type:
    """The type of a field: `base` is a basic type, "string" or the DDS name of a struct."""
    base: str
    sequence: bool = False
    bound: int = 0         # of the sequence; 0: none
    string_bound: int = 0  # of a string; 0: none
    length: int = 0        # of an array; 0: it is none

    @property
    def nested(self):
        return "::" in self.base


@dataclasses.dataclass
class Field:
    name: str
    type: Type
    before: list    # the comment lines above it
    behind: str     # the comment behind it
    default: str = None
    appended: bool = False  # an older peer does not send it, nor those that follow


@dataclasses.dataclass
class Constant:
    name: str
    type: str
    value: str
    before: list
    behind: str


@dataclasses.dataclass
class Struct:
    file: str
    package: str
    kind: str     # "msg", "srv" or "action"
    name: str     # "Header", "SetState_Request"
    comment: list
    cpp_name: str = None
    fields: list = dataclasses.field(default_factory=list)

    @property
    def dds_name(self):
        return f"{self.package}::{self.kind}::dds_::{self.name}_"

    @property
    def ros_name(self):
        return f"{self.package}/{self.kind}/{self.name}"

    @property
    def own_fields(self):
        """Without those that ROS 2 puts before the fields of a service's request and response."""
        named = tuple(field.name for field in self.fields[:2])
        return self.fields[2:] if named == ENVELOPE else self.fields

    @property
    def appended(self):
        """How many of its last fields an older peer does not send."""
        first = next((i for i, field in enumerate(self.fields) if field.appended), len(self.fields))
        return len(self.fields) - first

    @property
    def empty(self):
        return [field.name for field in self.own_fields] == [PLACEHOLDER]


@dataclasses.dataclass
class Constants:
    """The constants of the interface `name`, or, if there is none of that name, on their own."""
    file: str
    package: str
    kind: str
    name: str
    comment: list
    cpp_name: str = None
    items: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass
class File:
    path: str        # below messages/: "std_msgs/header.idl"
    comment: list    # at its top
    includes: list   # paths below messages/
    declared: list   # Structs and Constants, in order

    @property
    def structs(self):
        return [each for each in self.declared if isinstance(each, Struct)]


def annotations(code):
    """({name: argument}, the rest of the line)"""
    found = {}
    while match := ANNOTATION.match(code):
        found[match[1]] = (match[2] or "").strip()
        code = code[match.end():]
    return found, code


def cpp_name(annotations_given):
    return annotations_given.get("cpp_name", "").strip('"') or None


def parse_type(text, scope):
    sequence = re.fullmatch(r"sequence<(.+?)(?:,\s*(\d+))?>", text)
    if sequence:
        item = parse_type(sequence[1], scope)
        if item.sequence:
            raise Fault(f"'{text}': ROS 2 has no sequences of sequences")
        return dataclasses.replace(item, sequence=True, bound=int(sequence[2] or 0))
    string = re.fullmatch(r"string(?:<(\d+)>)?", text)
    if string:
        return Type("string", string_bound=int(string[1] or 0))
    if text in BASIC:
        return Type(text)
    if re.fullmatch(r"\w+_", text):
        return Type("::".join(scope + [text]))
    if re.fullmatch(r"\w+::(msg|action)::dds_::\w+_", text):
        return Type(text)
    raise Fault(f"'{text}' is no type that a ROS 2 message may have")


class Reader:
    def __init__(self, path):
        self.file = File(path, [], [], [])
        self.scope, self.pending, self.current = [], [], None

    def take(self, line):
        code, comment = LINE.match(line).groups()
        code, comment = code.strip(), (comment or "").strip()
        if not code and not comment:
            if self.pending and not self.file.declared and not self.scope:
                self.file.comment += self.pending
            elif self.pending:
                raise Fault(f"the comment '{self.pending[-1]}' is above nothing")
            self.pending = []
        elif not code:
            self.pending.append(comment)
        else:
            self.declaration(code, comment)

    def declaration(self, code, behind):
        include = re.fullmatch(r'#include "([\w/]+\.idl)"', code)
        given, code = annotations(code)
        if include:
            if self.pending:
                self.file.comment, self.pending = self.file.comment + self.pending, []
            self.file.includes.append(include[1])
        elif set(code) <= set("}; "):
            if self.pending or behind:
                raise Fault(f"the comment '{behind or self.pending[-1]}' belongs to nothing")
            self.close(code.count("}"))
        elif match := re.fullmatch(r"module (\w+)_Constants \{", code):
            self.open(Constants(self.file.path, *self.place(), match[1], self.pending, cpp_name(given)), behind)
        elif re.match(r"module\b", code):
            if self.pending and not self.file.declared and not self.file.comment:
                self.file.comment = self.pending
            self.scope += re.findall(r"module\s+(\w+)\s*\{", code)
            self.pending = []
        elif match := re.fullmatch(r"struct (\w+)_ \{", code):
            if "final" not in given:
                raise Fault(f"'{match[1]}_' is not @final: ROS 2's messages are")
            self.open(Struct(self.file.path, *self.place(), match[1], self.pending, cpp_name(given)), behind)
        elif isinstance(self.current, Struct) and (field := FIELD.match(code)):
            kind = parse_type(field["type"], self.scope)
            kind.length = int(field["length"] or 0)
            self.current.fields.append(Field(field["name"], kind, self.pending, behind,
                                             given.get("default"), "appended" in given))
            self.pending = []
        elif isinstance(self.current, Constants) and (constant := CONSTANT.match(code)):
            if constant["name"].lower() in KEYWORDS:
                raise Fault(f"'{constant['name']}' is a keyword of IDL, which does not distinguish case")
            self.current.items.append(Constant(constant["name"], constant["type"],
                                               constant["value"].strip(), self.pending, behind))
            self.pending = []
        else:
            raise Fault(f"'{code}' is not a declaration of the form that messages/README.md describes")

    def place(self):
        if self.current or len(self.scope) != 3 or self.scope[1] not in KINDS or self.scope[2] != "dds_":
            raise Fault(f"this belongs into the modules <package>, one of {', '.join(KINDS)}, dds_")
        return self.scope[:2]

    def open(self, declared, behind):
        if behind:
            raise Fault(f"the comment '{behind}' belongs above '{declared.name}'")
        self.current, self.pending = declared, []

    def close(self, count):
        if self.current:
            self.file.declared.append(self.current)
            self.current, count = None, count - 1
        if count > len(self.scope):
            raise Fault("there are more '}' than '{'")
        del self.scope[len(self.scope) - count:]
        self.pending = []


def read_file(root, path):
    reader = Reader(path)
    with open(os.path.join(root, path), encoding="utf-8") as opened:
        for number, line in enumerate(opened, 1):
            try:
                reader.take(line.rstrip("\n"))
            except Fault as fault:
                raise Fault(f"{path}:{number}: {fault}") from None
    if reader.scope or reader.current:
        raise Fault(f"{path}: a '}}' is missing at the end")
    return reader.file


def read_all(root, paths):
    """The files, each after those that it includes; every struct that a field names is declared before."""
    files = {path: read_file(root, path) for path in paths}
    ordered, visiting = [], []

    def add(path, by):
        if path not in files:
            raise Fault(f"{by}: there is no {path}")
        if path in visiting:
            raise Fault(f"{by}: {' includes '.join(visiting + [path])}")
        if files[path] in ordered:
            return
        visiting.append(path)
        for include in files[path].includes:
            add(include, path)
        visiting.pop()
        ordered.append(files[path])

    for path in sorted(files):
        add(path, path)
    declared = {}
    for file in ordered:
        for struct in file.structs:
            if struct.dds_name in declared:
                raise Fault(f"{file.path}: {struct.ros_name} is declared twice")
            for field in struct.fields:
                if field.type.nested and field.type.base not in declared:
                    raise Fault(f"{file.path}: {struct.name}.{field.name} is a {field.type.base}, "
                                "which is not declared before")
            declared[struct.dds_name] = struct
    return ordered


# The parts of an action, as ROS 2 names them; each is a struct of its own in the IDL.
ACTION_PARTS = ("Goal", "Result", "Feedback", "SendGoal_Request", "SendGoal_Response",
                "GetResult_Request", "GetResult_Response", "FeedbackMessage")


@dataclasses.dataclass
class Interface:
    """A message, a service, an action, or constants on their own, with all that belongs to it."""
    package: str
    kind: str
    name: str              # "Header", "SetState", "Speech"
    parts: dict            # {"": struct} of a message, else {"Request": …}, {"Goal": …}
    constants: Constants = None

    @property
    def ros_name(self):
        return f"{self.package}/{self.kind}/{self.name}"

    @property
    def cpp_name(self):
        given = [each.cpp_name for each in [*self.parts.values(), self.constants] if each]
        return next((name for name in given if name), self.name)

    @property
    def comment(self):
        first = next(iter(self.parts.values()), self.constants)
        return first.comment


def part_of(struct):
    """(name of the interface, name of the part)"""
    if struct.kind == "msg":
        return struct.name, ""
    parts = ("Request", "Response") if struct.kind == "srv" else ACTION_PARTS
    for part in sorted(parts, key=len, reverse=True):
        if struct.name.endswith("_" + part):
            return struct.name[:-len(part) - 1], part
    raise Fault(f"{struct.file}: {struct.ros_name} is no part of a service or action")


def interfaces_of(file):
    """The interfaces of a file, each where its last part is."""
    found = {}
    for declared in file.declared:
        constants = isinstance(declared, Constants)
        name, part = (declared.name, None) if constants else part_of(declared)
        key = (declared.package, declared.kind, name)
        interface = found.pop(key, None) or Interface(*key, {})
        found[key] = interface
        if constants:
            interface.constants = declared
        else:
            interface.parts[part] = declared
    for interface in found.values():
        whole = {"srv": ("Request", "Response"), "action": ACTION_PARTS}.get(interface.kind, ())
        missing = [part for part in whole if part not in interface.parts]
        if missing and interface.parts:
            raise Fault(f"{file.path}: {interface.ros_name} has no {', no '.join(missing)}")
    return list(found.values())
