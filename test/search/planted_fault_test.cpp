// The search finds faults: each test plants one in the rules and expects its scenario.

#include <gmock/gmock.h>

#include <algorithm>
#include <utility>

#include "musher/search/explorer.hpp"
#include "musher/test/search/scenarios.hpp"

namespace musher::search::planted_fault_test {

using ::testing::Contains;
using ::testing::HasSubstr;

class PlantedFault : public ::testing::Test {
 protected:
  void Search(Rules rules, const State& from, const State& to, int faults,
              const Scenario& machine = ScenarioNamed("Parallel")) {
    const Model correct(machine.config, to);
    Model model(correct.config, to, std::move(rules));
    model.releases = releases_;
    model.other_machine = other_machine_;
    model.faults = faults_;
    World root = WorldIn(correct, from);
    root.faults = root.faults_left = faults;
    searched_ = SearchAll(model, root);
    if (searched_.fault) scenario_ = ScenarioOf(model, root, searched_.fault->path);
  }

  bool releases_ = true;
  bool other_machine_ = false;
  std::uint64_t faults_ = kAllFaults;
  Searched searched_;
  std::string scenario_;
};

// Changes the event before the controller sees it.
template <typename E, typename Change>
Rules WithEvent(Change change) {
  Rules rules;
  rules.controller = [change](const auto& config, auto& machine, const Event& event, Time now) {
    Event changed = event;
    if (auto* one = std::get_if<E>(&changed)) change(*one, machine);
    return Step(config, machine, changed, now);
  };
  return rules;
}

TEST_F(PlantedFault, FindsAFailureThatIsDropped) {
  Search(WithEvent<event::Replied>([](event::Replied& reply, const Machine& machine) {
           if (reply.verdict != Verdict::kFailed) return;
           reply.verdict = Verdict::kDone;
           reply.report.state = machine.current->target;
         }),
         "LowPower", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("done is reported while")));
  EXPECT_THAT(scenario_, HasSubstr("FAULT: "));
  EXPECT_THAT(scenario_, HasSubstr("callback of Active fails"));
  EXPECT_THAT(scenario_, HasSubstr("VIOLATION: done is reported while"));
}

TEST_F(PlantedFault, FindsACrashThatIsNotDetected) {
  Search(WithEvent<event::ProcessEnded>(
             [](event::ProcessEnded& ended, const Machine&) { ended.pid = 0; }),
         "Active", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("has exited in Active")));
}

TEST_F(PlantedFault, FindsAMissingReplyWithoutAnyFault) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    std::erase_if(
        actions, [](const Action& a) { return std::holds_alternative<action::AnswerSetState>(a); });
    return actions;
  };
  Search(rules, "Active", "LowPower", 0);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("there is no reply to the request for LowPower")));
}

TEST_F(PlantedFault, FindsADuplicateReply) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    const auto reply = std::find_if(actions.begin(), actions.end(), [](const Action& a) {
      return std::holds_alternative<action::AnswerSetState>(a);
    });
    if (reply != actions.end()) actions.push_back(Action(*reply));
    return actions;
  };
  Search(rules, "Active", "LowPower", 0);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains("a request gets two replies"));
}

// An actuator that stores no numbers begins a command that arrives twice, or after its query.
TEST_F(PlantedFault, FindsAnOutdatedCommandThatBegins) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    if (std::holds_alternative<actuator_event::SwitchArrived>(event)) {
      core.report.number = core.report.outcome_number = 0;
    }
    return Step(config, i, core, event, now);
  };
  Search(rules, "Active", "LowPower", 2);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("which is outdated")));
  EXPECT_THAT(scenario_, HasSubstr("a delayed message arrives"));
}

TEST_F(PlantedFault, FindsAnActuatorThatLosesTheEmergencyStop) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    if (!std::holds_alternative<actuator_event::SwitchArrived>(event)) {
      return Step(config, i, core, event, now);
    }
    const StopId stop = std::exchange(core.report.emergency_stop, StopId());
    auto actions = Step(config, i, core, event, now);
    core.report.emergency_stop = stop;
    return actions;
  };
  Search(rules, "LowPower", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("while an emergency stop is latched")));
  EXPECT_THAT(scenario_, HasSubstr("CROSSED by an emergency stop"));
}

// The callback that was running when the stop arrived counts as if there were no stop.
TEST_F(PlantedFault, FindsACallbackThatUndoesAnEmergencyStop) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    core.stopped_meanwhile = false;
    return Step(config, i, core, event, now);
  };
  Search(rules, "LowPower", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("is energised during an emergency stop")));
  EXPECT_THAT(scenario_, HasSubstr("CROSSED by an emergency stop"));
}

// The controller completes a switch on the level that the stop has crossed.
TEST_F(PlantedFault, FindsASwitchOnTheLevelThatAnEmergencyStopDoesNotEnd) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    if (machine.current) machine.current->stopped = false;
    return actions;
  };
  Search(rules, "Active", "Dancing", 1, EqualRanks());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("CROSSED by an emergency stop"));
}

// Whatever is not higher counts as safe during a stop.
TEST_F(PlantedFault, FindsACallbackOfTheSameRankThatUndoesAnEmergencyStop) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    MachineConfig lower = config;
    lower.ranks["Dancing"] = *BuiltInRank(kDeActive);
    return Step(lower, i, core, event, now);
  };
  Search(rules, "Active", "Dancing", 1, EqualRanks());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("CROSSED by an emergency stop"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("begins Dancing while an emergency stop is latched")));
}

// Once the stop is released, the controller takes no notice of what it holds.
TEST_F(PlantedFault, FindsACallbackThatTheReleaseOfAnEmergencyStopStarts) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    Event changed = event;
    if (auto* seen = std::get_if<event::StatusSeen>(&changed)) seen->report.held_by_stop = false;
    if (auto* reply = std::get_if<event::Replied>(&changed)) reply->report.held_by_stop = false;
    return Step(config, machine, changed, now);
  };
  Search(rules, "Active", "Dancing", 2, EqualRanks());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("a person releases the emergency stop"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("by the release of the emergency stop")));
}

// The controller forgets the stop once it is released: what was restarted meanwhile is started
// whole.
TEST_F(PlantedFault, FindsARestartedActuatorThatTheReleaseOfAnEmergencyStopSwitchesOn) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    if (!machine.emergency.stop) machine.emergency.awaits_request = false;
    return Step(config, machine, event, now);
  };
  faults_ = OnlyFaults({ChoiceKind::kEngageStop, ChoiceKind::kCrash});
  Search(rules, "Active", "Active", 2, ScenarioNamed("Restarted"));
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("crashes"));
  EXPECT_THAT(scenario_, HasSubstr("a person releases the emergency stop"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("by the release of the emergency stop")));
}

// The next controller does not know of the stop, which was over.
TEST_F(PlantedFault, FindsARestartedActuatorThatTheNextControllerSwitchesOnAfterAReleasedStop) {
  faults_ = OnlyFaults({ChoiceKind::kEngageStop, ChoiceKind::kCrash, ChoiceKind::kRestart});
  Search(WithEvent<event::Begin>(
             [](event::Begin& begin, const Machine&) { begin.stops.awaits_request = false; }),
         "Active", "Active", 3, ScenarioNamed("Restarted"));
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("the controller is killed, and its supervisor starts another"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("by the release of the emergency stop")));
}

// The controller forgets that a person has requested a switch since the stop.
TEST_F(PlantedFault, FindsAnActuatorThatAReleasedStopHoldsAlthoughItsSwitchWasRequestedAgain) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    for (KnownActuator& known : machine.actuators) known.set_again = false;
    return Step(config, machine, event, now);
  };
  Search(rules, "Active", "Dancing", 2, EqualRanks());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("a person releases the emergency stop"));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("is held by a released stop")));
}

// The controller sends nothing to an actuator that ends its callback after the rollback.
TEST_F(PlantedFault, FindsAnActuatorThatStaysActiveAfterItsSwitchWasUndone) {
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    std::erase_if(actions, [&](const Action& a) {
      const auto* send = std::get_if<action::SendSwitch>(&a);
      if (send == nullptr || machine.current || config.RankOf(machine.state)) return false;
      machine.actuators[send->actuator].command.reset();
      return true;
    });
    return actions;
  };
  Search(rules, "SelfCheck", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("is undone: a: overdue"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("is in Active, the machine in SelfCheck")));
}

// The actuator obeys any participant that names a higher epoch.
TEST_F(PlantedFault, FindsAnActuatorThatObeysAnotherMachine) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    if (const auto* arrived = std::get_if<actuator_event::SwitchArrived>(&event)) {
      const actuator_event::ControllerHeartbeatReceived announced{arrived->sender,
                                                                  arrived->command.epoch};
      Step(config, i, core, announced, now);
    }
    return Step(config, i, core, event, now);
  };
  other_machine_ = true;
  Search(rules, "LowPower", "DeActive", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("another machine commands a to Active"));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("message of another machine")));
}

TEST_F(PlantedFault, FindsAnActuatorWhoseStopAnotherMachineReleases) {
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    ActuatorEvent changed = event;
    if (auto* stop = std::get_if<actuator_event::EmergencyStopReceived>(&changed)) {
      stop->sender = core.controller;
    }
    return Step(config, i, core, changed, now);
  };
  other_machine_ = true;
  Search(rules, "Active", "LowPower", 2);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("another machine releases the emergency stop of"));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("message of another machine")));
}

TEST_F(PlantedFault, FindsAControllerThatReleasesControlToALowerEpoch) {
  other_machine_ = true;
  Search(WithEvent<event::RivalSeen>(
             [](event::RivalSeen& rival, const Machine& machine) { rival.epoch = machine.epoch; }),
         "LowPower", "Active", 1);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("none has replaced it")));
}

// The next controller does not know that a person has requested TearDown.
TEST_F(PlantedFault, FindsARestartBySupervisorThatStartsTheMachineAfterATearDown) {
  faults_ = OnlyFaults({ChoiceKind::kRestart});
  Search(WithEvent<event::Begin>(
             [](event::Begin& begin, const Machine&) { begin.stop_intent = false; }),
         "Active", "TearDown", 1, ScenarioNamed("Restarted"));
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("after a TearDown, by no person")));
}

TEST_F(PlantedFault, FindsAHangThatIsNotNoticed) {
  Scenario machine = ScenarioNamed("Restarted");
  machine.config.actuators[0].checkpoint = Milliseconds(500);
  faults_ = OnlyFaults({ChoiceKind::kHang});
  Search(WithEvent<event::HealthChanged>(
             [](event::HealthChanged& changed, const Machine&) { changed.incarnation = 0; }),
         "Active", "LowPower", 1, machine);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("FAULT: the work thread of a hangs"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("a hangs, without a recorded reason")));
}

// A sample that arrives during a switch is forgotten.
TEST_F(PlantedFault, FindsABatteryThatFallsDuringASwitchAndIsForgotten) {
  Scenario machine = ScenarioNamed("Parallel");
  machine.config.policy.emplace().battery.emplace();
  faults_ = OnlyFaults({ChoiceKind::kBatteryFalls});
  Search(WithEvent<event::BatterySeen>([](event::BatterySeen& seen, const Machine& controller) {
           if (controller.current) seen.percent = 100;
         }),
         "LowPower", "Active", 1, machine);
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("FAULT: the battery falls to "));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("and the machine stays in Active")));
}

// The controller receives nothing from another host, and takes no notice of that.
TEST_F(PlantedFault, FindsAHostOutOfReachThatIsNotNoticed) {
  releases_ = false;
  Search(WithEvent<event::HealthChanged>(
             [](event::HealthChanged& changed, const Machine&) { changed.incarnation = 0; }),
         "Active", "Active", 1, TwoHosts());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("the link to host board is cut"));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("the controller has it as present")));
}

// b is critical: without it the machine has to go to Protected.
TEST_F(PlantedFault, FindsAMachineThatStaysActiveWithoutAHost) {
  releases_ = false;
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    const bool lost = std::holds_alternative<event::HealthChanged>(event);
    MachineConfig without = config;
    if (lost) without.actuators[1].on_lost = "Active";
    return Step(without, machine, event, now);
  };
  Search(rules, "Active", "Active", 1, TwoHosts());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("the controller notices that host board is out of reach"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("b is lost, and the machine is in Active")));
}

TEST_F(PlantedFault, FindsATearDownThatIsDoneBesideAHostOutOfReach) {
  releases_ = false;
  faults_ = OnlyFaults({ChoiceKind::kCutLink});
  Rules rules;
  rules.controller = [](const auto& config, auto& machine, const Event& event, Time now) {
    auto actions = Step(config, machine, event, now);
    for (Action& action : actions) {
      auto* answer = std::get_if<action::AnswerSetState>(&action);
      if (answer == nullptr || answer->result.target != kTearDown) continue;
      answer->result.outcome = SwitchOutcome::kDone;
      answer->result.degraded.clear();
      answer->result.actuators.clear();
    }
    return actions;
  };
  Search(rules, "Active", "TearDown", 1, TwoHosts());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("the link to host board is cut"));
  EXPECT_THAT(searched_.fault->violations,
              Contains(HasSubstr("TearDown is reported as done while b runs")));
}

// An actuator that stores no numbers: one fault is enough, which holds its command.
TEST_F(PlantedFault, FindsAnOutdatedCommandOfACutLink) {
  releases_ = false;
  faults_ = OnlyFaults({ChoiceKind::kCutLink});
  Rules rules;
  rules.actuator = [](const auto& config, ActuatorIndex i, auto& core, const auto& event,
                      Time now) {
    if (std::holds_alternative<actuator_event::SwitchArrived>(event)) {
      core.report.number = core.report.outcome_number = 0;
    }
    return Step(config, i, core, event, now);
  };
  Search(rules, "Active", "LowPower", 1, TwoHosts());
  ASSERT_TRUE(searched_.fault);
  EXPECT_THAT(scenario_, HasSubstr("host board is reached again"));
  EXPECT_THAT(scenario_, HasSubstr("a delayed message arrives"));
  EXPECT_THAT(searched_.fault->violations, Contains(HasSubstr("which is outdated")));
}

TEST_F(PlantedFault, ReportsTheShortestScenario) {
  Search(WithEvent<event::ProcessEnded>(
             [](event::ProcessEnded& ended, const Machine&) { ended.pid = 0; }),
         "Active", "Active", 2);
  ASSERT_TRUE(searched_.fault);
  EXPECT_EQ(searched_.fault->path.find('.', searched_.fault->path.find('.') + 1), std::string::npos)
      << "a request and a crash: " << searched_.fault->path;
}

}  // namespace musher::search::planted_fault_test
