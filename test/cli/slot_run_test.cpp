// The time of a trial boot.

#include "musher/cli/start/slot_run.hpp"

#include <gtest/gtest.h>

#include "musher/transport/linux_event_loop.hpp"

namespace musher::cli::slot_run_test {

// Stopped for most of its time and released shortly before the end, a good version was rolled back.
TEST(TrialBootTime, CountsFromTheReleaseOfAnEmergencyStop) {
  constexpr Duration kTrial = std::chrono::seconds(2);
  transport::LinuxEventLoop loop;
  transport::DiskWriter disk(loop);
  const MachineConfig config;
  Machine machine;
  machine.phase = Phase::kStarting;
  SlotRun run;
  run.root = "/nowhere";
  run.trial = kTrial;
  bool ended = false;
  const TrialBoot trial(
      loop, disk, run, config, [&machine] { return &machine; },
      [&ended](const Result<>& outcome) { ended = !outcome.ok(); });
  const auto is_ended = [&ended] { return ended; };
  machine.emergency.stop = EmergencyStop{StopId(7), "a person", ""};
  EXPECT_FALSE(loop.RunUntil(is_ended, loop.Now() + kTrial - Milliseconds(200)));
  machine.emergency.stop.reset();
  const Time released = loop.Now();
  EXPECT_TRUE(loop.RunUntil(is_ended, released + std::chrono::minutes(1)));
  EXPECT_GE(loop.Now() - released, kTrial - Milliseconds(200));
}

}  // namespace musher::cli::slot_run_test
