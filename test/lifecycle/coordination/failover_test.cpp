// When a standby leads, and when a controller gives up the machine. See failover.hpp.

#include "musher/lifecycle/coordinator/failover.hpp"

#include <gmock/gmock.h>

#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "musher/test/lifecycle/coordination/harness.hpp"

namespace musher::testing::failover_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr Duration kFailover = Milliseconds(4000);
constexpr Duration kPeriod = Milliseconds(100);

MachineConfig ConfigOf(int actuators, const std::vector<std::string>& critical) {
  MachineConfig config = MachineOf(actuators);
  config.failover = kFailover;
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.critical = std::ranges::count(critical, actuator.name) != 0;
  }
  return config;
}

// A standby that looks each 100 ms.
class Standby : public ::testing::Test {
 protected:
  explicit Standby(MachineConfig config = ConfigOf(3, {"a", "b", "c"}))
      : config_(std::move(config)), decision_(config_, now_) {}

  // For so long; `lost`: which actuators are received, and whether they have lost their controller.
  std::string For(Duration time, bool controller, const std::map<std::string, bool>& lost) {
    std::string why;
    for (const Time end = now_ + time; now_ < end;) {
      now_ += kPeriod;
      if (controller) decision_.OnController(now_);
      for (const auto& [name, is_lost] : lost) {
        decision_.OnActuator(*config_.IndexOf(name), is_lost, now_);
      }
      why = decision_.WhyNot(now_);
      if (why.empty()) return why;
    }
    return why;
  }

  const MachineConfig config_;
  Time now_{std::chrono::hours(1)};
  StandbyDecision decision_;
};

TEST_F(Standby, LeadsOnceTheControllerIsGoneForTheWholeTimeAndMostOfTheVotersSaySo) {
  For(kFailover, true, {{"a", false}, {"b", false}, {"c", false}});
  const Time gone = now_;
  EXPECT_THAT(For(kFailover * 2, false, {{"b", true}, {"c", true}}), IsEmpty());
  EXPECT_GE(now_ - gone, kFailover);
  EXPECT_LE(now_ - gone, kFailover + 3 * kPeriod);
}

TEST_F(Standby, DoesNotLeadWhereItsOwnLinkToTheControllerIsCutAlone) {
  For(kFailover, true, {{"a", false}, {"b", false}, {"c", false}});
  EXPECT_THAT(For(kFailover * 10, false, {{"b", false}, {"c", false}}), HasSubstr("0 of 3"));
}

TEST_F(Standby, DoesNotLeadAMinority) {
  For(kFailover, true, {{"a", false}, {"b", false}, {"c", false}});
  EXPECT_THAT(For(kFailover * 10, false, {{"c", true}}), HasSubstr("1 of 3"));
}

TEST_F(Standby, BeginsItsWaitAgainWhereOneOfThemHasHeardTheControllerAgain) {
  For(kFailover, true, {{"b", false}, {"c", false}});
  EXPECT_THAT(For(kFailover - kPeriod, false, {{"b", true}, {"c", true}}), Not(IsEmpty()));
  For(kPeriod, false, {{"b", false}, {"c", true}});
  EXPECT_THAT(For(kFailover - kPeriod, false, {{"b", true}, {"c", true}}), Not(IsEmpty()));
  EXPECT_THAT(For(kPeriod * 3, false, {{"b", true}, {"c", true}}), IsEmpty());
}

// A laptop's lid, a process in a debugger: it has received nothing because it did not run.
TEST_F(Standby, BeginsItsWaitAgainAfterABreakOfItsOwn) {
  For(kFailover, true, {{"a", false}, {"b", false}, {"c", false}});
  now_ += std::chrono::minutes(1);
  EXPECT_THAT(decision_.WhyNot(now_), HasSubstr("until just now"));
  EXPECT_THAT(For(kFailover - kPeriod, false, {{"b", true}, {"c", true}}), Not(IsEmpty()));
}

TEST(Voters, AreTheCriticalActuatorsOfMushersProtocolElseAllOfIt) {
  MachineConfig config = ConfigOf(3, {"b"});
  EXPECT_THAT(Voters(config), ElementsAre(*config.IndexOf("b")));
  config.actuators[*config.IndexOf("b")].protocol = Protocol::kCyberdog;
  EXPECT_THAT(Voters(config), ElementsAre(*config.IndexOf("a"), *config.IndexOf("c")));
}

class Majority : public ::testing::Test {
 protected:
  Majority() {
    machine_.phase = Phase::kRunning;
    machine_.actuators = PerActuator<KnownActuator>(config_.actuators.size());
  }

  void Reach(const std::string& name, bool reached) {
    KnownActuator& known = machine_.actuators[*config_.IndexOf(name)];
    known.presence = reached ? Presence::kPresent : Presence::kLost;
    known.health = reached ? Health::kWell : Health::kPartitioned;
  }
  std::string For(Duration time) {
    std::string why;
    for (const Time end = now_ + time; now_ < end && why.empty();) {
      now_ += kPeriod;
      why = majority_.WhyRelease(config_, machine_, now_);
    }
    return why;
  }

  const MachineConfig config_ = ConfigOf(3, {"a", "b", "c"});
  Machine machine_;
  Time now_{std::chrono::hours(1)};
  MajorityReach majority_;
};

TEST_F(Majority, IsGivenUpForHalfOfTheTimeThatAStandbyWaits) {
  for (const char* name : {"a", "b", "c"}) Reach(name, true);
  EXPECT_THAT(For(kFailover), IsEmpty());
  Reach("b", false);
  EXPECT_THAT(For(kFailover * 3), IsEmpty()) << "two of three are a majority";
  Reach("c", false);
  const Time lost = now_;
  EXPECT_THAT(For(kFailover), HasSubstr("only 1 of 3"));
  EXPECT_LE(now_ - lost, kFailover / 2 + 2 * kPeriod);
}

TEST_F(Majority, ThatComesBackInTimeIsKept) {
  for (const char* name : {"a", "b", "c"}) Reach(name, true);
  For(kPeriod);
  for (int i = 0; i < 5; ++i) {
    for (const char* name : {"b", "c"}) Reach(name, false);
    EXPECT_THAT(For(kFailover / 2 - kPeriod), IsEmpty());
    Reach("b", true);
    EXPECT_THAT(For(kPeriod), IsEmpty());
  }
}

// The robot whose vision computer boots later than its brain.
TEST_F(Majority, ThatWasNeverReachedIsWaitedFor) {
  for (const char* name : {"b", "c"}) Reach(name, false);
  EXPECT_THAT(For(kFailover * 10), IsEmpty());
}

TEST_F(Majority, IsOfNoConcernToATearDownOrWithoutAStandby) {
  for (const char* name : {"a", "b", "c"}) Reach(name, true);
  For(kPeriod);
  for (const char* name : {"b", "c"}) Reach(name, false);
  machine_.phase = Phase::kStopping;
  EXPECT_THAT(For(kFailover * 2), IsEmpty());
  machine_.phase = Phase::kRunning;
  MachineConfig alone = config_;
  alone.failover.reset();
  for (int i = 0; i < 100; ++i) {
    EXPECT_THAT(majority_.WhyRelease(alone, machine_, now_ += kPeriod), IsEmpty());
  }
}

// Links per pair that go and come, processes that are frozen: whenever the standby leads, the other
// controller has given up the machine, has ended, or could not run until a moment before. That one
// learns what it has lost within the time for it, and its commands are refused by each that follows
// the standby.
TEST(Failover, NeverLeadsBesideAControllerThatRuns) {
  constexpr Duration kStep = Milliseconds(50);
  constexpr Duration kActuatorLoses = Milliseconds(375);      // three heartbeats of its controller
  constexpr Duration kControllerNotices = Milliseconds(400);  // three of an actuator
  int led = 0;
  int given_up = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto one_in = [&](unsigned n) { return random() % n == 0; };
    const int count = 1 + static_cast<int>(random() % 4);
    const MachineConfig config = ConfigOf(count, {});
    Machine machine;
    machine.phase = Phase::kRunning;
    machine.actuators = PerActuator<KnownActuator>(config.actuators.size());
    Time now{std::chrono::hours(1)};
    StandbyDecision standby(config, now);
    MajorityReach majority;
    struct Links {
      bool to_controller = true;
      bool to_standby = true;
      Time heard{};     // the controller, by the actuator
      Time received{};  // the actuator, by the controller
    };
    std::vector<Links> links(config.actuators.size(), Links{true, true, now, now});
    bool between = true;
    bool dead = false;
    Time frozen_until{};
    Time standby_frozen_until{};
    bool leads = true;
    for (int i = 0; i < 1200; ++i) {
      now += kStep;
      for (Links& one : links) {
        if (one_in(60)) one.to_controller = !one.to_controller;
        if (one_in(60)) one.to_standby = !one.to_standby;
      }
      if (one_in(60)) between = !between;
      if (one_in(400)) dead = true;
      if (one_in(200)) frozen_until = now + Milliseconds(static_cast<int>(random() % 8000));
      if (one_in(200)) standby_frozen_until = now + Milliseconds(static_cast<int>(random() % 8000));
      const bool runs = !dead && leads && now >= frozen_until;
      for (Links& one : links) {
        if (runs && one.to_controller) one.heard = one.received = now;
      }
      for (const ActuatorIndex a : config.actuators.Indices()) {
        const bool away = now - links[a.value()].received > kControllerNotices;
        machine.actuators[a].presence = away ? Presence::kLost : Presence::kPresent;
        machine.actuators[a].health = away ? Health::kPartitioned : Health::kWell;
      }
      if (runs && !majority.WhyRelease(config, machine, now).empty()) {
        leads = false;
        ++given_up;
      }
      if (now < standby_frozen_until) continue;
      if (runs && leads && between) standby.OnController(now);
      for (const ActuatorIndex a : config.actuators.Indices()) {
        const Links& one = links[a.value()];
        if (one.to_standby) standby.OnActuator(a, now - one.heard > kActuatorLoses, now);
      }
      if (!standby.WhyNot(now).empty()) continue;
      const Time learns = frozen_until + kControllerNotices + kFailover / 2 + 2 * kStep;
      const bool was_frozen = frozen_until != Time{} && now < learns;
      ASSERT_FALSE(runs && leads && !was_frozen) << "after " << i * 50 << " ms";
      ++led;
      break;
    }
  }
  EXPECT_GT(led, 100) << "it does lead where it may";
  EXPECT_GT(given_up, 50);
}

}  // namespace musher::testing::failover_test
