"""The type hash (RIHS01) of every struct, as ROS 2 computes it (REP 2011).

A hash is the SHA-256 of the type's description as JSON: its name, its fields in order, and the
descriptions of all types that it refers to, sorted by name. The IDL has the names of DDS
("std_msgs::msg::dds_::String_"), the description those of ROS ("std_msgs/msg/String"). The client's
id and the sequence number that ROS 2 puts before a request or response are no part of its type.
"""

import hashlib
import json

import idl

# type_description_interfaces/msg/FieldType
NESTED, STRING, BOUNDED_STRING = 1, 17, 21
ARRAY, BOUNDED_SEQUENCE, UNBOUNDED_SEQUENCE = 48, 96, 144


def field_type(of, structs):
    if of.nested:
        number = NESTED
    elif of.base == "string":
        number = BOUNDED_STRING if of.string_bound else STRING
    else:
        number = idl.BASIC[of.base]
    if of.sequence:
        number += BOUNDED_SEQUENCE if of.bound else UNBOUNDED_SEQUENCE
    elif of.length:
        number += ARRAY
    return {"type_id": number, "capacity": of.bound or of.length, "string_capacity": of.string_bound,
            "nested_type_name": structs[of.base].ros_name if of.nested else ""}


def description(struct, structs):
    return {"type_name": struct.ros_name,
            "fields": [{"name": field.name, "type": field_type(field.type, structs)}
                       for field in struct.own_fields]}


def referenced(struct, structs, found):
    """All structs that this one consists of, by their DDS names."""
    for field in struct.own_fields:
        if field.type.nested and field.type.base not in found:
            found[field.type.base] = structs[field.type.base]
            referenced(structs[field.type.base], structs, found)
    return found


def hashes(files):
    """{DDS name: hash} of all structs."""
    structs = {struct.dds_name: struct for file in files for struct in file.structs}
    found = {}
    for name, struct in structs.items():
        others = sorted(referenced(struct, structs, {}).values(), key=lambda other: other.ros_name)
        text = json.dumps({
            "type_description": description(struct, structs),
            "referenced_type_descriptions": [description(other, structs) for other in others]})
        found[name] = "RIHS01_" + hashlib.sha256(text.encode("utf-8")).hexdigest()
    return found


def cpp_source(files):
    """The C++ of the table, sorted by the bytes of the DDS names."""
    rows = [f'    {{"{name}",\n     "{value}"}},' for name, value in sorted(hashes(files).items())]
    return "\n".join([
        "// Made from the IDL in messages/ when Musher is built; do not edit.",
        '#include "musher/messages/type_hash.hpp"', "",
        "namespace musher::msg {", "", "namespace {", "",
        f"constexpr std::array<TypeHash, {len(rows)}> kTypeHashes{{{{", *rows, "}};", "",
        "}  // namespace", "",
        "std::span<const TypeHash> TypeHashes() {", "  return kTypeHashes;", "}", "",
        "}  // namespace musher::msg", ""])
