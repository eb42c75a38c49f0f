#include "musher/simulation/authority_checker.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher::simulation {

void AuthorityChecker::NoteWord(const SimulatedController& controller, bool by_supervisor) {
  std::uint64_t& last = last_word_on_[controller.host()];
  if (!by_supervisor || last == 0) last = ++words_;
  Word word{last, controller.serial(), {}, {}};
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* other = robot_.controller(which);
    if (other == nullptr || other == &controller || !other->leads()) continue;
    const Machine& machine = other->shell().machine();
    if (machine.phase == Phase::kStarting) word.together.insert(other->serial());
    word.others[other->serial()] = machine.epoch;
  }
  word_of_[controller.serial()] = std::move(word);
}

Epoch AuthorityChecker::CheckEpoch(const SimulatedController& controller) {
  const Machine& machine = controller.shell().machine();
  Seen& seen = seen_[controller.serial()];
  const Epoch epoch = std::exchange(seen.epoch, machine.epoch);
  if (epoch == 0) {
    seen.began_with = machine.epoch;
    NoteFound(controller);
  }
  if (epoch != 0 && epoch != machine.epoch) CheckRaised(controller, seen, epoch);
  seen.starts = machine.phase == Phase::kStarting;
  return epoch;
}

// What runs on the host of a controller that takes the machine over, by a restart for one.
void AuthorityChecker::NoteFound(const SimulatedController& controller) {
  if (!controller.shell().machine().start_up.requests_nothing) return;
  for (const ActuatorConfig& actuator : config_.actuators) {
    const ActuatorReport* report = robot_.processes().ReportOf(actuator.name, controller.host());
    if (report == nullptr || report->detached || !config_.RankOf(report->state)) continue;
    const bool falls = report->busy() && Falls(config_, report->state, report->target);
    found_[controller.serial()][{actuator.name, controller.host()}] = {
        report->incarnation, falls ? report->target : report->state};
  }
}

void AuthorityChecker::NoteEnded(const std::string& name, std::size_t host,
                                 const ActuatorReport& report) {
  for (auto& [serial, actuators] : found_) {
    const auto found = actuators.find({name, host});
    if (found == actuators.end() || found->second.incarnation != report.incarnation) continue;
    State& most = found->second.most;
    if (Rises(config_, most, report.state)) most = report.state;
  }
}

// Nothing of a machine rises because its controller was restarted: it goes on from the least active
// state that it finds, whatever the stage of the actuator is. A command of the controller before it
// that an actuator has accepted and begins later is part of what it finds.
void AuthorityChecker::CheckRise(std::uint64_t controller, const std::string& name,
                                 std::size_t host, const ActuatorReport& report) {
  for (auto& [serial, actuators] : found_) {
    const auto found = actuators.find({name, host});
    if (found == actuators.end() || found->second.incarnation != report.incarnation) continue;
    State& most = found->second.most;
    if (!Rises(config_, most, report.target)) continue;
    if (controller < serial) most = report.target;
    if (controller != serial) continue;
    ReportViolation(Invariant::kNoUnrequestedActivation,
                    name + " was found in " + most +
                        " by a controller that begins nothing, which leads it to " + report.target);
  }
}

void AuthorityChecker::CheckRaised(const SimulatedController& controller, Seen& seen,
                                   Epoch before) {
  const Epoch epoch = controller.shell().machine().epoch;
  if (++seen.raised == 1 && seen.starts && epoch > before) return;
  ReportViolation(Invariant::kEpochRaisedOnce,
                  "the controller on host " + robot_.hosts().name(controller.host()) +
                      " goes from epoch " + ToString(before) + " to " + ToString(epoch) +
                      (seen.starts ? " in its start" : " while it runs") + ", raise " +
                      std::to_string(seen.raised));
}

// An actuator follows a controller. It must not be one that a person has replaced, while the newer
// one leads; unless the older one had a higher epoch already, of which the person did not know.
void AuthorityChecker::CheckFollows(const std::string& name, std::size_t host,
                                    const ActuatorReport& report) {
  const ActuatorCore* core = robot_.processes().CoreOf(name, host);
  if (core == nullptr || core->controller == 0) return;
  Followed& followed = followed_[{name, host}];
  if (followed.incarnation != report.incarnation) followed = {report.incarnation, {}};
  const SimulatedController* controller = nullptr;
  const SimulatedController* newer = nullptr;
  for (std::size_t which = 0; which < 2; ++which) {
    const SimulatedController* one = robot_.controller(which);
    if (one == nullptr) continue;
    if (Sender(one->participant().value()) == core->controller) controller = one;
    if (one->serial() == followed.word.controller && one->leads()) newer = one;
  }
  if (controller == nullptr || !word_of_.contains(controller->serial())) return;
  const Word& word = word_of_.at(controller->serial());
  if (word.number >= followed.word.number) {
    followed.word = word;
    return;
  }
  if (newer == nullptr || followed.word.together.contains(controller->serial())) return;
  const Epoch epoch = controller->shell().machine().epoch;
  const auto known = followed.word.others.find(controller->serial());
  const bool raised = known == followed.word.others.end() || known->second != epoch;
  const Epoch newest = newer->shell().machine().epoch;
  if (!raised && epoch >= newest) return;
  // Restarted by its supervisor meanwhile: its disk has the epoch, which that person had not seen.
  if (seen_[controller->serial()].began_with == epoch && epoch > newest) return;
  ReportViolation(Invariant::kTakeoverLasts, name + " returns to the controller on host " +
                                                 robot_.hosts().name(controller->host()) +
                                                 ", epoch " + ToString(report.epoch) +
                                                 ", which a person has replaced");
}

// A controller records what a person has requested of it, and what its policy has decided.
void AuthorityChecker::NoteReasons(const SimulatedController& controller,
                                   const action::Record& record) {
  switch (record.event) {
    case EventName::kSwitchRequested:
    case EventName::kPolicyRequested:
    case EventName::kBatterySwitchUp:
    case EventName::kBatterySwitchDown:
    case EventName::kLyingStillSwitch:
      break;
    default:
      return;
  }
  found_.erase(controller.serial());
  const State target(ArgumentOf(record.arguments, "target"));
  // A wake-up, for one, leads to Active or as far as the battery permits.
  reasons_[controller.serial()].insert(target.empty() ? State(kActive) : target);
}

// Whether a machine in `from` may bring itself, or an actuator, to `to`. Where a start has not led
// to a state yet, the start is the reason. An actuator joins in the machine's state.
bool AuthorityChecker::HasReason(std::uint64_t controller, const State& from,
                                 const State& to) const {
  const auto place = config_.RankOf(from);
  const auto rank = config_.RankOf(to);
  if (!place || !rank || *rank <= *place) return true;
  const auto reasons = reasons_.find(controller);
  return reasons != reasons_.end() &&
         std::any_of(reasons->second.begin(), reasons->second.end(), [&](const State& reason) {
           return reason == to || config_.RankOf(reason).value_or(0) >= *rank;
         });
}

// The state of a machine may have changed since `before`.
void AuthorityChecker::CheckReason(const SimulatedController& controller, const State& before) {
  const Machine& machine = controller.shell().machine();
  if (!HasReason(controller.serial(), before, machine.state)) {
    ReportViolation(Invariant::kRisesAreRecorded,
                    "the machine went from " + before + " to " + machine.state +
                        ", for which the controller has recorded no reason");
  }
  if (!machine.current && !machine.waiting) reasons_[controller.serial()].clear();
}

// A controller acts on a client's request. Clients name themselves after the machine they mean.
void AuthorityChecker::CheckMeant(const action::Record& record) {
  if (other_ == nullptr) return;
  const std::string theirs = Client::Name(other_->identity().id);
  if (record.message.find(theirs) == std::string::npos) return;
  ReportViolation(
      Invariant::kReachesMeantMachine,
      "machine " + robot_.identity().id + " acts on a request of another: " + record.message);
}

// An actuator obeys the controllers of its own machine.
void AuthorityChecker::CheckControllerOf(const std::string& name, Sender controller) {
  if (other_ == nullptr || controller == 0) return;
  if (!other_->IsController(transport::ParticipantId(controller.value()))) return;
  ReportViolation(Invariant::kReachesMeantMachine,
                  name + " obeys a controller of machine " + other_->identity().id);
}

// A controller is fenced. A controller of its own machine must have begun beside it, or has
// requested that as a process of the same host; or it leaves the machine to its standby.
void AuthorityChecker::CheckFence(const SimulatedController& controller,
                                  const action::Record& record) {
  if (record.event != EventName::kControllerFenced || other_ == nullptr) return;
  const bool requested = record.message.find("of this host") != std::string::npos;
  const bool has_rival = word_of_.size() > word_of_.count(controller.serial());
  if (requested || has_rival || config_.failover) return;
  ReportViolation(
      Invariant::kOtherMachineNeverFences,
      "the only controller of machine " + robot_.identity().id + " is fenced: " + record.message);
}

}  // namespace musher::simulation
