// The generated ROS 2 packages agree with the IDL. This test reads both with a parser of its own,
// which is simpler than the generator's.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "musher/test/support/paths.hpp"

namespace musher::ros_packages_test {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Fields = std::vector<std::string>;  // "int32 pid"

const fs::path kIdl = fs::path(SourceDir()) / "messages";
const fs::path kPackages = fs::path(BuildDir()) / "share" / "musher" / "ros";

std::string Text(const fs::path& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string Trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

// The ROS 2 name of an IDL type in `package`.
std::string RosType(const std::string& idl, const std::string& package) {
  static const std::map<std::string, std::string> kBasic = {{"boolean", "bool"},
                                                            {"float", "float32"},
                                                            {"double", "float64"},
                                                            {"long", "int32"},
                                                            {"octet", "byte"}};
  if (idl.starts_with("sequence<")) {
    return RosType(idl.substr(9, idl.size() - 10), package) + "[]";
  }
  if (const auto basic = kBasic.find(idl); basic != kBasic.end()) return basic->second;
  if (!idl.ends_with("_")) return idl;
  const std::string name = idl.substr(0, idl.size() - 1);
  const auto last = name.rfind(':');
  if (last == std::string::npos) return name;
  const std::string origin = name.substr(0, name.find(':'));
  return (origin == package ? "" : origin + "/") + name.substr(last + 1);
}

// The structs of a package by kind and name: {"msg/Capability", …}.
std::map<std::string, Fields> StructsOf(const std::string& package) {
  static const std::regex module(R"(module (\w+) \{)");
  static const std::regex begin(R"(struct (\w+)_ \{)");
  static const std::regex field(
      R"(^\s*(?:@default\(([^)]*)\) )?(?:@\w+ )*([\w:<>]+) (\w+)(\[\d+\])?;)");
  std::map<std::string, Fields> structs;
  for (const auto& entry : fs::recursive_directory_iterator(kIdl)) {
    if (entry.path().extension() != ".idl") continue;
    std::ifstream file(entry.path());
    std::string of;
    std::string kind;
    Fields* current = nullptr;
    std::smatch match;
    for (std::string line; std::getline(file, line);) {
      line = line.substr(0, line.find("//"));
      if (line.find("_Constants {") != std::string::npos) continue;
      std::vector<std::string> modules;
      for (std::sregex_iterator i(line.begin(), line.end(), module), end; i != end; ++i) {
        modules.push_back((*i)[1]);
      }
      if (!modules.empty()) {  // "protocol msg dds_", or "protocol" and later "msg dds_"
        if (modules.size() != 2) of = modules.front();
        if (modules.size() >= 2) kind = modules[modules.size() - 2];
      } else if (std::regex_search(line, match, begin)) {
        current = of == package ? &structs[kind + "/" + match[1].str()] : nullptr;
      } else if (current != nullptr && std::regex_search(line, match, field)) {
        current->push_back(RosType(match[2], package) + match[4].str() + " " + match[3].str() +
                           (match[1].matched ? " " + match[1].str() : ""));
      } else if (line.find('}') != std::string::npos) {
        current = nullptr;
      }
    }
  }
  return structs;
}

// The parts of an interface file, without comments and constants.
std::vector<Fields> PartsOf(const fs::path& path) {
  std::vector<Fields> parts(1);
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    line = Trimmed(line.substr(0, line.find('#')));
    if (line == "---") {
      parts.emplace_back();
    } else if (!line.empty() && line.find('=') == std::string::npos) {
      parts.back().push_back(line);
    }
  }
  return parts;
}

// Without the fields that ROS 2 adds.
Fields WithoutAdded(Fields fields) {
  std::erase_if(fields, [](const std::string& field) {
    return field == "uint64 client_id" || field == "int64 sequence_number" ||
           field == "uint8 structure_needs_at_least_one_member";
  });
  return fields;
}

// The structs of an interface file.
std::vector<std::string> PartNames(const std::string& kind, const std::string& name) {
  if (kind == "srv") return {name + "_Request", name + "_Response"};
  if (kind == "action") return {name + "_Goal", name + "_Result", name + "_Feedback"};
  return {name};
}

class ARosPackage : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, ARosPackage,
                         ::testing::Values("action_of_motion_interfaces", "musher_msgs",
                                           "plan_msgs", "protocol", "r2_interfaces"),
                         [](const auto& package) { return std::string(package.param); });

TEST_P(ARosPackage, HasEveryTypeOfTheIdlFieldByField) {
  const std::string package = GetParam();
  const auto structs = StructsOf(package);
  std::set<std::string> left;
  for (const auto& [name, fields] : structs) left.insert(name);
  int files = 0;
  for (const std::string kind : {"msg", "srv", "action"}) {
    if (!fs::exists(kPackages / package / kind)) continue;
    for (const auto& entry : fs::directory_iterator(kPackages / package / kind)) {
      ++files;
      const std::string name = entry.path().stem();
      EXPECT_EQ(entry.path().extension(), "." + kind);
      const auto parts = PartsOf(entry.path());
      const auto names = PartNames(kind, name);
      ASSERT_EQ(parts.size(), names.size()) << entry.path();
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto expected = structs.find(kind + "/" + names[i]);
        ASSERT_NE(expected, structs.end()) << entry.path();
        EXPECT_EQ(parts[i], WithoutAdded(expected->second)) << entry.path();
        left.erase(expected->first);
      }
    }
  }
  EXPECT_GT(files, 0);
  // ROS 2 derives these from an action.
  std::erase_if(left, [](const std::string& name) {
    return name.starts_with("action/") &&
           (name.find("_SendGoal_") != std::string::npos ||
            name.find("_GetResult_") != std::string::npos || name.ends_with("_FeedbackMessage"));
  });
  EXPECT_THAT(left, IsEmpty()) << "types of the IDL that are in no file";
}

TEST(RosPackages, HaveTheConstantsAndDefaultsOfTheIdl) {
  EXPECT_THAT(Text(kPackages / "protocol/msg/MotionStatus.msg"), HasSubstr("\nint8 CHARGING=14\n"));
  EXPECT_THAT(Text(kPackages / "musher_msgs/srv/GetSwitch.srv"),
              HasSubstr("\nstring UNDER_WAY=\"under way\"\n"));
  EXPECT_THAT(Text(kPackages / "musher_msgs/msg/PolicyInfo.msg"), HasSubstr("\nint32 battery -1 "));
}

TEST_P(ARosPackage, ListsItsFilesAndTheirDependenciesForColcon) {
  const std::string package = GetParam();
  const std::string cmake = Text(kPackages / package / "CMakeLists.txt");
  const std::string xml = Text(kPackages / package / "package.xml");
  EXPECT_THAT(cmake, HasSubstr("project(" + package + ")"));
  EXPECT_THAT(xml, HasSubstr("<name>" + package + "</name>"));
  EXPECT_THAT(xml, HasSubstr("<member_of_group>rosidl_interface_packages</member_of_group>"));
  for (const auto& entry : fs::recursive_directory_iterator(kPackages / package)) {
    const fs::path path = entry.path().lexically_relative(kPackages / package);
    if (!path.has_parent_path() || entry.is_directory()) continue;
    EXPECT_THAT(cmake, HasSubstr("\"" + path.string() + "\""));
    for (const Fields& part : PartsOf(entry.path())) {
      for (const std::string& field : part) {
        const auto slash = field.find('/');
        if (slash == std::string::npos) continue;
        const std::string needed = field.substr(0, slash);
        EXPECT_THAT(xml, HasSubstr("<depend>" + needed + "</depend>"));
        EXPECT_THAT(cmake, HasSubstr("find_package(" + needed + " REQUIRED)"));
      }
    }
  }
}

}  // namespace musher::ros_packages_test
