"""The text of every type as ROS 2's tools read it (schema encoding "ros2msg" of MCAP and Foxglove).

The fields of the type in .msg format, then those of every type that it consists of, each below a line of "=" and
"MSG: package/Name". Fields only: no comments, constants or defaults.
"""

import type_hashes

TYPES = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64"}  # others as in IDL
LINE = "=" * 80


def short_name(struct):
    return f"{struct.package}/{struct.name}"


def field_type(of, structs):
    name = short_name(structs[of.base]) if of.nested else TYPES.get(of.base, of.base)
    if of.string_bound:
        name += f"<={of.string_bound}"
    if of.sequence:
        name += f"[<={of.bound}]" if of.bound else "[]"
    return name + (f"[{of.length}]" if of.length else "")


def fields(struct, structs):
    return "".join(f"{field_type(field.type, structs)} {field.name}\n"
                   for field in struct.own_fields if not struct.empty)


def text(struct, structs):
    others = sorted(type_hashes.referenced(struct, structs, {}).values(), key=lambda other: other.ros_name)
    return fields(struct, structs) + "".join(f"{LINE}\nMSG: {short_name(other)}\n{fields(other, structs)}"
                                             for other in others)


def envelope(struct):
    return "true" if len(struct.own_fields) != len(struct.fields) else "false"


def cpp_source(files):
    """The C++ of the table, sorted by the bytes of the DDS names."""
    structs = {struct.dds_name: struct for file in files for struct in file.structs}
    rows = [f'    {{"{name}", "{struct.ros_name}",\n     R"msg({text(struct, structs)})msg",\n'
            f'     {envelope(struct)}, {struct.appended}}},'
            for name, struct in sorted(structs.items())]
    return "\n".join([
        "// Made from the IDL in messages/ when Musher is built; do not edit.",
        '#include "musher/messages/definitions.hpp"', "",
        "#include <array>", "",
        "namespace musher::msg {", "", "namespace {", "",
        f"constexpr std::array<MessageDefinition, {len(rows)}> kDefinitions{{{{", *rows, "}};", "",
        "}  // namespace", "",
        "std::span<const MessageDefinition> Definitions() {", "  return kDefinitions;", "}", "",
        "}  // namespace musher::msg", ""])
