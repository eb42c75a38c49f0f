#include "musher/test/house/reference_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::house::reference_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const SourceFile kHeader = {"base/code.hpp",
                            "enum class KeyCode {\n  kOk = 0,\n  kFailed = 1,\n};\n"
                            "enum class ModuleCode {\n  kUnknown = -1,\n  kRobot = 100,\n};\n"};
const SourceFile kCyberdog = {"cyberdog/codes/module_codes.hpp",
                              "inline constexpr ModuleCode kUwb{1600};\n"};

SourceFile PageWith(const std::string& text) {
  return {"docs/reference.md", "# Reference\n\n" + text + "\n## Files\n"};
}

TEST(ReferenceRules, AcceptAListThatAgrees) {
  const SourceFile page =
      PageWith("## Codes\n\n| 1 | Failed | why |\n\n| Robot (the machine) | 100 | UWB | 1600 |\n");
  EXPECT_THAT(WrongCodes(page, kHeader, kCyberdog), IsEmpty());
}

TEST(ReferenceRules, ReportACodeThatIsMissingWrongOrRemoved) {
  const SourceFile page =
      PageWith("## Codes\n\n| 7 | Timeout | why |\n\n| Robot (the machine) | 200 | UWB | 1600 |\n");
  EXPECT_THAT(WrongCodes(page, kHeader, kCyberdog),
              ElementsAre("the reference does not list the key failed", "there is no key timeout",
                          "the reference says 200 for the module robot, which is 100"));
  EXPECT_THAT(WrongCodes(PageWith("## Codes\n\n| 1 | Failed | why |\n\n| Robot | 100 |\n"), kHeader,
                         kCyberdog),
              ElementsAre("the reference does not list the module uwb"));
}

TEST(ReferenceRules, ReportAVariableThatIsUnexplainedOrRemoved) {
  const SourceFile page = PageWith("## Environment variables\n\n| `MUSHER_OLD` | all | gone |\n");
  const SourceFile code = {"controller/a.cpp", "getenv(\"MUSHER_NEW\");"};
  EXPECT_THAT(WrongVariables(page, {code}), ElementsAre("the reference does not explain MUSHER_NEW",
                                                        "no program reads or sets MUSHER_OLD"));
}

TEST(ReferenceRules, ReportATopicOrServiceThatIsUnlistedOrRemovedOrOfAnUnknownType) {
  const SourceFile page = PageWith(
      "## Topics and services\n\n| name | type |\n|---|---|\n"
      "| topic `musher/beat` | `musher_msgs/msg/Beat` | all |\n"
      "| topic `musher/old` | `musher_msgs/msg/Old` | all |\n"
      "| service `musher/get_plan` | `musher_msgs/srv/GetPlan` | all |\n");
  const std::vector<SourceFile> tree = {
      {"wire/names.cpp",
       "ResolveName(name_space, \"musher/beat\"); ResolveName(name_space, \"musher/new\");"},
      {"controller/shell/services.cpp", "Serve(get_plan_, \"get_plan\","},
      {"messages/musher_msgs/a.idl", "struct Beat_ {\n};\nstruct GetPlan_Request_ {\n};\n"}};
  EXPECT_THAT(WrongTopicsAndServices(page, tree),
              ElementsAre("there is no type musher_msgs/msg/Old",
                          "the reference does not list musher/new", "no program has musher/old"));
}

TEST(ReferenceRules, ReportAPythonNameThatNoDirectiveHas) {
  const SourceFile page = {
      "docs/api/python.md",
      "`Old` is text\n```{python_reference} python/musher/_a.py Actuator run\n"};
  const std::vector<SourceFile> tree = {
      {"python/musher/__init__.py",
       "__all__ = [\n    \"Actuator\", \"Old\", \"__version__\", \"fsm\",\n    \"run\",\n]\n"},
      {"python/musher/fsm.py", "__all__ = [\"State\"]\n"},
      {"python/musher/_private.py", "__all__ = [\"Hidden\"]\n"}};
  EXPECT_THAT(
      PythonNamesOutsideTheReference(page, tree),
      ElementsAre("python/musher/__init__.py offers Old", "python/musher/fsm.py offers State"));
}

}  // namespace musher::house::reference_rules_test
