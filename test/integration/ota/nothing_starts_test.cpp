// A version of which nothing of the first stage can be started goes back by itself, whatever the
// reason and the restart policy: the robot is never left off.

#include <filesystem>
#include <iterator>
#include <tuple>

#include "musher/test/integration/ota/root.hpp"

namespace musher::testing::nothing_starts_test {

using ::testing::HasSubstr;

struct Broken {
  const char* name;
  const char* script;  // of the program that stands in for musher-exec
};

constexpr Broken kBroken[] = {
    {"CannotBeRun", "#!/nosuch/interpreter\n"},
    {"EndsWithAFailure", "#!/bin/sh\nexit 3\n"},
    {"FindsItsConfigWrong", "#!/bin/sh\nexit 2\n"},
    {"EndsWell", "#!/bin/sh\nexit 0\n"},
};

class UpgradeOfWhichNothingStarts
    : public RobotWithUpgrades,
      public ::testing::WithParamInterface<std::tuple<std::size_t, const char*>> {};

TEST_P(UpgradeOfWhichNothingStarts, RollsBackByItselfAndReportsIt) {
  const Broken& broken = kBroken[std::get<0>(GetParam())];
  const std::string restart = std::get<1>(GetParam());
  Make("1.1.0", {.program = broken.script, .restart = restart});
  ASSERT_EQ(UpDetached().exit, 0);
  const Ended installed = Install("1.1.0");
  EXPECT_EQ(installed.exit, 1);
  EXPECT_THAT(installed.err, HasSubstr("version 1.1.0 failed, the robot has rolled back"));
  EXPECT_EQ(Where(), "Active from a");
  EXPECT_EQ(Versions()["last"]["kept"], false);
}

INSTANTIATE_TEST_SUITE_P(Whatever, UpgradeOfWhichNothingStarts,
                         ::testing::Combine(::testing::Range<std::size_t>(0, std::size(kBroken)),
                                            ::testing::Values("no", "on-failure", "always")),
                         [](const auto& combination) {
                           std::string name =
                               std::string(kBroken[std::get<0>(combination.param)].name) +
                               "Restart" + std::get<1>(combination.param);
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace musher::testing::nothing_starts_test
