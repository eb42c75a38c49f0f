#pragma once
// A controller alone: the test gives all its events and checks all its actions.

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/test/lifecycle/coordination/records.hpp"

namespace musher::testing {

class OneController : public ::testing::Test {
 protected:
  static constexpr Incarnation kFirst = 70;  // the incarnation of actuator 0; 71 of the next …

  // The disk takes no time. The processes that run at the end are `processes_`, unless the search
  // for them is not answered.
  void Do(const Event& event) {
    std::vector<Event> saved;
    for (Action& action : Step(config_, machine_, event, now_)) {
      if (const auto* record = std::get_if<action::Record>(&action)) records_.push_back(*record);
      if (const auto* intent = std::get_if<action::SaveStopIntent>(&action)) {
        saved.emplace_back(event::SaveEnded{Stored::kStopIntent, intent->save, true, {}});
      }
      if (std::holds_alternative<action::FindProcesses>(action) && answers_search_) {
        saved.emplace_back(event::ProcessesFound{processes_});
      }
      actions_.push_back(std::move(action));
    }
    for (const Event& end : saved) Do(end);
  }
  void Begin() {
    machine_ = MakeMachine(config_);
    Do(event::Begin{false, 0, PerActuator<bool>(config_.actuators.size()), "here"});
  }
  void Pass(Duration duration) {
    const Time end = now_ + duration;
    for (auto next = Next(); next && *next <= end; next = Next()) {
      now_ = std::max(now_, *next);
      Do(event::TimePassed{});
    }
    now_ = end;
  }
  std::optional<Time> Next() const { return NextDeadline(config_, machine_); }

  // The report of actuator i: set up, on this host, free.
  ActuatorReport Report(ActuatorIndex i, const State& state = kSetUp) {
    ActuatorReport report;
    report.state = state;
    report.incarnation = kFirst + i.value();
    report.pid = static_cast<std::int32_t>(700 + i.value());
    report.host = "here";
    report.epoch = Of(i).presence == Presence::kPresent ? machine_.epoch : 0;
    report.stamp = now_;
    return report;
  }
  void Say(ActuatorIndex i, const ActuatorReport& report) { Do(event::StatusSeen{i, report}); }
  // It publishes its status and answers TakeControl().
  void Come(ActuatorIndex i, const State& state = kSetUp) {
    Say(i, Report(i, state));
    ActuatorReport report = Report(i, state);
    report.epoch = machine_.epoch;
    report.number = Of(i).report.number;
    Do(event::Replied{i, report.number, true, Verdict::kDone, kCodeOk, "", report});
    EXPECT_EQ(Of(i).presence, Presence::kPresent);
  }
  // It has executed its command.
  void Obey(ActuatorIndex i) {
    const PendingCommand command = Of(i).command.value();
    ActuatorReport report = Report(i, command.target);
    report.incarnation = Of(i).report.incarnation;
    report.number = report.outcome_number = command.number;
    Do(event::Replied{i, command.number, false, Verdict::kDone, kCodeOk, "", report});
  }
  // All actuators execute their commands until none is sent.
  void ObeyAll() {
    for (int rounds = 0; rounds < 10; ++rounds) {
      for (const ActuatorIndex i : config_.actuators.Indices()) {
        if (Of(i).command) Obey(i);
      }
    }
    for (const KnownActuator& known : machine_.actuators) EXPECT_FALSE(known.command);
  }
  // All actuators start and execute their commands until none is sent.
  void StartUp() {
    Begin();
    for (const ActuatorIndex i : config_.actuators.Indices()) Come(i);
    ObeyAll();
    EXPECT_EQ(machine_.state, kActive);
    Forget();
  }

  template <class A>
  std::vector<A> Did() const {
    std::vector<A> some;
    for (const Action& action : actions_) {
      if (const auto* one = std::get_if<A>(&action)) some.push_back(*one);
    }
    return some;
  }
  // `what`: an EventName or a RecordText.
  template <class What>
  action::Record RecordWith(const What& what) const {
    return testing::RecordWith(records_, what);
  }
  template <class What>
  bool IsRecorded(const What& what) const {
    return testing::IsRecorded(records_, what);
  }
  void Forget() {
    actions_.clear();
    records_.clear();
  }
  KnownActuator& Of(ActuatorIndex i) { return machine_.actuators[i]; }

  MachineConfig config_ = MachineOf(2);
  Machine machine_;
  Time now_ = Time(std::chrono::hours(1));
  std::vector<Action> actions_;
  PerActuator<std::int32_t> processes_;
  bool answers_search_ = true;
  Records records_;
};

}  // namespace musher::testing
