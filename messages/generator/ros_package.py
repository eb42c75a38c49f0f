"""ROS 2 interface packages, for `ros2 service call`, `ros2 topic echo`, rosbag2 and rclcpp.

A package has package.xml, CMakeLists.txt and a .msg, .srv or .action for each of its interfaces, with the
comments, constants and defaults of the IDL.
"""

import re

import idl

TYPES = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64"}  # others as in IDL
FIELD_NAME = re.compile(r"^[a-z](?:_?[a-z0-9]+)*$")
COLUMN = 40  # of the comments


def row(text, comment):
    return f"{text:<{COLUMN}}# {comment}" if comment else text


class Package:
    def __init__(self, name, files):
        self.name, self.needed = name, set()
        self.structs = {struct.dds_name: struct for file in files for struct in file.structs}
        self.interfaces = [interface for file in files for interface in idl.interfaces_of(file)
                           if interface.package == name and interface.parts]
        if not self.interfaces:
            raise idl.Fault(f"no type of the package {name} in these files")

    def type_name(self, of):
        name = TYPES.get(of.base, of.base)
        if of.nested:
            struct = self.structs[of.base]
            name = struct.name if struct.package == self.name else f"{struct.package}/{struct.name}"
            if struct.package != self.name:
                self.needed.add(struct.package)
        if of.string_bound:
            name += f"<={of.string_bound}"
        if of.sequence:
            name += f"[<={of.bound}]" if of.bound else "[]"
        return name + (f"[{of.length}]" if of.length else "")

    def part(self, struct):
        """The lines of a message, or of one part of a service or action."""
        rows = []
        for field in struct.own_fields:
            if field.name == idl.PLACEHOLDER:
                continue
            if not FIELD_NAME.match(field.name):
                raise idl.Fault(f"{struct.file}: {struct.name}: ROS 2 accepts no field '{field.name}'")
            default = f" {field.default}" if field.default is not None else ""
            rows += [f"# {line}" for line in field.before]
            rows.append(row(f"{self.type_name(field.type)} {field.name}{default}", field.behind))
        return rows

    def text(self, interface, parts):
        rows = [f"# {line}" for line in interface.comment]
        if interface.constants:
            rows += [f"# {line}" for line in interface.constants.comment]
            for constant in interface.constants.items:
                rows += [f"# {line}" for line in constant.before]
                of = TYPES.get(constant.type, constant.type)
                rows.append(row(f"{of} {constant.name}={constant.value}", constant.behind))
        for number, part in enumerate(parts):
            rows += (["---"] if number else []) + self.part(interface.parts[part])
        return "\n".join(rows) + "\n"

    def files(self, version):
        """{path below the package: text}"""
        parts = {"msg": [""], "srv": ["Request", "Response"], "action": ["Goal", "Result", "Feedback"]}
        files = {f"{each.kind}/{each.name}.{each.kind}": self.text(each, parts[each.kind])
                 for each in self.interfaces}
        if any(each.kind == "action" for each in self.interfaces):
            self.needed.add("action_msgs")
        return {**files, "package.xml": package_xml(self.name, version, self.needed),
                "CMakeLists.txt": cmake_lists(self.name, files, self.needed)}


def package_xml(package, version, needed):
    depends = "".join(f"  <depend>{name}</depend>\n" for name in sorted(needed))
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{package}</name>
  <version>{version}</version>
  <description>Interfaces of {package}, generated from Musher's IDL.</description>
  <maintainer email="noreply@musher.invalid">Musher</maintainer>
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
