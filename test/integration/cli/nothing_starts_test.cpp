// Nothing of the first stage can be started, whatever the reason and the restart policy, through
// the real program.

#include <filesystem>
#include <iterator>
#include <tuple>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::nothing_starts_test {

using ::testing::HasSubstr;
using ::testing::Not;

struct Broken {
  const char* name;
  const char* script;  // of the program that stands in for musher-exec
  const char* words;   // that the outcome has to name
};

constexpr Broken kBroken[] = {
    {"CannotBeRun", "#!/nosuch/interpreter\n", "could not be started"},
    {"EndsWithAFailure", "#!/bin/sh\nexit 3\n", "exit code 3"},
    {"FindsItsConfigWrong", "#!/bin/sh\nexit 2\n", "exit code 2"},
    {"EndsWell", "#!/bin/sh\nexit 0\n", "exit code 0"},
    {"IsKilled", "#!/bin/sh\nkill -9 $$\n", "SIGKILL"},
};

class NothingStarts : public MachineByCli,
                      public ::testing::WithParamInterface<std::tuple<std::size_t, const char*>> {
 protected:
  NothingStarts() {
    const std::string program = folder_ / "broken";
    std::ofstream(program) << broken().script;
    std::filesystem::permissions(program, std::filesystem::perms(0755));
    std::string config = ReadFile(config_);
    for (std::size_t at = 0; (at = config.find("\"musher-exec\"", at)) != std::string::npos;) {
      config.replace(at, 13, "\"" + program + "\"");
    }
    for (std::size_t at = 0; (at = config.find("[actuator.", at)) != std::string::npos;) {
      at = config.find('\n', at) + 1;
      config.insert(at, std::string("restart = \"") + std::get<1>(GetParam()) +
                            "\"\nrestart_delay_ms = 10\nrestart_limit = 1\n");
    }
    std::ofstream(config_) << config;
  }
  static const Broken& broken() { return kBroken[std::get<0>(GetParam())]; }
};

TEST_P(NothingStarts, TheStartFailsWithTheReasonAndTheControllerStaysUntilItIsTakenDown) {
  const Ended up = Musher({"up", config_, "--detach"});
  EXPECT_EQ(up.exit, 1) << up.err;
  EXPECT_THAT(up.err, HasSubstr(broken().words));
  EXPECT_THAT(up.err, Not(HasSubstr("SIGSEGV")));
  EXPECT_EQ(Status()["phase"], "failed");
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 0) << down.err;
  EXPECT_EQ(Musher({"status"}).exit, 3);
  EXPECT_TRUE(AwaitNoChildren());
}

INSTANTIATE_TEST_SUITE_P(Whatever, NothingStarts,
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
