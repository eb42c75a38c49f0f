// The health of a ROS 2 node, which sends no heartbeats and is queried.

#include <gmock/gmock.h>

#include "musher/lifecycle/health/health_monitor.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::ros2_health_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class HealthOfARos2Node : public ::testing::Test {
 protected:
  explicit HealthOfARos2Node(std::optional<Duration> checkpoint = Milliseconds(400))
      : config_(MachineOf(1)) {
    config_.actuators[0].protocol = Protocol::kRos2Lifecycle;
    config_.actuators[0].checkpoint = checkpoint;
  }
  void Watch(bool local) { monitor_.Watch(0, 7, local ? "here" : "", local, now_); }
  std::vector<HealthEvent> Pass(Duration duration) {
    now_ += duration;
    return monitor_.TimePassed(now_);
  }
  static const health_event::Changed* ChangeIn(const std::vector<HealthEvent>& events) {
    for (const HealthEvent& event : events) {
      if (const auto* changed = std::get_if<health_event::Changed>(&event)) return changed;
    }
    return nullptr;
  }

  MachineConfig config_;
  HealthMonitor monitor_{config_};
  Time now_{std::chrono::hours(1)};
};

TEST_F(HealthOfARos2Node, IsQueriedTwiceInItsCheckpoint) {
  Watch(true);
  for (int i = 0; i < 10; ++i) {
    const auto events = Pass(Milliseconds(200));
    ASSERT_THAT(events, SizeIs(2));
    EXPECT_TRUE(std::holds_alternative<health_event::Examine>(events[0]));
    EXPECT_TRUE(std::holds_alternative<health_event::Probe>(events[1]));
    EXPECT_THAT(monitor_.OnSample(0, 7, now_), IsEmpty());
  }
}

TEST_F(HealthOfARos2Node, IsHungWhenItDoesNotAnswerTheQuery) {
  Watch(true);
  Pass(Milliseconds(200));
  EXPECT_THAT(Pass(Milliseconds(201)), SizeIs(1));
  const auto events =
      monitor_.Examined(0, {Examination::Process::kStopped, Duration::zero()}, now_);
  ASSERT_NE(ChangeIn(events), nullptr);
  EXPECT_EQ(ChangeIn(events)->health, Health::kHung);
  EXPECT_THAT(ChangeIn(events)->how, HasSubstr("its process is stopped"));
}

TEST_F(HealthOfARos2Node, IsHungAsWellWhereItsHostIsNotKnown) {
  Watch(false);
  Pass(Milliseconds(200));
  const auto events = Pass(Milliseconds(201));
  ASSERT_NE(ChangeIn(events), nullptr);
  EXPECT_EQ(ChangeIn(events)->health, Health::kHung);
}

class HealthOfARos2NodeWithoutCheckpoint : public HealthOfARos2Node {
 protected:
  HealthOfARos2NodeWithoutCheckpoint() : HealthOfARos2Node(std::nullopt) {}
};

TEST_F(HealthOfARos2NodeWithoutCheckpoint, IsNotQueried) {
  Watch(true);
  EXPECT_FALSE(monitor_.NextDeadline());
}

}  // namespace musher::testing::ros2_health_test
