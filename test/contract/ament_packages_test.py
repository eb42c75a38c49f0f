"""The generated ROS 2 packages as ament reads them: by catkin_pkg, which colcon and ament use."""

import pathlib
import sys
import unittest

from catkin_pkg.package import parse_package

ROOT = pathlib.Path(sys.argv.pop(1))
# Those of ROS 2 itself that ours may need.
OF_ROS = {"action_msgs", "builtin_interfaces", "geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs",
          "trajectory_msgs", "unique_identifier_msgs", "ament_cmake", "rosidl_default_generators",
          "rosidl_default_runtime"}


class TheShippedPackages(unittest.TestCase):
    def packages(self):
        found = {path.parent.name: path for path in ROOT.glob("*/package.xml")}
        self.assertEqual(set(found), {"action_of_motion_interfaces", "musher_msgs", "plan_msgs", "protocol",
                                      "r2_interfaces"})
        return found

    def test_are_valid_for_ament(self):
        for name, path in self.packages().items():
            warnings = []
            package = parse_package(str(path), warnings=warnings)
            package.validate(warnings=warnings)
            self.assertEqual(warnings, [], name)
            self.assertEqual(package.name, name)
            self.assertEqual(package.get_build_type(), "ament_cmake")
            self.assertIn("rosidl_interface_packages", [group.name for group in package.member_of_groups])

    def test_depend_on_each_other_and_on_ros_only(self):
        known = set(self.packages()) | OF_ROS
        for path in self.packages().values():
            package = parse_package(str(path))
            needed = {each.name for each in package.build_depends + package.buildtool_depends +
                      package.exec_depends}
            self.assertEqual(needed - known, set(), path)

    def test_with_an_action_depend_on_its_messages(self):
        for path in self.packages().values():
            if not (path.parent / "action").is_dir():
                continue
            self.assertIn("action_msgs", [each.name for each in parse_package(str(path)).build_depends])


if __name__ == "__main__":
    unittest.main()
