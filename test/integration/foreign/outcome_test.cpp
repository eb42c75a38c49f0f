// A switch is reported as done only when all actuators are in its target, also when one exits after
// its part while another one is still switching.

#include "musher/test/integration/foreign/mixed_machine.hpp"

namespace musher::testing::outcome_test {

using ::testing::HasSubstr;

class AnOutcome : public MixedMachine {};

TEST_F(AnOutcome, IsNotDoneWhenANodeExitsAfterItsPartWhileASlowModuleStillSwitches) {
  Peer("arm", "takes=LowPower:3000");
  ASSERT_EQ(UpDetached().exit, 0);
  StatusStream statuses;  // it has begun before: a command takes seconds on a busy computer
  statuses.Await(AllHaveArrivedIn("Active"));
  Process set(Command({"set", "LowPower", "--json"}));
  statuses.Await([](const nlohmann::json& status) {
    return status["actuators"]["planner"]["state"] == "LowPower";
  });
  kill(Started("planner").back(), SIGKILL);
  const Ended ended = set.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("planner: "));
  const auto result = Json(ended.out);
  EXPECT_EQ(result["outcome"], "done-degraded");
  EXPECT_EQ(result["actuators"]["planner"]["outcome"], "lost") << result;
  EXPECT_EQ(result["actuators"]["arm"]["outcome"], "done") << result;
}

}  // namespace musher::testing::outcome_test
