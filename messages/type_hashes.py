#!/usr/bin/env python3
"""Computes the type hash (RIHS01) of every struct in IDL files, as ROS 2 computes it (REP 2011).

    type_hashes.py --source out.cpp a.idl b.idl   writes the table that type_hash.hpp describes
    type_hashes.py a.idl b.idl                    prints "std_msgs/msg/String<tab>RIHS01_…" lines

A hash is the SHA-256 of the type's description as JSON: its name, its fields in order, and the
descriptions of all types that it refers to, sorted by name. The IDL here has the names of DDS
("std_msgs::msg::dds_::String_"), the description those of ROS ("std_msgs/msg/String"). The client's
id and the sequence number that ROS 2 puts before a request or response are no part of its type.
"""

import argparse
import hashlib
import json
import re
import sys

# type_description_interfaces/msg/FieldType
NESTED = 1
PRIMITIVES = {
    "int8": 2, "uint8": 3, "int16": 4, "short": 4, "uint16": 5, "unsigned short": 5, "int32": 6,
    "long": 6, "uint32": 7, "unsigned long": 7, "int64": 8, "long long": 8, "uint64": 9,
    "unsigned long long": 9, "float": 10, "double": 11, "char": 13, "boolean": 15, "octet": 16,
}
STRING, BOUNDED_STRING = 17, 21
ARRAY, BOUNDED_SEQUENCE, UNBOUNDED_SEQUENCE = 48, 96, 144

ENVELOPE = ["client_id", "sequence_number"]
TOKEN = re.compile(r"::|[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*|\d+|\S")


class Fault(Exception):
    """A struct that the rules below do not cover."""


def tokens_of(text):
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    text = re.sub(r"//[^\n]*|^\s*#[^\n]*|@\w+(?:\([^)]*\))?", " ", text, flags=re.MULTILINE)
    return TOKEN.findall(text)


def structs_of(text):
    """The structs of a file: [(scope, name, tokens of the body)], scope a list of modules."""
    found, scope, tokens = [], [], tokens_of(text)
    at = 0
    while at < len(tokens):
        word = tokens[at]
        if word == "module":
            scope.append(tokens[at + 1])
            at += 3
        elif word == "struct":
            end = tokens.index("}", at)
            found.append((list(scope), tokens[at + 1], tokens[at + 3:end]))
            at = end + 2
        elif word == "}":
            scope.pop()
            at += 2
        else:
            raise Fault(f"'{word}' is neither a module nor a struct")
    return found


def ros_name(dds_name):
    package, kind, dds, name = dds_name.split("::")
    if dds != "dds_" or not name.endswith("_"):
        raise Fault(f"{dds_name} is no ROS 2 type: expected package::msg::dds_::Name_")
    return f"{package}/{kind}/{name[:-1]}"


def field_type(tokens, scope):
    """A field's type from the tokens before its name."""
    field = {"type_id": 0, "capacity": 0, "string_capacity": 0, "nested_type_name": ""}
    offset = 0
    if tokens[0] == "sequence":
        inner = tokens[2:-1]  # between < and >
        offset = UNBOUNDED_SEQUENCE
        if len(inner) > 2 and inner[-2] == ",":
            offset = BOUNDED_SEQUENCE
            field["capacity"] = int(inner[-1])
            inner = inner[:-2]
        tokens = inner
    name = " ".join(tokens)
    if name == "string":
        field["type_id"] = STRING
    elif tokens[0] == "string":
        field["type_id"] = BOUNDED_STRING
        field["string_capacity"] = int(tokens[2])
    elif name in PRIMITIVES:
        field["type_id"] = PRIMITIVES[name]
    elif len(tokens) == 1 and re.fullmatch(r"[\w:]+", name):
        field["type_id"] = NESTED
        field["nested_type_name"] = ros_name(name if "::" in name else "::".join(scope + [name]))
    else:
        raise Fault(f"'{name}' is no type that a ROS 2 message may have")
    field["type_id"] += offset
    return field


def fields_of(body, scope):
    fields = []
    declaration = []
    for token in body:
        if token != ";":
            declaration.append(token)
            continue
        length = None
        if declaration[-1] == "]":
            length = int(declaration[-2])
            declaration = declaration[:-3]
        kind = field_type(declaration[:-1], scope)
        if length is not None:
            kind["type_id"] += ARRAY
            kind["capacity"] = length
        fields.append({"name": declaration[-1], "type": kind})
        declaration = []
    if [field["name"] for field in fields[:2]] == ENVELOPE:
        fields = fields[2:]
    return fields


def read_descriptions(files):
    """{DDS name: description} of all structs in the files."""
    descriptions = {}
    for file in files:
        with open(file, encoding="utf-8") as opened:
            text = opened.read()
        try:
            for scope, name, body in structs_of(text):
                dds_name = "::".join(scope + [name])
                descriptions[dds_name] = {
                    "type_name": ros_name(dds_name), "fields": fields_of(body, scope)}
        except (Fault, ValueError, IndexError) as fault:
            raise Fault(f"{file}: {fault}") from fault
    return descriptions


def referenced_by(description, by_name, found):
    for field in description["fields"]:
        name = field["type"]["nested_type_name"]
        if name and name not in found:
            if name not in by_name:
                raise Fault(f"{description['type_name']} has a {name}, which no file describes")
            found[name] = by_name[name]
            referenced_by(by_name[name], by_name, found)
    return found


def hash_of(description, by_name):
    referenced = referenced_by(description, by_name, {})
    text = json.dumps({
        "type_description": description,
        "referenced_type_descriptions": [referenced[name] for name in sorted(referenced)]})
    return "RIHS01_" + hashlib.sha256(text.encode("utf-8")).hexdigest()


def source_of(hashes):
    """The C++ of the table, sorted by the bytes of the DDS names."""
    lines = [f'    {{"{name}",\n     "{hashes[name]}"}},' for name in sorted(hashes)]
    return "\n".join([
        "// Made by messages/type_hashes.py from messages/idl; do not edit.",
        '#include "musher/messages/type_hash.hpp"', "",
        "namespace musher::msg {", "", "namespace {", "",
        f"constexpr std::array<TypeHash, {len(lines)}> kTypeHashes{{{{", *lines, "}};", "",
        "}  // namespace", "",
        "std::span<const TypeHash> TypeHashes() {", "  return kTypeHashes;", "}", "",
        "}  // namespace musher::msg", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--source", help="write C++ there instead of printing lines")
    parser.add_argument("files", nargs="+")
    arguments = parser.parse_args()
    try:
        descriptions = read_descriptions(arguments.files)
        by_name = {each["type_name"]: each for each in descriptions.values()}
        hashes = {name: hash_of(each, by_name) for name, each in descriptions.items()}
    except (Fault, OSError) as fault:
        sys.exit(f"type_hashes.py: {fault}")
    if not arguments.source:
        for name in sorted(hashes):
            print(ros_name(name), hashes[name], sep="\t")
        return
    with open(arguments.source, "w", encoding="utf-8") as out:
        out.write(source_of(hashes))


if __name__ == "__main__":
    main()
