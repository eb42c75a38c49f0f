#include "musher/wire/lifecycle_wire.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>

namespace musher::transport::lifecycle_wire_test {

ActuatorReport Stamped(std::int64_t stamp_ns) {
  msg::ActuatorStatus status;
  status.stamp_ns = stamp_ns;
  return FromMessage(status);
}

// A value of its own in each field, whatever fields the IDL has.
msg::ActuatorStatus Filled() {
  msg::ActuatorStatus status;
  int number = 0;
  const auto fill = [&](auto& field) {
    using Field = std::remove_reference_t<decltype(field)>;
    ++number;
    if constexpr (std::is_same_v<Field, std::string>) {
      field = std::to_string(number);
    } else if constexpr (std::is_same_v<Field, bool>) {
      field = true;
    } else {
      field = static_cast<Field>(number);
    }
  };
  std::apply([&](auto&... fields) { (fill(fields), ...); }, msg::ActuatorStatus::Fields(status));
  return status;
}

TEST(LifecycleWire, PassesEveryFieldOfAStatusToTheCoreAndBack) {
  msg::ActuatorStatus status = Filled();
  // Its shell adds the machine and the participant, which are the same for each report, and what
  // the program has not done at a stop.
  status.stop_trouble.clear();
  status.participant = 0;
  status.machine.clear();
  status.machine_id.clear();
  EXPECT_EQ(ToMessage(status.name, FromMessage(status)), status);
}

TEST(LifecycleWire, KeepsTheStampOfAClock) {
  const Time now(std::chrono::hours(24 * 365 * 10));
  EXPECT_EQ(Stamped(ToNanoseconds(now)).stamp, now);
}

TEST(LifecycleWire, ClampsAStampThatIsOutOfRange) {
  const Time now(std::chrono::hours(24 * 365 * 10));
  EXPECT_LT(Stamped(INT64_MIN).stamp - now, Duration::zero());
  EXPECT_GT(Stamped(INT64_MAX).stamp - now + std::chrono::hours(1), Duration::zero());
}

// With keys an actuator can write in the partition of its name only.
TEST(LifecycleWire, TakesWhatNamesAnActuatorFromThePartitionOfThatActuatorOnly) {
  SampleInfo info;
  info.participant = ParticipantId(7);
  msg::ActuatorStatus status;
  status.name = "arm";
  EXPECT_TRUE(IsFrom("arm", info)) << "without keys there is no partition";
  EXPECT_TRUE(IsFrom(status, info));
  info.partition = "legs";
  EXPECT_FALSE(IsFrom("arm", info));
  EXPECT_FALSE(IsFrom(status, info));
  info.partition = "arm";
  EXPECT_TRUE(IsFrom("arm", info));
  EXPECT_TRUE(IsFrom(status, info));
}

TEST(LifecycleWire, TakesWhatNamesAParticipantFromThatParticipantOnly) {
  SampleInfo info;
  info.participant = ParticipantId(7);
  EXPECT_TRUE(IsOwn(0, info)) << "an older version names none";
  EXPECT_TRUE(IsOwn(7, info));
  EXPECT_FALSE(IsOwn(8, info));
  msg::ActuatorStatus status;
  status.participant = 8;
  EXPECT_FALSE(IsFrom(status, info));
}

}  // namespace musher::transport::lifecycle_wire_test
