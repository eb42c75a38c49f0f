#include "musher/test/house/interface_rules.hpp"

#include <gmock/gmock.h>

namespace musher::house::interface_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<SourceFile> kTree = {
    {"modules/voice/shell.cpp", "Serve<msg::X>(\"stop_play\"); // \"later\"\n", false},
    {"cyberdog/manager.cpp", "PublishFunction<msg::Bool>(\n  \"ready_notify\");", false},
    {"cyberdog/interfaces.hpp", "constexpr const char* kUidSn = \"uid_sn\";", false},
    {"cyberdog/codes/module_codes.cpp", "{module_code::kAd, \"ad\"}", false},
    {"messages/protocol/audio.idl", "@final struct AudioText_Request_ {", false}};

SourceFile Page(const std::string& there, const std::string& left_out) {
  return {"docs/cyberdog.md",
          "`AudioText` `uid_sn`\n## What is implemented\n"
          "| name | |\n|---|---|\n| `ready_notify` | |\n" +
              there + "## What is left out\n| name | why |\n|---|---|\n| `ad` | `stop_play` |\n" +
              left_out,
          false};
}

TEST(InterfaceRules, APageThatMatchesTheCodeIsAccepted) {
  EXPECT_THAT(WrongInterfaces(Page("| `stop_play` | |\n", ""), kTree), IsEmpty());
}

TEST(InterfaceRules, AListedInterfaceThatTheCodeLacksIsReported) {
  EXPECT_THAT(WrongInterfaces(Page("| `stop_play`, `later` | |\n", ""), kTree),
              ElementsAre("docs/cyberdog.md:6: the code has no `later`"));
}

TEST(InterfaceRules, AnInterfaceListedAsLeftOutThatTheCodeHasIsReported) {
  EXPECT_THAT(WrongInterfaces(Page("", "| `stop_play` | no reason |\n"), kTree),
              ElementsAre("docs/cyberdog.md:10: the code has `stop_play`"));
}

TEST(InterfaceRules, AnInterfaceOrATypeMissingInThePageIsReported) {
  const SourceFile page = {
      "docs/cyberdog.md",
      "## What is implemented\n| `stop_play` | |\n## What is left out\n| `ad` | |\n", false};
  EXPECT_THAT(WrongInterfaces(page, kTree),
              ElementsAre("docs/cyberdog.md: `AudioText` is missing",
                          "docs/cyberdog.md: `ready_notify` is missing",
                          "docs/cyberdog.md: `uid_sn` is missing"));
}

TEST(InterfaceRules, AnInterfaceWithoutPermissionsIsReported) {
  const SourceFile constants = {
      "cyberdog/interfaces.hpp",
      "constexpr const char* kReboot = \"reboot\";\nconstexpr const char* kUid = \"uid\";\n"};
  EXPECT_THAT(UnlistedInterfaces(constants, {"cyberdog/interfaces.cpp", "{kUid, kReboot}"}),
              IsEmpty());
  EXPECT_THAT(
      UnlistedInterfaces(constants, {"cyberdog/interfaces.cpp", "{kUid}  // kReboot"}),
      ElementsAre("cyberdog/interfaces.cpp: kReboot is missing: every actuator may use it"));
  EXPECT_THAT(UnlistedInterfaces({"cyberdog/interfaces.hpp", ""}, {}),
              ElementsAre("cyberdog/interfaces.hpp: nothing to compare with"));
}

TEST(InterfaceRules, AModuleWithoutANameAndANameWithoutAModuleAreReported) {
  const SourceFile constants = {
      "cyberdog/codes/module_codes.hpp",
      "inline constexpr ModuleCode kLed{1100};\ninline constexpr ModuleCode kUwb{1600};\n"};
  const auto wrong = [&](const std::string& names) {
    return WronglyNamedModules(constants, {"module_codes.cpp", names});
  };
  EXPECT_THAT(wrong("{module_code::kLed, \"LED\"}, {module_code::kUwb, \"UWB\"}"), IsEmpty());
  EXPECT_THAT(wrong("{module_code::kUwb, \"UWB\"}, {module_code::kUwb, \"Uwb\"}"),
              ElementsAre("module_codes.cpp: kLed has no name",
                          "module_codes.cpp: kUwb has several names"));
  EXPECT_THAT(wrong("{module_code::kLed, \"LED\"}, {module_code::kUwb, \"UWB\"}, "
                    "{module_code::kGps, \"GPS\"}"),
              ElementsAre("module_codes.cpp: kGps is no module"));
}

}  // namespace musher::house::interface_rules_test
