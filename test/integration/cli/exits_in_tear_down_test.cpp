// A process that ends itself with exit code 0 in the middle of its TearDown.

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::exits_in_tear_down_test {

using ::testing::HasSubstr;

class ExitsInTearDown : public MachineByCli {
 protected:
  ExitsInTearDown() {
    const std::string states = R"(["SetUp", "TearDown", "SelfCheck", "Active", "LowPower"])";
    std::ofstream(config_)
        << "[controller]\nname = \"robot\"\nactuators = [\"arm\"]\nstates = " << states
        << "\ndefault_time = 2000\ndefault_state = \"Uninitialized\"\nnamespace = \"" << name_space_
        << "\"\nstate_dir = \"state\"\n[actuator.arm]\nstates = " << states
        << "\ntimes = [10000, 5000, 5000, 5000, 5000]\ncommand = [\"" << BinDir()
        << "/cli_exits_in_tear_down\", \"" << motor_ << "\"]\n";
  }

  const std::string motor_ = folder_ / "motor";
};

// Its exit code 0 counted as the end of its TearDown: \"done\", with the motors on.
TEST_F(ExitsInTearDown, IsNotTornDown) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  const Ended down = Musher({"down"});
  EXPECT_EQ(down.exit, 1) << down.out;
  EXPECT_THAT(up.LineWith("arm's process"), HasSubstr("ended: exit code 1"));
}

// The guard ended the process at once, and the motor stayed on.
TEST_F(ExitsInTearDown, DoesWhatTheProgramDoesAtItsExit) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  EXPECT_EQ(Musher({"down"}).exit, 1);
  EXPECT_EQ(ReadFile(motor_), "off");
}

// Likewise by itself.
TEST_F(ExitsInTearDown, IsNotTornDownAlone) {
  Process up(Command({"up", config_}));
  ASSERT_NE(up.LineWith("the machine is Active"), "");
  EXPECT_EQ(Musher({"set", "TearDown", "arm"}).exit, 1);
  EXPECT_EQ(Musher({"down"}).exit, 1);
}

}  // namespace musher::testing::exits_in_tear_down_test
