#include "musher/lifecycle/step/machine_view.hpp"

#include <algorithm>

#include "musher/lifecycle/config/flow.hpp"

namespace musher {

bool MachineView::IsComing(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const bool about_to_end = known.process.termination.has_value();  // and is restarted after that
  return known.restart.at || known.restart.requested ||
         (known.set_up_by && (known.presence == Presence::kStarting || about_to_end));
}

bool MachineView::IsFree(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  return known.presence == Presence::kPresent && !known.command && !known.report.busy() &&
         known.health != Health::kHung && !known.restart.given_up && !known.restart.requested;
}

bool MachineView::MayRestart(ActuatorIndex i) const {
  return !ConfigOf(i).command.empty() && ConfigOf(i).restart.policy != RestartPolicy::kNo;
}

bool MachineView::IsTaken(ActuatorIndex i) const {
  const ActuatorProcess& process = Of(i).process;
  const auto& taken = process.taken;
  return taken && process.pid != 0 && taken->pid == process.pid && !process.host.empty() &&
         taken->host == process.host;
}

std::int32_t MachineView::ProcessOf(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  if (known.process.pid != 0) return IsTaken(i) ? 0 : known.process.pid;
  const ActuatorReport& report = known.report;
  const bool here = !report.host.empty() && report.host == view_.host;
  return here && report.incarnation != known.process.dead ? report.pid : 0;
}

std::int32_t MachineView::OwnProcess(ActuatorIndex i) const {
  return ConfigOf(i).command.empty() ? 0 : ProcessOf(i);
}

const std::string& MachineView::HostOf(ActuatorIndex i) const {
  const std::string& host = Of(i).process.host;
  return host.empty() ? view_.host : host;
}

bool MachineView::RunsElsewhere(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const bool connected =
      known.presence == Presence::kPresent || known.presence == Presence::kStarting;
  const ActuatorReport& report = known.report;
  const std::string& host = HostOf(i);
  // A process of our host that only waits beside the process in use is not meant.
  const bool waits_there = known.other && known.other->host == host;
  return connected && (known.process.pid == 0 || waits_there) && report.incarnation != 0 &&
         report.incarnation != known.process.dead && !report.host.empty() && report.host != host;
}

bool MachineView::IsReportOf(ActuatorIndex i, std::int32_t pid) const {
  const ActuatorReport& report = Of(i).report;
  return report.pid == pid && (report.host.empty() || report.host == HostOf(i));
}

bool MachineView::IsOfEnded(ActuatorIndex i, const ActuatorReport& report) const {
  const ActuatorProcess& process = Of(i).process;
  const bool same_host = !report.host.empty() && report.host == process.ended_host;
  return process.ended_pid != 0 && same_host &&
         (report.pid == process.ended_pid || report.pid == 0);
}

bool MachineView::AnotherProcessIsPresent(ActuatorIndex i, std::int32_t pid) const {
  const KnownActuator& known = Of(i);
  const bool publishes =
      known.presence == Presence::kPresent ||
      (known.presence == Presence::kStarting && known.report.incarnation != known.process.dead);
  return publishes && !known.report.host.empty() && known.report.pid != 0 && !IsReportOf(i, pid);
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
    const KnownActuator& needed = Of(*config_.IndexOf(name));
    if (needed.fault && !needed.suspended && !IsComing(*config_.IndexOf(name)))
      blocker = texts::DependencyDegraded(name, needed.fault->message);
    if (needed.presence != Presence::kPresent || needed.fault) met = false;
  }
  return met;
}

RecordId MachineView::CauseOfBlocker(ActuatorIndex i) const {
  for (const std::string& name : ConfigOf(i).after) {
    const KnownActuator& needed = Of(*config_.IndexOf(name));
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

bool MachineView::IsPlace(const State& state) const {
  return config_.RankOf(state) && state != kTearDown;
}

bool MachineView::IsKeptBelow(ActuatorIndex i) const {
  const State& kept_in = Of(i).kept_in;
  return !kept_in.empty() && Falls(config_, view_.state, kept_in);
}

bool MachineView::IsKeptApart(ActuatorIndex i) const {
  const State& kept_in = Of(i).kept_in;
  const bool ranked = config_.RankOf(view_.state).has_value();  // not in a step of a start
  return !kept_in.empty() && ranked && kept_in != view_.state &&
         !Rises(config_, view_.state, kept_in);
}

State MachineView::PlaceOf(ActuatorIndex i) const {
  const KnownActuator& known = Of(i);
  const State& place = IsKeptApart(i) ? known.kept_in : view_.state;
  if (!known.suspended) return place;
  const State rest = RestOf(i);
  if (rest.empty() || !Falls(config_, known.state(), rest)) return known.state();
  return Falls(config_, rest, place) ? place : rest;
}

bool MachineView::IsAwaitedIn(ActuatorIndex i, int stage) const {
  const bool found = Of(i).process.launch == Launch::kFoundRunning && !view_.start_up.set_up;
  return ConfigOf(i).stage <= stage || found;
}

bool MachineView::StageIsSetUp(int stage) const {
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    if (!IsAwaitedIn(i, stage)) continue;
    if (view_.start_up.finishing && !Of(i).set_up_by) continue;
    if (Of(i).presence != Presence::kPresent && (!Of(i).fault || IsComing(i))) return false;
  }
  return true;
}

// Whether each actuator of the stage is in the state of the machine, or will not be.
bool MachineView::StageIsSettled(int stage) const {
  for (const ActuatorIndex i : view_.actuators.Indices()) {
    const KnownActuator& known = Of(i);
    if (ConfigOf(i).stage > stage || known.fault || known.held) continue;
    const bool joined =
        known.presence == Presence::kPresent && Fits(i) && !known.due && !known.command;
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
