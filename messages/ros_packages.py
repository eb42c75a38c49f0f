#!/usr/bin/env python3
"""Generates ROS 2 interface packages from the IDL, for `ros2 service call`, `ros2 topic echo`, rosbag2 and rclcpp.

    ros_packages.py --package musher_msgs --version 0.1.0 --out FOLDER a.idl b.idl

writes FOLDER/<package>/ with package.xml, CMakeLists.txt and a .msg, .srv or .action for each type of
that package; an existing FOLDER/<package>/ is replaced. With --list it prints the files and writes none.
The IDL has the names of DDS ("musher_msgs::msg::dds_::Capability_"), the files those of ROS
("Capability"). Comments are copied.
"""

import argparse
import pathlib
import re
import shutil
import sys

NUMBERS = {
    "boolean": "bool", "octet": "byte", "char": "char", "float": "float32", "double": "float64",
    "int8": "int8", "uint8": "uint8", "int16": "int16", "short": "int16", "uint16": "uint16",
    "int32": "int32", "long": "int32", "uint32": "uint32", "int64": "int64", "uint64": "uint64",
}
# The fields that ROS 2 adds to the requests and responses of a service, and to an empty message.
ADDED = {"client_id", "sequence_number", "structure_needs_at_least_one_member"}
# The types that ROS 2 derives from an action in addition to its three parts.
OF_ACTION = ("_SendGoal_Request", "_SendGoal_Response", "_GetResult_Request", "_GetResult_Response",
             "_FeedbackMessage")
FIELD = re.compile(r"(?P<type>[\w:]+(?:<.+>)?)\s+(?P<name>\w+)(?:\[(?P<size>\d+)\])?;$")
FIELD_NAME = re.compile(r"^[a-z](?:_?[a-z0-9]+)*$")


class Fault(Exception):
    """A part of the IDL without an equivalent in ROS 2's files."""


class Struct:
    def __init__(self, package, kind, name, comment):
        self.package, self.kind, self.name, self.comment = package, kind, name, comment
        self.fields = []  # [(type, name, size or None, comment lines before, comment behind)]


def split_comment(line):
    code, _, comment = line.partition("//")
    return code.strip(), comment.strip()


def structs_of(text):
    """All structs of a file, in order."""
    found, scope, pending, current = [], [], [], None
    for number, line in enumerate(text.splitlines(), 1):
        code, comment = split_comment(line)
        if line.strip().startswith("#") or (not code and not comment):
            pending = pending if current else []
            continue
        if not code:
            pending.append(comment)
        elif current is None and re.search(r"\bmodule\b", code):
            scope += re.findall(r"module\s+(\w+)\s*\{", code)
            pending = []
        elif current is None and "struct" in code:
            name = re.search(r"struct\s+(\w+?)_\s*\{$", code)
            if not name or len(scope) != 3 or scope[2] != "dds_":
                raise Fault(f"line {number}: '{code}' is not a struct of <package>::<kind>::dds_")
            current = Struct(scope[0], scope[1], name.group(1), pending)
            pending = []
        elif current is not None and code == "};":
            found.append(current)
            current, pending = None, []
        elif current is not None:
            field = FIELD.match(code)
            if not field:
                raise Fault(f"line {number}: '{code}' is not a field")
            current.fields.append((field["type"], field["name"], field["size"], pending, comment))
            pending = []
        elif set(code) <= set("}; "):
            del scope[len(scope) - code.count("}"):]
            pending = []
        else:
            raise Fault(f"line {number}: '{code}' is neither a module nor a struct")
    return found


def type_name(idl, package):
    """The type of a field, and the package it comes from (None: a basic one)."""
    sequence = re.fullmatch(r"sequence<(.+?)(?:,\s*(\d+))?>", idl)
    if sequence:
        name, origin = type_name(sequence[1], package)
        return name + (f"[<={sequence[2]}]" if sequence[2] else "[]"), origin
    text = re.fullmatch(r"string(?:<(\d+)>)?", idl)
    if text:
        return "string" + (f"<={text[1]}" if text[1] else ""), None
    if idl in NUMBERS:
        return NUMBERS[idl], None
    parts = idl.split("::")
    if not idl.endswith("_") or len(parts) not in (1, 4) or (len(parts) == 4 and parts[1] != "msg"):
        raise Fault(f"the type '{idl}' has no ROS 2 equivalent")
    origin, name = (package, parts[0]) if len(parts) == 1 else (parts[0], parts[3])
    name = name[:-1]
    return (name if origin == package else f"{origin}/{name}"), origin


def lines_of(struct, needed):
    """The lines of a message, or of one part of a service or action."""
    rows = []
    for idl, name, size, before, behind in struct.fields:
        if name in ADDED and struct.kind != "msg" or name == "structure_needs_at_least_one_member":
            continue
        if not FIELD_NAME.match(name):
            raise Fault(f"{struct.name}: ROS 2 accepts no field '{name}'")
        of, origin = type_name(idl, struct.package)
        if origin and origin != struct.package:
            needed.add(origin)
        rows += [f"# {line}" for line in before]
        row = f"{of}{f'[{size}]' if size else ''} {name}"
        rows.append(f"{row:<40}# {behind}" if behind else row)
    return rows


def files_of(structs, package, needed):
    """{path: text} of the interface files of a package."""
    own = {(s.kind, s.name): s for s in structs if s.package == package}
    files = {}

    def text(*parts):
        head = [f"# {line}" for line in parts[0].comment]
        return "\n".join(head + sum([["---"] * (i > 0) + lines_of(p, needed)
                                     for i, p in enumerate(parts)], [])) + "\n"

    for (kind, name), struct in own.items():
        if kind == "msg":
            files[f"msg/{name}.msg"] = text(struct)
        elif kind == "srv" and name.endswith("_Request"):
            base = name[:-len("_Request")]
            files[f"srv/{base}.srv"] = text(struct, own[kind, base + "_Response"])
        elif kind == "action" and name.endswith("_Goal"):
            base = name[:-len("_Goal")]
            files[f"action/{base}.action"] = text(struct, own[kind, base + "_Result"],
                                                  own[kind, base + "_Feedback"])
        elif not name.endswith(("_Response", "_Result", "_Feedback") + OF_ACTION):
            raise Fault(f"{package}/{kind}/{name} is not part of a service or action")
    return files


def package_xml(package, version, needed):
    depends = "".join(f"  <depend>{name}</depend>\n" for name in sorted(needed))
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>{version}</version>
  <description>Interfaces of {package}, generated from Musher's IDL.</description>
  <maintainer email="musher@localhost">Musher</maintainer>
  <license>Apache-2.0</license>

  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
{depends}  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>

  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""


def cmake_lists(package, files, needed):
    finds = "".join(f"find_package({name} REQUIRED)\n" for name in sorted(needed))
    listed = "".join(f'  "{path}"\n' for path in sorted(files))
    depends = f"  DEPENDENCIES {' '.join(sorted(needed))}\n" if needed else ""
    return f"""cmake_minimum_required(VERSION 3.8)
project({package})

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{finds}
rosidl_generate_interfaces(${{PROJECT_NAME}}
{listed}{depends})

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def package_of(package, version, paths):
    """{path: text} of the whole package."""
    structs = []
    for path in paths:
        try:
            structs += structs_of(pathlib.Path(path).read_text(encoding="utf-8"))
        except Fault as fault:
            raise Fault(f"{path}: {fault}") from fault
    needed = set()
    files = files_of(structs, package, needed)
    if not files:
        raise Fault(f"no type of {package} in these files")
    if any(path.startswith("action/") for path in files):
        needed.add("action_msgs")
    return {**files, "package.xml": package_xml(package, version, needed),
            "CMakeLists.txt": cmake_lists(package, files, needed)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--package", required=True)
    parser.add_argument("--version", default="0.0.0")
    parser.add_argument("--out", required=True)
    parser.add_argument("--list", action="store_true", help="print the paths, write nothing")
    parser.add_argument("idl", nargs="+")
    given = parser.parse_args()
    try:
        files = package_of(given.package, given.version, given.idl)
    except Fault as fault:
        sys.exit(f"ros_packages.py: {fault}")
    folder = pathlib.Path(given.out) / given.package
    if given.list:
        print("\n".join(str(folder / path) for path in sorted(files)))
        return
    shutil.rmtree(folder, ignore_errors=True)
    for path, text in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
