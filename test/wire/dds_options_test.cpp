// What a state config gives the DDS node of one of its processes.

#include "musher/wire/dds_options.hpp"

#include <gtest/gtest.h>

namespace musher::transport::dds_options_test {

MachineConfig MachineOf(std::size_t processes, std::size_t started_by_others) {
  MachineConfig config;
  config.actuators.resize(processes + started_by_others);
  for (ActuatorIndex i; i < ActuatorIndex(processes); ++i) config.actuators[i].command = {"motion"};
  return config;
}

DiscoveryTiming TimingOf(const MachineConfig& config) {
  return OptionsFor(config, "motion", "motion").discovery;
}

TEST(DdsOptions, HaveTheTimingOfACrowdFromSixtyFourStartedProcessesOn) {
  EXPECT_EQ(TimingOf(MachineOf(63, 0)), DiscoveryTiming::kCombined);
  EXPECT_EQ(TimingOf(MachineOf(64, 0)), DiscoveryTiming::kCombinedLong);
}

// Several actuators that the controller does not start may share a process.
TEST(DdsOptions, CountOnlyProcessesThatTheControllerStarts) {
  EXPECT_EQ(TimingOf(MachineOf(8, 248)), DiscoveryTiming::kCombined);
}

// With 50 in each of two stages and an actuator's timing an emergency stop was not confirmed for
// seconds while the second stage started.
TEST(DdsOptions, CountTheProcessesOfAllStages) {
  MachineConfig config = MachineOf(100, 0);
  for (ActuatorIndex i = 50; i < 100; ++i) config.actuators[i].stage = 2;
  EXPECT_EQ(TimingOf(config), DiscoveryTiming::kCombinedLong);
}

TEST(DdsOptions, DoNotCountNodesOfRos2) {
  MachineConfig config = MachineOf(64, 0);
  config.actuators[0].protocol = Protocol::kRos2Lifecycle;
  EXPECT_EQ(TimingOf(config), DiscoveryTiming::kCombined);
}

}  // namespace musher::transport::dds_options_test
