// What CyberDog's manager reads from [policy]. The messages for invalid keys are in test/golden.

#include "musher/cyberdog/voice_policy.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "musher/lifecycle/config/config_toml.hpp"

namespace musher::cyberdog::voice_policy_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

PolicyConfig Read(const std::string& policy) {
  auto reading = ReadConfigText(R"(
[controller]
actuators = ["wheels"]
states = ["SetUp", "TearDown", "Active", "LowPower"]
default_time = 250
default_state = "Uninitialized"
[actuator.wheels]
states = ["SetUp", "TearDown", "Active", "LowPower"]
times = [8000, 4000, 2000, 900]
[policy]
)" + policy,
                                "/robots/dog.toml");
  EXPECT_FALSE(HasError(reading.diagnostics));
  return reading.config.value().policy.value();
}

TEST(VoicePolicy, HasItsDefaultsWithoutATable) {
  const PolicyConfig policy = Read("manager = true");
  EXPECT_EQ(VoiceOf(policy).say.size(), kOccasions.size());
  EXPECT_EQ(VoiceOf(policy).battery_at, 30);
  EXPECT_FALSE(VoiceOf(policy).quiet_asleep);
  EXPECT_THAT(policy.manager_policy.Keys(), IsEmpty());
}

TEST(VoicePolicy, IsPartOfWhatTwoConfigsDifferIn) {
  const std::string voice = "manager = true\n[policy.voice]\n";
  const PolicyConfig quiet = Read(voice + "say = [\"touch\", \"start\"]\nquiet_asleep = true");
  using Key = ManagerPolicy::Key;
  EXPECT_THAT(quiet.manager_policy.Keys(),
              ElementsAre(Key{"policy.voice", "say", {"start", "touch"}, true},
                          Key{"policy.voice", "battery_at", {"30 %"}},
                          Key{"policy.voice", "quiet_asleep", {"true"}}));
  EXPECT_NE(quiet, Read(voice));
  EXPECT_EQ(Read(voice), Read(voice + "battery_at = 30"));
  EXPECT_EQ(Read(voice), PolicyConfig(Read(voice)));
}

TEST(VoicePolicy, AnnouncesAnEmptyBatteryBeforeTheRobotGoesOff) {
  EXPECT_EQ(Read("manager = true\n[policy.power_off]\ndelay_s = 3").empty_battery_delay,
            std::chrono::seconds(3));
  EXPECT_EQ(Read("manager = true\n[policy.voice]\nsay = [\"touch\"]").empty_battery_delay,
            Duration{});
  EXPECT_EQ(Read("manager = false").empty_battery_delay, Duration{});
}

TEST(VoicePolicy, KnowsTheMotionsOfARobotThatLies) {
  EXPECT_THAT(Read("[policy.low_power]").low_power->motion_ids, ElementsAre(0, 101));
  EXPECT_THAT(Read("[policy.low_power]\nmotion_ids = [7]").low_power->motion_ids, ElementsAre(7));
}

}  // namespace musher::cyberdog::voice_policy_test
