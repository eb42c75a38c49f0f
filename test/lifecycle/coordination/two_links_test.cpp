// Two controllers of one machine, with links per pair of hosts: a takeover by a person lasts, also
// where the replaced controller receives nothing from the new one.

#include <gmock/gmock.h>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/lifecycle/coordination/records.hpp"
#include "musher/test/support/nightly.hpp"

namespace musher::testing::two_links_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Duration kLatency = Milliseconds(1);
constexpr Duration kCallback = Milliseconds(10);
constexpr Duration kHeartbeat = Milliseconds(100);

class Robot;

// One of the controllers, with its disk.
class Side : public FakeRobot {
 public:
  Side(Robot& robot, const MachineConfig& config, std::size_t which);

  Machine& machine() { return controller_.machine; }
  Disk& disk() { return controller_.disk; }
  Sender sender() const { return controller_.sender(); }
  void SetTime(Time now) { controller_.now = now; }
  bool leads() const {
    const Phase phase = controller_.machine.phase;
    return phase != Phase::kIdle && phase != Phase::kFenced;
  }
  // A new process of it.
  void Start(bool restarted, bool at_boot);

  Records records;
  std::string fenced;  // why
  std::vector<Epoch> epochs;

 private:
  FakeActuator& Actuator(ActuatorIndex i) override;
  void StepController(const Event& event) override;
  void StepActuator(ActuatorIndex i, const ActuatorEvent& event) override;
  RequestToken TokenOf(Sender sender, CommandNumber number, bool query) override;
  void Send(const Message& message) override;
  void Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) override;
  void Do(const Action& action) override;

  FakeController own_controller_;
  Robot& robot_;
  const std::size_t which_;
};

// Hosts A and B with a controller each, actuators "a", "b" and "c" on A, B and a host C.
class Robot {
 public:
  Robot() {
    for (ActuatorConfig& actuator : config_.actuators) {
      actuator.controller_lost = std::chrono::seconds(1);
      actuator.on_controller_lost = kProtected;
    }
    for (std::size_t which = 0; which < 2; ++which) {
      sides_[which] = std::make_unique<Side>(*this, config_, which);
    }
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      FakeActuator& actuator = actuators_[i];
      actuator.Launch(static_cast<std::int32_t>(1000 + i.value()));
      actuator.core.report.host = i == 0 ? "here" : "host of " + config_.actuators[i].name;
      StepActuator(i, actuator_event::Started{});
    }
    Heartbeat();
  }

  Side& side(std::size_t which) { return *sides_[which]; }
  State StateOf(const std::string& name) const {
    return actuators_[*config_.IndexOf(name)].core.report.state;
  }
  Epoch EpochOf(const std::string& name) const {
    return actuators_[*config_.IndexOf(name)].core.report.epoch;
  }
  // The link between A and B.
  void Cut(bool cut) {
    cut_ = cut;
    if (cut) {
      Lose(0, 1);
      Lose(1, 0);
    } else {
      for (const auto& side : sides_) RepeatStatuses(*side);
    }
  }
  // The link between a controller and C, in both directions.
  void CutC(std::size_t which, bool cut) {
    c_cut_[which] = cut;
    if (cut) Lose(which, 2);
    if (!cut && sides_[which]->leads()) RepeatStatuses(*sides_[which]);
  }
  void Start(std::size_t which, bool restarted = false, bool at_boot = false) {
    sides_[which]->Start(restarted, at_boot);
    RepeatStatuses(*sides_[which]);
  }
  void RunFor(Duration duration) {
    const Time end = now_ + duration;
    for (;;) {
      Time next = end;
      if (!later_.empty()) next = std::min(next, later_.begin()->first);
      for (const auto& side : sides_) {
        if (const auto due = NextDeadline(config_, side->machine())) next = std::min(next, *due);
      }
      SetTime(std::max(now_, next));
      if (!later_.empty() && later_.begin()->first <= now_) {
        const auto what = std::move(later_.begin()->second);
        later_.erase(later_.begin());
        what();
        continue;
      }
      bool due = false;
      for (const auto& side : sides_) {
        const auto deadline = NextDeadline(config_, side->machine());
        if (!deadline || *deadline > now_) continue;
        side->Feed(event::TimePassed{});
        due = true;
      }
      if (!due && now_ >= end) return;
    }
  }
  // The link to C is bad: a controller loses "c" for a moment, then receives its status again.
  void LoseForAMoment(std::size_t which) {
    Lose(which, 2);
    RunFor(Milliseconds(500));
    if (sides_[which]->leads()) RepeatStatuses(*sides_[which]);
    RunFor(std::chrono::seconds(2));
  }
  // A controller is killed; its supervisor starts it again.
  void Restart(std::size_t which) {
    if (sides_[which]->leads()) Start(which, true);
  }
  void LoseC(std::size_t which) {
    Lose(which, 2);
    After(Milliseconds(300), [this, which] { RepeatStatuses(*sides_[which]); });
  }
  // How long the next message to or from "c" takes; none: it is lost.
  std::function<std::optional<Duration>()> latency_of_c = [] { return kLatency; };
  std::function<void()> after_step_of_c = [] {};
  Sender ControllerOfC() const { return actuators_[2].core.controller; }
  std::vector<std::string> log;  // the callbacks that were begun: "c:Active"

 private:
  friend class Side;

  bool Reaches(std::size_t which, ActuatorIndex i) const {
    if (i.value() == 2) return !c_cut_[which];
    return !cut_ || i.value() == which;
  }
  void SetTime(Time now) {
    now_ = now;
    for (const auto& side : sides_) side->SetTime(now);
  }
  void After(Duration delay, std::function<void()> what) {
    later_.emplace(now_ + delay, std::move(what));
  }
  void Transmit(ActuatorIndex i, std::function<void()> what) {
    const std::optional<Duration> latency = i == 2 ? latency_of_c() : kLatency;
    if (latency) After(*latency, std::move(what));
  }
  // The health monitor of that controller receives no heartbeat any more.
  void Lose(std::size_t which, ActuatorIndex i) {
    if (!sides_[which]->leads()) return;
    sides_[which]->Feed(event::HealthChanged{i, actuators_[i].core.report.incarnation,
                                             Health::kPartitioned, true, "no heartbeat"});
  }
  void RepeatStatuses(Side& side) {
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      if (Reaches(&side == sides_[0].get() ? 0 : 1, i)) {
        After(kLatency, [this, &side, i] { side.Feed(event::StatusSeen{i, side.Report(i)}); });
      }
    }
  }
  void Heartbeat() {
    for (std::size_t which = 0; which < 2; ++which) {
      const Side& side = *sides_[which];
      const Epoch epoch = sides_[which]->machine().epoch;
      if (!side.leads()) continue;
      for (const ActuatorIndex i : config_.actuators.Indices()) {
        if (!Reaches(which, i)) continue;
        StepActuator(i, actuator_event::ControllerHeartbeatReceived{side.sender(), epoch});
      }
      Side& other = *sides_[1 - which];
      if (!cut_ && other.leads()) other.Feed(event::RivalSeen{epoch, "the other", which == 0});
    }
    for (const ActuatorIndex i : config_.actuators.Indices()) {
      StepActuator(i, actuator_event::TimePassed{});
    }
    After(kHeartbeat, [this] { Heartbeat(); });
  }
  void StepActuator(ActuatorIndex i, const ActuatorEvent& event) {
    for (const ActuatorAction& action : Step(config_, i, actuators_[i].core, event, now_)) {
      Do(i, action);
    }
    if (i == 2) after_step_of_c();
  }
  void Do(ActuatorIndex i, const ActuatorAction& action) {
    if (const auto* run = std::get_if<actuator_action::RunCallback>(&action)) {
      log.push_back(config_.actuators[i].name + ":" + run->target);
      After(kCallback, [this, i] { StepActuator(i, actuator_event::CallbackEnded{}); });
    } else if (const auto* answer = std::get_if<actuator_action::Answer>(&action)) {
      const auto& [which, number, query] = requests_[answer->token.value()];
      if (!Reaches(which, i)) return;
      const event::Replied reply{i,
                                 number,
                                 query,
                                 answer->verdict,
                                 answer->code,
                                 answer->message,
                                 sides_[which]->Report(i)};
      Transmit(i, [this, reply, which = which] { sides_[which]->Feed(reply); });
    } else if (std::holds_alternative<actuator_action::BecomeVisible>(action)) {
      actuators_[i].visible = true;
    } else if (std::holds_alternative<actuator_action::PublishStatus>(action)) {
      for (std::size_t which = 0; which < 2; ++which) {
        Side& side = *sides_[which];
        if (!side.leads() || !Reaches(which, i)) continue;
        const event::StatusSeen seen{i, side.Report(i)};
        Transmit(i, [&side, seen] { side.Feed(seen); });
      }
    }
  }

  const MachineConfig own_config_ = MachineOf(3);
  MachineConfig config_ = own_config_;
  Time now_ = Time(std::chrono::hours(1));
  bool cut_ = false;
  std::array<bool, 2> c_cut_{};
  PerActuator<FakeActuator> actuators_ = PerActuator<FakeActuator>(3);
  std::array<std::unique_ptr<Side>, 2> sides_;
  std::multimap<Time, std::function<void()>> later_;
  std::vector<std::tuple<std::size_t, CommandNumber, bool>> requests_;
};

Side::Side(Robot& robot, const MachineConfig& config, std::size_t which)
    : FakeRobot(config, own_controller_), robot_(robot), which_(which) {
  own_controller_.machine = MakeMachine(config);
  own_controller_.generation = which * 100;
}

void Side::Start(bool restarted, bool at_boot) {
  ++controller_.generation;
  controller_.machine = MakeMachine(config_);
  fenced.clear();
  epochs.clear();
  BeginController(false, restarted, restarted || at_boot, at_boot);
}

FakeActuator& Side::Actuator(ActuatorIndex i) {
  return robot_.actuators_[i];
}

void Side::StepController(const Event& event) {
  for (const Action& action : Step(config_, controller_.machine, event, controller_.now)) {
    Apply(action);
  }
  CheckInvariants(config_, controller_.machine);
  const Epoch epoch = controller_.machine.epoch;
  if (epochs.empty() || epochs.back() != epoch) epochs.push_back(epoch);
}

void Side::StepActuator(ActuatorIndex i, const ActuatorEvent& event) {
  robot_.StepActuator(i, event);
}

RequestToken Side::TokenOf(Sender, CommandNumber number, bool query) {
  robot_.requests_.emplace_back(which_, number, query);
  return RequestToken(robot_.requests_.size() - 1);
}

void Side::Send(const Message& message) {
  robot_.Transmit(message.to, [this, message] {
    if (robot_.Reaches(which_, message.to)) Deliver(message);
  });
}

void Side::Save(Stored what, SaveNumber save, std::function<void(Disk&)> write) {
  write(controller_.disk);
  Feed(event::SaveEnded{what, save, true, ""});
}

void Side::Do(const Action& action) {
  if (const auto* end = std::get_if<action::Fenced>(&action)) fenced = end->message;
  if (const auto* record = std::get_if<action::Record>(&action)) records.push_back(*record);
}

class TwoLinks : public ::testing::Test {
 protected:
  // A leads a, b and c in Active; then the link between A and B is cut.
  void SetUp() override {
    first().disk().epoch = 4;
    robot_.Start(0);
    robot_.RunFor(std::chrono::seconds(10));
    ASSERT_EQ(first().machine().state, "Active");
    robot_.Cut(true);
    robot_.RunFor(std::chrono::seconds(5));
  }
  // A person takes over on B: that controller receives b and c, not A.
  void TakeOverOnB() {
    robot_.Start(1);
    robot_.RunFor(std::chrono::seconds(25));
  }
  Side& first() { return robot_.side(0); }
  Side& second() { return robot_.side(1); }

  Robot robot_;
};

TEST_F(TwoLinks, AControllerWhoseActuatorFollowsAHigherEpochHasBeenReplaced) {
  TakeOverOnB();
  EXPECT_EQ(first().machine().phase, Phase::kFenced);
  EXPECT_THAT(first().fenced, HasSubstr("which c follows, leads this machine with epoch 6"));
  EXPECT_EQ(first().epochs, (std::vector<Epoch>{5})) << "a running controller never raises";
  EXPECT_EQ(second().epochs, (std::vector<Epoch>{1, 6})) << "once, at its start";
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
  EXPECT_TRUE(first().disk().stops.led_elsewhere) << "the stops of B are on its disk alone";
}

TEST_F(TwoLinks, NoControllerOutbidsTheOtherWhenMessagesAreLost) {
  robot_.Start(1);
  for (int round = 0; round < 10; ++round) {
    robot_.LoseForAMoment(1);
    robot_.LoseForAMoment(0);
  }
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
  EXPECT_EQ(first().epochs.size() + second().epochs.size(), 3U) << "5; 1 and 6";
  EXPECT_TRUE(second().leads());
}

// Two of all faults in the first seconds of a takeover: a message to or from "c" is lost or late, a
// controller loses "c" for a moment, or is killed and restarted by its supervisor; one of the three
// links is cut for a second, or heals.
struct Fault {
  enum Kind { kLost, kLate, kLoses, kKilled, kCut, kHeals } kind = kLost;
  std::size_t at = 0;     // the number of the message, or of the period of time
  std::size_t which = 0;  // controller
};
constexpr std::size_t kMessages = 16;
constexpr std::size_t kPeriods = 8;
constexpr Duration kPeriod = Milliseconds(250);
constexpr std::size_t kCutPeriods = 4;

std::vector<Fault> AllFaults() {
  std::vector<Fault> all;
  for (std::size_t at = 0; at < kMessages; ++at) {
    all.push_back({Fault::kLost, at});
    all.push_back({Fault::kLate, at});
  }
  for (std::size_t at = 0; at < kPeriods; ++at) {
    for (const std::size_t which : {0, 1}) {
      all.push_back({Fault::kLoses, at, which});
      all.push_back({Fault::kKilled, at, which});
      if (at % 2 == 0) all.push_back({Fault::kCut, at, which});
    }
    if (at % 2 == 0) all.push_back({Fault::kHeals, at, 0});
  }
  return all;
}

// What is wrong after them; empty: nothing.
std::string TakeOverUnder(const std::array<Fault, 2>& faults) {
  Robot robot;
  robot.side(0).disk().epoch = 4;
  robot.Start(0);
  robot.RunFor(std::chrono::seconds(1));
  robot.Cut(true);
  std::string wrong;
  std::size_t messages = 0;
  robot.latency_of_c = [&]() -> std::optional<Duration> {
    std::optional<Duration> latency = kLatency;
    for (const Fault& fault : faults) {
      if (fault.kind > Fault::kLate || fault.at != messages) continue;
      latency = fault.kind == Fault::kLost ? std::nullopt : std::optional(Milliseconds(700));
    }
    ++messages;
    return latency;
  };
  bool followed_second = false;
  robot.after_step_of_c = [&] {
    if (robot.ControllerOfC() == robot.side(1).sender()) followed_second = true;
    if (followed_second && robot.ControllerOfC() == robot.side(0).sender()) {
      wrong = "c returns to the controller that was replaced";
    }
  };
  robot.Start(1);
  for (std::size_t period = 0; period < kPeriods + 24; ++period) {
    for (const Fault& fault : faults) {
      if (fault.kind == Fault::kCut && fault.at + kCutPeriods == period) {
        robot.CutC(fault.which, false);
      }
      if (fault.at != period) continue;
      if (fault.kind == Fault::kCut) robot.CutC(fault.which, true);
      if (fault.kind == Fault::kHeals) robot.Cut(false);
      if (fault.kind == Fault::kLoses) robot.LoseC(fault.which);
      if (fault.kind == Fault::kKilled) robot.Restart(fault.which);
    }
    robot.RunFor(kPeriod);
  }
  for (const std::size_t which : {0, 1}) {
    if (robot.side(which).epochs.size() > 2) wrong = "an epoch is raised twice";
  }
  if (robot.side(0).leads() && robot.side(1).leads() && followed_second) {
    wrong = "two controllers lead, although one has been replaced";
  }
  const bool second_leads = robot.side(1).leads() && followed_second;
  robot.Cut(false);
  robot.RunFor(std::chrono::seconds(3));
  if (second_leads && !robot.side(1).leads()) wrong = "healing the link undoes the takeover";
  return wrong;
}

TEST(TwoLinksUnderFaults, NoTwoFaultsUndoATakeover) {
  const std::vector<Fault> all = AllFaults();
  const std::size_t each = Nightly() ? 1 : 4;  // in the gate every fourth pair
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i; j < all.size(); j += each) {
      const std::string wrong = TakeOverUnder({all[i], all[j]});
      ASSERT_EQ(wrong, "") << "faults " << all[i].kind << " of " << all[i].which << " at "
                           << all[i].at << " and " << all[j].kind << " of " << all[j].which
                           << " at " << all[j].at;
    }
  }
}

TEST_F(TwoLinks, AnActuatorChangesItsStateByTheCommandOfTheNewControllerOnly) {
  TakeOverOnB();
  second().Feed(event::SetStateRequested{1, State("Protected"), {}});
  robot_.RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot_.StateOf("c"), "Protected");
  EXPECT_EQ(robot_.StateOf("a"), "Protected") << "its controller is lost";
  robot_.log.clear();
  robot_.RunFor(std::chrono::minutes(1));
  EXPECT_THAT(robot_.log, IsEmpty());
}

TEST_F(TwoLinks, ATakeoverLastsAfterTheLinkIsHealed) {
  TakeOverOnB();
  second().Feed(event::SetStateRequested{1, State("Protected"), {}});
  robot_.RunFor(std::chrono::seconds(5));
  robot_.log.clear();
  robot_.Cut(false);
  robot_.RunFor(std::chrono::minutes(1));
  EXPECT_TRUE(second().leads());
  EXPECT_FALSE(first().leads());
  EXPECT_EQ(robot_.EpochOf("a"), second().machine().epoch);
  EXPECT_EQ(second().machine().state, "Protected");
  for (const char* name : {"a", "b", "c"}) EXPECT_EQ(robot_.StateOf(name), "Protected") << name;
}

TEST_F(TwoLinks, ASupervisorDoesNotUndoATakeover) {
  TakeOverOnB();
  robot_.Start(0, /*restarted=*/true);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_EQ(first().machine().phase, Phase::kFenced);
  EXPECT_TRUE(second().leads());
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
}

// Its host was rebooted, and the init system started it.
TEST_F(TwoLinks, ABootDoesNotUndoATakeover) {
  TakeOverOnB();
  robot_.Start(0, /*restarted=*/false, /*at_boot=*/true);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_EQ(first().machine().phase, Phase::kFenced);
  EXPECT_TRUE(second().leads());
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
}

// Its disk was full: it was killed, started again without its last epoch, and has not saved one.
TEST_F(TwoLinks, AnEpochThatAnActuatorOfTheOwnHostHasIsFromAPredecessor) {
  first().disk().epoch = 0;
  robot_.Start(0, /*restarted=*/true);
  robot_.RunFor(Milliseconds(100));
  for (const std::size_t which : {0, 2}) {  // the last queries of the predecessor arrive
    const ActuatorIndex i(which);
    ActuatorReport report = first().Report(i);
    report.epoch = 6;
    first().Feed(event::StatusSeen{i, report});
  }
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_TRUE(first().leads()) << first().fenced;
  EXPECT_EQ(first().epochs.size(), 2U) << "raised once, above what the actuators show then";
}

// Its epoch was lost as well, and the takeover is not complete yet when it begins.
TEST_F(TwoLinks, ASupervisorDoesNotUndoATakeoverThatItSeesBecomeComplete) {
  robot_.Start(1);
  robot_.RunFor(Milliseconds(300));
  ASSERT_EQ(robot_.EpochOf("c"), Epoch(5));
  first().disk().epoch = 0;
  robot_.Start(0, /*restarted=*/true);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_EQ(first().machine().phase, Phase::kFenced);
  EXPECT_EQ(first().epochs, (std::vector<Epoch>{1}));
  EXPECT_TRUE(second().leads());
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
}

TEST_F(TwoLinks, APersonWhoStartsWithoutADiskDuringATakeoverHasTheNewerWord) {
  robot_.Start(1);
  robot_.RunFor(Milliseconds(300));
  first().disk().epoch = 0;
  robot_.Start(0);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_TRUE(first().leads());
  EXPECT_FALSE(second().leads());
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(7));
}

TEST_F(TwoLinks, APersonMayTakeTheMachineBack) {
  TakeOverOnB();
  robot_.Start(0);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_TRUE(first().leads());
  EXPECT_FALSE(second().leads());
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(7));
  EXPECT_EQ(robot_.EpochOf("a"), Epoch(7));
}

// Its epoch was not saved: the actuators of its own host have it, too.
TEST_F(TwoLinks, ASupervisorRestartsAControllerWhoseDiskIsBehind) {
  robot_.Cut(false);
  first().disk().epoch = 3;
  robot_.Start(0, /*restarted=*/true);
  robot_.RunFor(std::chrono::seconds(25));
  EXPECT_TRUE(first().leads());
  EXPECT_EQ(first().machine().epoch, Epoch(6));
  EXPECT_EQ(robot_.EpochOf("c"), Epoch(6));
}

// It meets an actuator for the first time, which the other controller has started to lead.
TEST_F(TwoLinks, ARunningControllerLeavesANewActuatorOfAnotherControllerAlone) {
  TakeOverOnB();
  robot_.Start(0);
  robot_.RunFor(std::chrono::seconds(25));
  ASSERT_EQ(first().machine().epoch, Epoch(7));
  ActuatorReport report = first().Report(1);
  report.incarnation += 5000;
  report.epoch = 9;
  report.host = "the next boot of B";
  first().Feed(event::StatusSeen{1, report});
  robot_.RunFor(std::chrono::seconds(10));
  EXPECT_TRUE(first().leads());
  EXPECT_EQ(first().machine().epoch, Epoch(7));
  EXPECT_THAT(first().machine().actuators[1].fault, Is(texts::ControlledByAnother(9)));
}

}  // namespace musher::testing::two_links_test
