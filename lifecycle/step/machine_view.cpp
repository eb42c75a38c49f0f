#include "musher/lifecycle/step/machine_view.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {

bool MachineView::IsComing(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  const bool about_to_end = record.process.termination.has_value();  // and is restarted after that
  return record.restart.at || record.restart.requested ||
         (record.set_up_by && (record.presence == Presence::kStarting || about_to_end));
}

bool MachineView::IsFree(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  return record.presence == Presence::kPresent && !record.command && !record.report.busy() &&
         record.health != Health::kHung && !record.restart.given_up && !record.restart.requested;
}

bool MachineView::MayRestart(ActuatorIndex i) const {
  return !ConfigOf(i).command.empty() && ConfigOf(i).restart.policy != RestartPolicy::kNo;
}

std::int32_t MachineView::ProcessOf(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  if (record.process.pid != 0) return record.process.pid;
  const ActuatorReport& report = record.report;
  const bool here = !report.host.empty() && report.host == view_.host;
  return here && report.incarnation != record.process.dead ? report.pid : 0;
}

std::int32_t MachineView::OwnProcess(ActuatorIndex i) const {
  return ConfigOf(i).command.empty() ? 0 : ProcessOf(i);
}

bool MachineView::RunsElsewhere(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  const bool connected =
      record.presence == Presence::kPresent || record.presence == Presence::kStarting;
  const ActuatorReport& report = record.report;
  return connected && record.process.pid == 0 && report.incarnation != 0 &&
         report.incarnation != record.process.dead && !report.host.empty() &&
         report.host != view_.host;
}

bool MachineView::AnotherProcessIsPresent(ActuatorIndex i, std::int32_t pid) const {
  const ActuatorRecord& record = Of(i);
  const bool publishes =
      record.presence == Presence::kPresent ||
      (record.presence == Presence::kStarting && record.report.incarnation != record.process.dead);
  const bool here = !record.report.host.empty() && record.report.host == view_.host;
  return publishes && here && record.report.pid != 0 && record.report.pid != pid;
}

bool MachineView::Fits(ActuatorIndex i) const {
  return Of(i).checked || Of(i).state() == view_.state;
}

bool MachineView::MayFollow(ActuatorIndex i) const {
  return Of(i).checked || IsAbovePlace(i);
}

State MachineView::RestOf(ActuatorIndex i) const {
  for (const std::string_view rest : {kDeActive, kLowPower}) {
    if (ConfigOf(i).Lists(rest) && config_.RankOf(rest)) return State(rest);
  }
  return {};
}

bool MachineView::IsAbovePlace(ActuatorIndex i) const {
  const State& state = Of(i).state();
  if (config_.RankOf(view_.state)) return Falls(config_, state, view_.state);
  const State rest = RestOf(i);
  return rest.empty() ? Rises(config_, kUninitialized, state) : Falls(config_, state, rest);
}

bool MachineView::NeedsMet(ActuatorIndex i, std::optional<RecordText>& blocker) const {
  bool met = true;
  for (const std::string& name : ConfigOf(i).after) {
    const ActuatorRecord& needed = Of(*config_.IndexOf(name));
    if (needed.fault && !needed.suspended && !IsComing(*config_.IndexOf(name)))
      blocker = texts::DependencyDegraded(name, needed.fault->message);
    if (needed.presence != Presence::kPresent || needed.fault) met = false;
  }
  return met;
}

RecordId MachineView::CauseOfBlocker(ActuatorIndex i) const {
  for (const std::string& name : ConfigOf(i).after) {
    const ActuatorRecord& needed = Of(*config_.IndexOf(name));
    if (needed.fault) return needed.cause;
  }
  return 0;
}

std::optional<RecordText> MachineView::WaitsForSuspended(ActuatorIndex i) const {
  for (const std::string& name : ConfigOf(i).after) {
    if (Of(*config_.IndexOf(name)).suspended) return texts::DependencySuspended(name);
  }
  return std::nullopt;
}

State MachineView::PlaceOf(ActuatorIndex i) const {
  const ActuatorRecord& record = Of(i);
  if (!record.suspended) return view_.state;
  const State rest = RestOf(i);
  if (rest.empty() || !Falls(config_, record.state(), rest)) return record.state();
  return Falls(config_, rest, view_.state) ? view_.state : rest;
}

bool MachineView::StageIsSetUp(int stage) const {
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    if (ConfigOf(i).stage > stage) continue;
    if (view_.start_up.finishing && !Of(i).set_up_by) continue;
    if (Of(i).presence != Presence::kPresent && (!Of(i).fault || IsComing(i))) return false;
  }
  return true;
}

// Whether each actuator of the stage is in the state of the machine, or will not be.
bool MachineView::StageIsSettled(int stage) const {
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    const ActuatorRecord& record = Of(i);
    if (ConfigOf(i).stage > stage || record.fault || record.held) continue;
    const bool joined =
        record.presence == Presence::kPresent && Fits(i) && !record.due && !record.command;
    if (!joined) return false;
  }
  return true;
}

bool MachineView::EndsKeep(const Switch& s) const {
  const auto& keep = view_.policy.keep;
  const bool leads_elsewhere = !s.only && s.direction != Direction::kCheck;
  return keep && leads_elsewhere && s.purpose != Purpose::kStop && keep->state != s.target;
}

int LastStage(const MachineConfig& config) {
  int last = 1;
  for (const ActuatorConfig& actuator : config.actuators) last = std::max(last, actuator.stage);
  return last;
}

}  // namespace musher
