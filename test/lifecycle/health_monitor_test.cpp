#include "musher/lifecycle/health/health_monitor.hpp"

#include <gmock/gmock.h>

#include <functional>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::health_monitor_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Process = Examination::Process;

constexpr Duration kHeartbeat = Milliseconds(100);  // so the limit is 300 ms
constexpr Incarnation kFirst = 7;                   // the incarnation of each

// The fixture of the monitor: the heartbeats, the kernel's answers, and all findings, as text.
class Monitor : public ::testing::Test {
 protected:
  Monitor() : config_(MachineOf(3)), monitor_(config_), now_(std::chrono::hours(1)) {}

  void Watch(ActuatorIndex i, bool local, const std::string& host = "here") {
    monitor_.Watch(i, kFirst, host, local, now_);
    local_[i] = local;
    heartbeats_[i] = true;
    Take(monitor_.OnSample(i, kFirst, Heartbeat{kHeartbeat, Health::kWell, "", {}, {}}, now_));
  }

  // Advances time; heartbeats arrive, and deadlines are handled, `late` each.
  void RunFor(Duration duration, Duration late = {}) {
    const Time end = now_ + duration;
    while (true) {
      const auto next = monitor_.NextDeadline();
      const Time at = std::min(next ? *next + late : Time::max(), next_heartbeat_);
      if (at > end) break;
      now_ = std::max(now_, at);
      if (now_ >= next_heartbeat_) {
        HeartbeatAll();
      } else {
        const Time looked = now_;
        Take(monitor_.TimePassed(now_));
        const auto again = monitor_.NextDeadline();
        ASSERT_TRUE(!again || *again > looked) << "the loop would spin";
      }
    }
    now_ = end;
  }
  void HeartbeatAll() {
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (heartbeats_[i]) Take(monitor_.OnSample(i, kFirst, heartbeat_[i], now_));
    }
    next_heartbeat_ = now_ + kHeartbeat;
  }

  void Take(const std::vector<HealthEvent>& events) {
    for (const HealthEvent& event : events) {
      if (const auto* probe = std::get_if<health_event::Probe>(&event)) {
        found_.push_back("probe " + Name(probe->actuator));
        if (answers_[probe->actuator]) Take(monitor_.OnSample(probe->actuator, kFirst, now_));
      } else if (const auto* look = std::get_if<health_event::Examine>(&event)) {
        found_.push_back((look->mark ? "mark " : "examine ") + Name(look->actuator));
        if (!look->mark) Take(monitor_.Examined(look->actuator, kernel_, now_));
      } else if (const auto* changed = std::get_if<health_event::Changed>(&event)) {
        EXPECT_EQ(changed->incarnation, kFirst);
        found_.push_back(Name(changed->actuator) + " " + std::string(HealthName(changed->health)) +
                         (changed->silent ? ", silent" : ""));
        how_ = changed->how;
      }
    }
  }
  static std::string Name(ActuatorIndex i) {
    return std::string(1, static_cast<char>('a' + i.value()));
  }
  std::vector<std::string> Found() { return std::exchange(found_, {}); }

  MachineConfig config_;
  HealthMonitor monitor_;
  Time now_;
  Time next_heartbeat_ = Time::min();
  PerActuator<bool> heartbeats_ = PerActuator<bool>(3);
  PerActuator<Heartbeat> heartbeat_{3, {kHeartbeat, Health::kWell, "", {}, {}}};
  PerActuator<bool> answers_ = PerActuator<bool>(3);
  PerActuator<bool> local_ = PerActuator<bool>(3);
  Examination kernel_;
  std::vector<std::string> found_;
  std::string how_;
};

TEST_F(Monitor, FindsNothingWhileAllHeartbeatsArrive) {
  Watch(0, true);
  Watch(1, false, "there");
  RunFor(std::chrono::hours(1));
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_F(Monitor, ProbesAndMarksAtHalfTheLimitAndExaminesAtTheLimit) {
  Watch(0, true);
  RunFor(Milliseconds(10));
  heartbeats_[0] = false;
  RunFor(Milliseconds(145));
  EXPECT_THAT(Found(), ElementsAre("mark a", "probe a"));
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("examine a", "a hung, silent"));
  EXPECT_THAT(how_, HasSubstr("no heartbeat for 300 ms"));
  RunFor(std::chrono::hours(1));
  EXPECT_THAT(Found(), IsEmpty()) << "a verdict is reported once";
  EXPECT_FALSE(monitor_.NextDeadline());
}

TEST_F(Monitor, AProcessThatAnswersTheProbeIsAliveThoughItsHeartbeatsAreLost) {
  Watch(0, true);
  heartbeats_[0] = false;
  answers_[0] = true;
  RunFor(std::chrono::minutes(1));
  const auto found = Found();
  EXPECT_THAT(found, ::testing::Contains("probe a"));
  EXPECT_THAT(found, ::testing::Each(::testing::AnyOf("mark a", "probe a")));
}

TEST_F(Monitor, AProcessThatWaitedForACpuIsStarvedAndExaminedAgain) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_.waited = Milliseconds(200);  // all the time since the mark
  RunFor(Milliseconds(401));
  EXPECT_THAT(Found(), ElementsAre("mark a", "probe a", "examine a", "a starved, silent"));
  kernel_.waited = Milliseconds(900);
  RunFor(Milliseconds(600));
  EXPECT_THAT(Found(), ::testing::Each("examine a")) << "it still is";
  kernel_.waited = Milliseconds(901);  // it got a CPU since, and is still silent
  RunFor(Milliseconds(700));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

// At a load of 29 beside a busy disk a healthy actuator was killed: it had waited for a CPU for
// 742 ms only, and for the disk for the rest.
TEST_F(Monitor, AProcessThatWaitedForACpuAndThenForTheDiskIsStarvedAndNotHung) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_.waited = Milliseconds(100);
  kernel_.on_disk = Milliseconds(100);
  RunFor(Milliseconds(401));
  EXPECT_THAT(Found(), ElementsAre("mark a", "probe a", "examine a", "a starved, silent"));
  EXPECT_THAT(how_, HasSubstr("no heartbeat for 300 ms, 100 ms of them waiting for a CPU and for "
                              "the disk 100 ms"));
  RunFor(Milliseconds(700));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
  EXPECT_THAT(how_, HasSubstr("although it waited for a CPU for only 100 ms and for the disk for "
                              "100 ms"));
}

// As one does in a disk that has failed: the robot must not count on it for ever.
TEST_F(Monitor, AProcessThatWaitsForTheDiskForLongerThanADiskIsBusyHangs) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_.on_disk = std::chrono::hours(1);
  RunFor(std::chrono::seconds(10));
  EXPECT_THAT(Found(), ::testing::Not(::testing::Contains("a hung, silent")));
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
  EXPECT_THAT(how_, HasSubstr("for the disk for 3600000 ms, of which 10000 ms count"));
}

TEST_F(Monitor, AStarvedProcessStaysStarvedUntilItHasKeptUpForAWhile) {
  Watch(0, true);
  heartbeat_[0].work = Health::kStarved;
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a starved"));
  heartbeat_[0].work = Health::kWell;
  RunFor(Milliseconds(1800));
  EXPECT_THAT(Found(), IsEmpty());
  RunFor(Milliseconds(400));
  EXPECT_THAT(Found(), ElementsAre("a well"));
  EXPECT_EQ(how_, "it gets enough CPU again");
}

TEST_F(Monitor, AStoppedProcessHangsHoweverLongItWaited) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_ = {Process::kStopped, std::chrono::hours(1)};
  RunFor(Milliseconds(500));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
  EXPECT_THAT(how_, HasSubstr("stopped"));
}

TEST_F(Monitor, AProcessHeldByADebuggerIsNotReportedAsHung) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_.process = Process::kTraced;
  RunFor(std::chrono::minutes(10));
  EXPECT_THAT(Found(), ::testing::Not(::testing::Contains("a hung, silent")));
  EXPECT_THAT(how_, HasSubstr("debugger"));
  kernel_ = {};
  RunFor(std::chrono::seconds(1));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

TEST_F(Monitor, TheExitOfAProcessIsNotReported) {
  Watch(0, true);
  heartbeats_[0] = false;
  kernel_.process = Process::kExited;
  RunFor(std::chrono::minutes(1));
  EXPECT_THAT(Found(), ElementsAre("mark a", "probe a", "examine a"));
}

TEST_F(Monitor, AHungProcessThatSendsAgainIsWell) {
  Watch(0, true);
  heartbeats_[0] = false;
  RunFor(Milliseconds(500));
  Found();
  heartbeats_[0] = true;
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a well"));
}

TEST_F(Monitor, OnAnotherHostAnActuatorThatIsSilentAmongOthersIsCrashed) {
  Watch(0, false, "there");
  Watch(1, false, "there");
  heartbeats_[0] = false;
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(), ElementsAre("probe a", "a crashed, silent"));
}

TEST_F(Monitor, OnAnotherHostOneHeartbeatOfAnotherActuatorWithinHalfOfItsLimitIsEnough) {
  Watch(0, false, "there");
  Watch(1, false, "there");
  heartbeats_[0] = false;
  RunFor(Milliseconds(350));
  heartbeats_[1] = false;  // its last one came 200 ms before the limit of a, and its own is 500 ms
  RunFor(Milliseconds(160));
  EXPECT_THAT(Found(), ElementsAre("probe a", "a crashed, silent"));
}

TEST_F(Monitor, OnAnotherHostAllSilentArePartitioned) {
  Watch(0, false, "there");
  Watch(1, false, "there");
  Watch(2, true);
  heartbeats_[0] = heartbeats_[1] = false;
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(),
              ElementsAre("probe a", "probe b", "a partitioned, silent", "b partitioned, silent"));
}

TEST_F(Monitor, TheOnlyActuatorOfItsHostIsPartitioned) {
  Watch(0, false, "there");
  Watch(1, false, "elsewhere");
  heartbeats_[0] = false;
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(), ElementsAre("probe a", "a partitioned, silent"));
}

// Its process was frozen while the link was cut: it was never examined again.
TEST_F(Monitor, OfAHostThatIsHeardAgainAnActuatorThatStaysSilentIsCrashed) {
  Watch(0, false, "there");
  Watch(1, false, "there");
  heartbeats_[0] = heartbeats_[1] = false;
  RunFor(std::chrono::seconds(2));
  Found();
  heartbeats_[1] = true;
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(), ElementsAre("b well", "a crashed, silent"));
}

TEST_F(Monitor, WhatWasTheFirstToBeSilentOfItsHostIsPartitionedWithTheOthers) {
  Watch(0, false, "there");
  Watch(1, false, "there");
  heartbeats_[0] = false;
  RunFor(std::chrono::seconds(2));
  Found();
  heartbeats_[1] = false;
  RunFor(std::chrono::seconds(2));
  EXPECT_THAT(Found(), ElementsAre("probe b", "a partitioned, silent", "b partitioned, silent"));
}

TEST_F(Monitor, APartitionThatEndsIsReported) {
  Watch(0, false, "there");
  heartbeats_[0] = false;
  RunFor(std::chrono::seconds(2));
  Found();
  heartbeats_[0] = true;
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a well"));
}

TEST_F(Monitor, ExcusesItsOwnLatenessOnceAndGivesTimeToAnswer) {
  Watch(0, true);
  Watch(1, true);
  heartbeats_[0] = heartbeats_[1] = false;
  now_ += std::chrono::seconds(4);  // the controller itself was stopped
  Take(monitor_.TimePassed(now_));
  EXPECT_THAT(Found(), IsEmpty()) << "what was sent meanwhile may wait behind the timer";
  Take(monitor_.OnSample(1, kFirst, heartbeat_[1], now_ + Milliseconds(1)));
  RunFor(Milliseconds(30));
  EXPECT_THAT(Found(), ElementsAre("mark a", "probe a"));
  RunFor(Milliseconds(60));
  EXPECT_THAT(Found(), IsEmpty()) << "a probed process has time to answer";
  RunFor(Milliseconds(60));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

TEST_F(Monitor, ExcusesItsOwnLatenessAgainOnceASampleArrives) {
  Watch(0, true);
  heartbeats_[0] = false;
  for (int i = 0; i < 2; ++i) {
    now_ += std::chrono::seconds(4);
    Take(monitor_.TimePassed(now_));
    EXPECT_EQ(monitor_.NextDeadline(), now_ + Milliseconds(20));
    Take(monitor_.OnSample(0, kFirst, now_));
  }
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_F(Monitor, ExcusesALatenessThatIsMoreThanALoopsOwn) {
  for (const int late_ms : {20, 21}) {
    Watch(0, true);
    heartbeats_[0] = false;
    now_ = *monitor_.NextDeadline() + Milliseconds(late_ms);
    Take(monitor_.TimePassed(now_));
    const auto at_once = std::vector<std::string>{"mark a", "probe a"};
    EXPECT_EQ(Found(), late_ms == 20 ? at_once : std::vector<std::string>());
  }
}

TEST_F(Monitor, ReportsAProcessAsWellThatHasKeptUpForTwoSeconds) {
  Watch(0, true);
  Take(monitor_.OnSample(0, kFirst, Heartbeat{kHeartbeat, Health::kStarved, "", {}, {}}, now_));
  Take(monitor_.OnSample(0, kFirst, heartbeat_[0], now_ + Milliseconds(1999)));
  EXPECT_THAT(Found(), ElementsAre("a starved"));
  Take(monitor_.OnSample(0, kFirst, heartbeat_[0], now_ + Milliseconds(2000)));
  EXPECT_THAT(Found(), ElementsAre("a well"));
}

TEST_F(Monitor, ProbesAtHalfTheLimitAlsoBeforeTheFirstHeartbeat) {
  monitor_.Watch(0, kFirst, "here", true, now_);
  EXPECT_EQ(monitor_.NextDeadline(), now_ + Milliseconds(750));
}

TEST_F(Monitor, IgnoresASampleOfAnUnmonitoredActuatorAndMonitorsTheFirst) {
  Take(monitor_.OnSample(0, 0, Heartbeat{kHeartbeat, Health::kHung, "", {}, {}}, now_));
  Take(monitor_.OnSample(0, 0, now_));
  EXPECT_FALSE(monitor_.NextDeadline());
  EXPECT_THAT(Found(), IsEmpty());
  monitor_.Watch(0, 1, "here", true, now_);
  now_ += Milliseconds(10);
  Take(monitor_.OnSample(0, 1, now_));
  EXPECT_EQ(monitor_.NextDeadline(), now_ + Milliseconds(750));
  Take(monitor_.OnSample(0, 1, heartbeat_[0], now_));
  EXPECT_EQ(monitor_.NextDeadline(), now_ + Milliseconds(150));
}

TEST_F(Monitor, DoesNotExcuseItsOwnLatenessForEver) {
  Watch(0, true);
  heartbeats_[0] = false;
  RunFor(std::chrono::seconds(3), Milliseconds(50));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

TEST_F(Monitor, ReportsTheWorkThreadsVerdictAndItsState) {
  Watch(0, true);
  heartbeat_[0] = {kHeartbeat, Health::kHung, "Active", Milliseconds(512), {}};
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a hung"));
  EXPECT_EQ(how_, "no checkpoint in Active for 512 ms");
  answers_[0] = true;
  Take(monitor_.OnSample(0, kFirst, now_));
  EXPECT_THAT(Found(), IsEmpty()) << "an answer is no evidence of progress";
  heartbeat_[0] = {kHeartbeat, Health::kWell, "", {}, {}};
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a well"));
  EXPECT_EQ(how_, "its work thread makes progress again");
}

// It was reported as hung, and no more, for ever.
TEST_F(Monitor, ReportsThatAProcessWhoseWorkThreadHangsIsSilentSince) {
  Watch(0, true);
  heartbeat_[0] = {kHeartbeat, Health::kHung, "Active", Milliseconds(512), {}};
  RunFor(Milliseconds(200));
  EXPECT_THAT(Found(), ElementsAre("a hung"));
  heartbeats_[0] = false;
  kernel_.process = Process::kStopped;
  RunFor(std::chrono::seconds(1));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

// A busy computer would fill the journal.
TEST_F(Monitor, ReportsAProcessThatIsStarvedAgainOnlyOnce) {
  Watch(0, true);
  kernel_.waited = std::chrono::seconds(60);
  for (int times = 0; times < 3; ++times) {
    heartbeats_[0] = false;
    RunFor(Milliseconds(500));
    heartbeats_[0] = true;
    RunFor(Milliseconds(200));
  }
  const std::vector<std::string> found = Found();
  EXPECT_EQ(std::ranges::count(found, "a starved, silent"), 1);
}

TEST_F(Monitor, NeverEvaluatesAnActuatorOfAProtocolWithoutHeartbeats) {
  config_.actuators[0].protocol = Protocol::kCyberdog;
  monitor_.Watch(0, kFirst, "here", true, now_);
  RunFor(std::chrono::hours(1));
  Take(monitor_.OnSample(0, kFirst, now_));
  RunFor(std::chrono::hours(1));
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_F(Monitor, ForgetsAProcessThatHasExitedAndIgnoresItsLastSamples) {
  Watch(0, true);
  monitor_.Forget(0);
  heartbeats_[0] = false;
  Take(monitor_.OnSample(0, kFirst, heartbeat_[0], now_));
  RunFor(std::chrono::hours(1));
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_F(Monitor, StartsAgainWithASuccessor) {
  Watch(0, true);
  heartbeats_[0] = false;
  RunFor(Milliseconds(390));
  Found();
  monitor_.Watch(0, kFirst + 1, "here", true, now_);
  Take(monitor_.OnSample(0, kFirst, heartbeat_[0], now_));  // a late sample of the previous process
  RunFor(Milliseconds(390));
  EXPECT_THAT(Found(), ::testing::Not(::testing::Contains("a hung, silent")));
}

TEST_F(Monitor, EvaluatesAProcessThatIsSilentFromTheStart) {
  monitor_.Watch(0, kFirst, "here", true, now_);
  RunFor(std::chrono::seconds(3));
  EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
}

TEST_F(Monitor, NeverWaitsForEverBecauseOfAnInvalidPeriod) {
  for (const Duration period : {Duration(std::chrono::hours(1000)), Duration::max()}) {
    Watch(0, true);
    heartbeats_[0] = false;
    Take(monitor_.OnSample(0, kFirst, Heartbeat{period, Health::kWell, "", {}, {}}, now_));
    RunFor(std::chrono::seconds(59));
    EXPECT_THAT(Found(), ::testing::Not(::testing::Contains("a hung, silent")));
    RunFor(std::chrono::seconds(2));
    EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
  }
}

TEST_F(Monitor, DoesNotComputeWithAnInvalidPeriod) {
  for (const std::int64_t period : {INT64_MIN, std::int64_t{-1}, std::int64_t{1} << 62}) {
    Watch(0, true);
    heartbeats_[0] = false;
    Take(
        monitor_.OnSample(0, kFirst, Heartbeat{Duration(period), Health::kWell, "", {}, {}}, now_));
    RunFor(period < 0 ? Milliseconds(50) : Duration(std::chrono::seconds(61)));
    EXPECT_THAT(Found(), ::testing::Contains("a hung, silent"));
  }
}

TEST(HeartbeatPeriod, OfAControllerIsShortWhereHostsAreSeveral) {
  MachineConfig config = MachineOf(1);
  EXPECT_EQ(ControllerHeartbeatPeriod(config), Milliseconds(500));
  config.transport = TransportProfile::kLan;
  EXPECT_EQ(ControllerHeartbeatPeriod(config), Milliseconds(125));
}

TEST(HeartbeatPeriod, IsHalfOfTheCheckpointWithinBounds) {
  MachineConfig config = MachineOf(1);
  EXPECT_EQ(HeartbeatPeriod(config, 0), Milliseconds(500));
  config.actuators[0].checkpoint = Milliseconds(400);
  EXPECT_EQ(HeartbeatPeriod(config, 0), Milliseconds(200));
  config.actuators[0].checkpoint = Milliseconds(1);
  EXPECT_EQ(HeartbeatPeriod(config, 0), Milliseconds(10));
  config.actuators[0].checkpoint = std::chrono::hours(1);
  config.transport = TransportProfile::kLan;
  EXPECT_EQ(HeartbeatPeriod(config, 0), Milliseconds(125));
}

// The controller was stopped for 12 s, and the leases of the actuators had ended: it killed healthy
// ones before it had discovered them again.
TEST_F(Monitor, CountsNoSilenceUntilActuatorsCanBeDiscoveredAgainAfterABreakOfItsOwn) {
  for (const bool local : {true, false}) {
    Watch(0, local);
    RunFor(Milliseconds(500));
    found_.clear();
    heartbeats_[0] = false;
    now_ += std::chrono::seconds(12);
    next_heartbeat_ = now_;
    RunFor(Milliseconds(9900));
    EXPECT_THAT(found_, IsEmpty());
    RunFor(std::chrono::seconds(2));
    EXPECT_THAT(found_, ::testing::Not(IsEmpty())) << "it is silent since";
    heartbeats_[0] = true;
    RunFor(Milliseconds(500));
    monitor_.Forget(0);
  }
}

// A heartbeat that had arrived meanwhile was read first, and ended the time for the discovery. The
// other actuator was killed 1.5 s later.
TEST_F(Monitor, CountsNoSilenceAfterABreakOfItsOwnBehindWhichSamplesWaited) {
  for (const bool local : {true, false}) {
    Watch(0, local);
    Watch(1, local);
    RunFor(Milliseconds(500));
    found_.clear();
    now_ += std::chrono::seconds(12);
    HeartbeatAll();
    heartbeats_ = PerActuator<bool>(3);
    RunFor(Milliseconds(9900));
    EXPECT_THAT(found_, IsEmpty());
    RunFor(std::chrono::seconds(2));
    EXPECT_THAT(found_, ::testing::Not(IsEmpty())) << "they are silent since";
    for (const ActuatorIndex i : {ActuatorIndex(0), ActuatorIndex(1)}) monitor_.Forget(i);
  }
}

}  // namespace musher::testing::health_monitor_test
