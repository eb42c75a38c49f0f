// The stream of statuses that the tests of real processes wait on.

#include <gtest/gtest-spi.h>
#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::status_stream_test {

using ::testing::AnyOf;

class Statuses : public MachineByCli {
 protected:
  static bool Any(const nlohmann::json&) { return true; }
};

TEST_F(Statuses, BeginWithWhatTheCommandBeforeHasDone) {
  ASSERT_EQ(UpDetached().exit, 0);
  for (int i = 0; i < 20; ++i) {
    const char* state = i % 2 == 0 ? "LowPower" : "Active";
    ASSERT_EQ(Musher({"set", state}).exit, 0);
    const auto status = AwaitStatus(Any);
    EXPECT_EQ(status["state"], state);
    EXPECT_TRUE(status["target"].is_null());
    EXPECT_EQ(status, Status());
  }
}

TEST_F(Statuses, AreAlsoAwaitedOverSeveralCommands) {
  ASSERT_EQ(UpDetached().exit, 0);
  StatusStream statuses;
  const auto before = statuses.Await(Any);
  EXPECT_EQ(statuses.Await(Any), before) << "it still is so";
  for (const char* state : {"LowPower", "Active"}) {
    ASSERT_EQ(Musher({"set", state}).exit, 0);
    EXPECT_GT(statuses.Await(AllHaveArrivedIn(state))["switch"], before["switch"]);
  }
}

TEST_F(Statuses, GoOnWithTheNextController) {
  ASSERT_EQ(UpDetached().exit, 0);
  StatusStream statuses;
  const auto first = statuses.Await(AllHaveArrived);
  kill(first["pid"].get<pid_t>(), SIGKILL);
  ASSERT_EQ(UpDetached().exit, 0);
  const auto second = statuses.Await([&](const auto& status) {
    return status["epoch"] > first["epoch"] && AllHaveArrived(status);
  });
  EXPECT_NE(second["pid"], first["pid"]);
}

TEST_F(Statuses, AreAwaitedFromAControllerThatDoesNotLeadYet) {
  StatusStream statuses;
  const Process up(Command({"up", config_}));
  EXPECT_THAT(statuses.Await(Any)["phase"], AnyOf("starting", "running"));
  statuses.Await(AllHaveArrivedIn("Active"));
}

TEST_F(Statuses, OfAWrongCommandFailTheTestWithItsReason) {
  setenv("ROS_DOMAIN_ID", "300", 1);
  EXPECT_NONFATAL_FAILURE(AwaitStatus(Any), "0 to 232");
}

}  // namespace musher::testing::status_stream_test
