// A ROS 2 node whose on_configure fails at the start: the other actuators do not wait for it, the
// reason stays recorded, and the next SelfCheck or switch up configures it again.

#include "musher/test/integration/foreign/mixed_machine.hpp"

namespace musher::testing::configure_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class ANodeThatCannotBeConfigured : public MixedMachine {
 protected:
  void Start() {
    Peer("planner", "fails_while=configure:" + (folder_ / "no_map"));
    // Far longer than a start takes, also on a busy computer.
    Replace("times = [20000, ", "times = [180000, ");  // of the planner, the first one
    std::ofstream(folder_ / "no_map") << "yes";
    const auto begun = std::chrono::steady_clock::now();
    up_ = Musher({"up", config_, "--detach"});
    took_ = std::chrono::steady_clock::now() - begun;
  }
  void Repair() const { std::filesystem::remove(folder_ / "no_map"); }
  std::size_t Tries() const {
    const auto events = Events("planner");
    return static_cast<std::size_t>(std::count(events.begin(), events.end(), "configure"));
  }

  Ended up_;
  std::chrono::steady_clock::duration took_{};
};

TEST_F(ANodeThatCannotBeConfigured, DoesNotDelayTheStartAndItsReasonStays) {
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(up_.exit, 0) << up_.err;
  EXPECT_LT(took_, std::chrono::seconds(90)) << "the time of its SetUp";
  const auto planner = Actuator("planner");
  EXPECT_EQ(planner["degraded"], true);
  EXPECT_THAT(Musher({"status"}).out,
              AllOf(HasSubstr("SetUp failed with"), HasSubstr("configure failed"),
                    Not(HasSubstr("not set up within"))));
  EXPECT_EQ(Tries(), 1);
}

TEST_F(ANodeThatCannotBeConfigured, IsConfiguredByTheNextSwitchToTheCurrentState) {
  ASSERT_NO_FATAL_FAILURE(Start());
  EXPECT_EQ(Musher({"set", "Active"}).exit, 1) << "it fails again";
  EXPECT_EQ(Tries(), 2);
  Repair();
  const Ended set = Musher({"set", "Active"});
  EXPECT_EQ(set.exit, 0) << set.out << set.err;
  EXPECT_EQ(Actuator("planner")["state"], "Active");
  EXPECT_EQ(Actuator("planner")["degraded"], false);
}

TEST_F(ANodeThatCannotBeConfigured, IsConfiguredByASelfCheck) {
  ASSERT_NO_FATAL_FAILURE(Start());
  Repair();
  const Ended set = Musher({"set", "SelfCheck"});
  EXPECT_EQ(set.exit, 0) << set.out << set.err;
  EXPECT_EQ(AwaitStatus(AllHaveArrived)["actuators"]["planner"]["state"], "Active");
}

}  // namespace musher::testing::configure_test
