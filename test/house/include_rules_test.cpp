#include "musher/test/house/include_rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace musher::house::include_rules_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

SourceFile Including(const std::string& path, const std::string& header) {
  return {path, "#pragma once\n#include " + header + "\n"};
}

TEST(IncludeRules, ReportFileAndLineWhenAFolderReachesUp) {
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/a.cpp", "\"musher/transport/node.hpp\"")),
              ElementsAre("lifecycle/a.cpp:2: lifecycle may not include transport"));
  EXPECT_THAT(ForbiddenIncludes(Including("transport/a.cpp", "\"musher/lifecycle/state.hpp\"")),
              ElementsAre("transport/a.cpp:2: transport may not include lifecycle"));
}

// A test of the core that included a header of the upgrades could not be linked without them.
TEST(IncludeRules, TestsOfTheCoreIncludeNothingOfTheFloorsAbove) {
  EXPECT_THAT(ForbiddenIncludes(Including("test/wire/a.cpp", "\"musher/ota/disk.hpp\"")),
              ElementsAre("test/wire/a.cpp:2: test/wire is of the core and may not include ota"));
  EXPECT_THAT(ForbiddenIncludes(Including("test/ota/a.cpp", "\"musher/ota/disk.hpp\"")), IsEmpty());
}

TEST(IncludeRules, KeepTheKernelOutOfPureFolders) {
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/a.cpp", "\"musher/base/host.hpp\"")),
              ElementsAre("lifecycle/a.cpp:2: lifecycle may not include base/host.hpp"));
  EXPECT_THAT(ForbiddenIncludes(Including("transport/a.cpp", "\"musher/base/host.hpp\"")),
              IsEmpty());
}

TEST(IncludeRules, KeepControllerAndActuatorApart) {
  const std::string actuator = "\"musher/actuator/worker.hpp\"";
  const std::string controller = "\"musher/controller/journal/journal.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("controller/a.hpp", actuator)), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("actuator/a.hpp", controller)), SizeIs(1));
}

TEST(IncludeRules, LetAFolderIncludeWhatIsBelowIt) {
  for (const char* folder : {"base", "lifecycle", "messages", "transport", "actuator"}) {
    const std::string header = "\"musher/" + std::string(folder) + "/a.hpp\"";
    EXPECT_THAT(ForbiddenIncludes(Including("modules/exec/a.cpp", header)), IsEmpty());
  }
}

TEST(IncludeRules, LetOnlyTheCommandLineOfTheControllerIncludeTheSimulation) {
  const std::string simulation = "\"musher/simulation/robot.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("cli/commands/a.cpp", simulation)), IsEmpty());
  EXPECT_THAT(ForbiddenIncludes(Including("controller/process/a.cpp", simulation)), SizeIs(1));
}

TEST(IncludeRules, LetModulesIncludeTheCodesOfCyberdogAndNotTheRestOfIt) {
  const std::string codes = "\"musher/cyberdog/codes/module_codes.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("modules/motion/a.cpp", codes)), IsEmpty());
  EXPECT_THAT(ForbiddenIncludes(Including("cyberdog/sounds.cpp", codes)), IsEmpty());
  EXPECT_THAT(ForbiddenIncludes(Including("actuator/a.cpp", codes)),
              ElementsAre("actuator/a.cpp:2: actuator may not include cyberdog"));
  const std::string manager = "\"musher/cyberdog/manager.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("modules/motion/a.cpp", manager)),
              ElementsAre("modules/motion/a.cpp:2: modules may not include cyberdog"));
  EXPECT_THAT(ForbiddenIncludes(Including("python/native/a.cpp", manager)), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("modules/motion/a.cpp", "\"musher/cyberdog/codes.hpp\"")),
              SizeIs(1));
}

TEST(IncludeRules, LetTheCodesOfCyberdogIncludeOnlyTheBase) {
  const auto including = [](const std::string& header) {
    return ForbiddenIncludes(Including("cyberdog/codes/a.hpp", "\"musher/" + header + "\""));
  };
  EXPECT_THAT(including("base/code.hpp"), IsEmpty());
  EXPECT_THAT(including("cyberdog/numbers.hpp"),
              ElementsAre("cyberdog/codes/a.hpp:2: cyberdog/codes may not include cyberdog"));
  EXPECT_THAT(including("lifecycle/state.hpp"), SizeIs(1));
}

TEST(IncludeRules, KeepTheRoomsOfAFolderInTheirLayers) {
  const std::string switching = "\"musher/lifecycle/switch/switches.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/coordinator/a.cpp", switching)), IsEmpty());
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/switch/a.cpp", switching)), IsEmpty());
  EXPECT_THAT(
      ForbiddenIncludes(Including("lifecycle/machine/a.cpp", switching)),
      ElementsAre("lifecycle/machine/a.cpp:2: room 'machine' may not include room 'switch'"));
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/per_actuator.hpp", switching)), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("lifecycle/new/a.cpp", switching)),
              ElementsAre("lifecycle/new/a.cpp:2: room 'new' of lifecycle has no layer"));
  const std::string dds = "\"musher/transport/dds/dds_node.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("transport/sim/a.cpp", dds)), SizeIs(1))
      << "one beside it";
  EXPECT_THAT(ForbiddenIncludes(Including("view/main.cpp", "\"musher/view/live/page.hpp\"")),
              IsEmpty())
      << "a program is above its folder";
}

TEST(IncludeRules, ReportAFolderThatHasNoRow) {
  EXPECT_THAT(ForbiddenIncludes(Including("tools/a.cpp", "\"musher/base/result.hpp\"")),
              ElementsAre("tools/a.cpp:2: tools has no row in the table of what it may include"));
}

TEST(IncludeRules, KeepTheKernelOutOfNavigation) {
  EXPECT_THAT(ForbiddenIncludes(Including("navigation/a.cpp", "\"musher/base/host.hpp\"")),
              SizeIs(1));
}

TEST(IncludeRules, KeepModulesApartFromEachOther) {
  const std::string header = "\"musher/modules/world/body/body.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("modules/exec/a.cpp", header)), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("modules/world/a.cpp", header)), IsEmpty());
}

TEST(IncludeRules, LeaveDdsToItsFolder) {
  EXPECT_THAT(ForbiddenIncludes(Including("transport/node.hpp", "<dds/dds.h>")), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("transport/dds/a.cpp", "<dds/dds.h>")), IsEmpty());
}

TEST(IncludeRules, KeepHeavyLibrariesOutOfHeadersThatOtherFoldersMayInclude) {
  EXPECT_THAT(ForbiddenIncludes(Including("controller/a.hpp", "<nlohmann/json.hpp>")),
              ElementsAre("controller/a.hpp:2: <nlohmann/json.hpp> is too heavy for a header of "
                          "controller"));
  EXPECT_THAT(ForbiddenIncludes(Including("cli/a.hpp", "<CLI/CLI.hpp>")), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("navigation/a.hpp", "<fmt/format.h>")), SizeIs(1));
  EXPECT_THAT(ForbiddenIncludes(Including("controller/a.cpp", "<nlohmann/json.hpp>")), IsEmpty());
  EXPECT_THAT(ForbiddenIncludes(Including("controller/a.hpp", "<nlohmann/json_fwd.hpp>")),
              IsEmpty());
}

TEST(IncludeRules, LetHeadersThatNoOtherFolderMayIncludeHaveHeavyLibraries) {
  for (const char* header : {"modules/vision/a.hpp", "view/live/a.hpp", "test/modules/a.hpp"}) {
    EXPECT_THAT(ForbiddenIncludes(Including(header, "<opencv2/core.hpp>")), IsEmpty()) << header;
  }
  EXPECT_THAT(ForbiddenIncludes(Including("view/json/a.hpp", "<opencv2/core.hpp>")),
              ElementsAre("view/json/a.hpp:2: <opencv2/core.hpp> has no place in view"));
}

TEST(IncludeRules, LetTestsIncludeAllHeadersOfMusher) {
  const std::string header = "\"musher/controller/journal/journal.hpp\"";
  EXPECT_THAT(ForbiddenIncludes(Including("test/lifecycle/a.cpp", header)), IsEmpty());
}

TEST(IncludeRules, ReportFoldersAndSubfoldersThatIncludeEachOther) {
  const SourceFile shell = Including("controller/shell/a.hpp", "\"musher/controller/link/b.hpp\"");
  const SourceFile link = Including("controller/link/b.cpp", "\"musher/controller/shell/a.hpp\"");
  EXPECT_THAT(IncludeCycles({shell, link}),
              ElementsAre("controller/link includes controller/shell, which includes it",
                          "controller/shell includes controller/link, which includes it"));
  EXPECT_THAT(IncludeCycles({shell}), IsEmpty());
}

TEST(IncludeRules, ReportAFolderAndItsOwnSubfolderThatIncludeEachOther) {
  const SourceFile up = Including("modules/race/race.cpp", "\"musher/modules/race/tool/a.hpp\"");
  const SourceFile down = Including("modules/race/tool/a.hpp", "\"musher/modules/race/race.hpp\"");
  const SourceFile main = Including("modules/race/main.cpp", "\"musher/modules/race/tool/a.hpp\"");
  EXPECT_THAT(IncludeCycles({up, down}), SizeIs(2));
  EXPECT_THAT(IncludeCycles({main, down}), IsEmpty());
}

}  // namespace musher::house::include_rules_test
