#include "musher/cli/machine/meant_actuator.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/machine/machines_beside.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {
namespace {

// Those of other hosts are discovered one after the other.
constexpr Duration kStatusComesWithin = Milliseconds(1000);  // of a server that is discovered
constexpr Duration kOthersAnswerWithin = Milliseconds(300);

using Statuses = std::vector<msg::ActuatorStatus>;

MachineIdentity MachineOf(const msg::ActuatorStatus& status) {
  return {status.machine, status.machine_id};
}

bool AreOfOneMachine(const Statuses& statuses) {
  return std::ranges::all_of(statuses, [&](const msg::ActuatorStatus& one) {
    return SameMachine(MachineOf(one), MachineOf(statuses.front()));
  });
}

// "cat (id cafe0000), dog (id d0900000)".
std::string MachinesText(const Statuses& statuses) {
  std::string text;
  for (const msg::ActuatorStatus& one : statuses) {
    const std::string machine =
        one.machine.empty() ? "a machine that sends no name" : MachineText(MachineOf(one));
    if (text.find(machine) == std::string::npos) text += (text.empty() ? "" : ", ") + machine;
  }
  return text;
}

}  // namespace

Result<std::unique_ptr<MeantActuator>> MeantActuator::Begin(Link& link,
                                                            const GlobalOptions& global) {
  std::unique_ptr<MeantActuator> meant(new MeantActuator(link, global));
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = meant.get()](transport::EndpointId writer) {
    self->known_.erase(writer);
  };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(!global.keys.empty());
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      link.node(), transport::ActuatorStatusTopic(global.name_space),
      [self = meant.get()](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (transport::IsFrom(status, info)) self->known_[info.writer] = {status, info.participant};
      },
      qos, std::move(events));
  // An observer may lack the permission: then nothing is known of them.
  if (!statuses && global.keys.empty()) return statuses.error();
  if (statuses) meant->statuses_ = std::move(statuses).value();
  return meant;
}

std::optional<Failure> MeantActuator::Check(const std::string& actuator) {
  const bool awaited = !had_time_.insert(actuator).second;
  if (!awaited && statuses_) link_.RunUntil([&] { return IsKnown(actuator); }, link_.discovery());
  if (had_time_.size() == 1 && !awaited) {
    link_.RunUntil([] { return false; }, kOthersAnswerWithin);
  }
  if (link_.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return CheckFound(OfName(actuator), {"no actuator " + actuator + " of machine ",
                                       ", has no running actuator " + actuator,
                                       actuator + " is an actuator of several machines"});
}

std::optional<Failure> MeantActuator::CheckServers(
    const std::function<std::vector<transport::ParticipantId>()>& servers, const Words& words) {
  if (statuses_) {
    const auto all_known = [&] { return OfParticipants(servers()).size() >= servers().size(); };
    link_.RunUntil(all_known, kStatusComesWithin);
  }
  link_.RunUntil([] { return false; }, kOthersAnswerWithin);
  if (link_.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return CheckFound(OfParticipants(servers()), words);
}

std::optional<Failure> MeantActuator::CheckFound(const Statuses& found, const Words& words) const {
  const std::string where = " in " + NamespaceText(global_.name_space);
  const std::string machines = found.empty() ? "" : "; found " + MachinesText(found);
  if (!global_.machine.empty() &&
      std::ranges::none_of(found, [this](const auto& one) { return IsNamed(one); })) {
    return Failure{
        ExitCode::kNoController,
        {kCodeNetError, words.none + global_.machine + where + machines + ". Nothing was done"}};
  }
  if (found.empty()) return std::nullopt;
  if (!AreOfOneMachine(found)) {
    return Failure{ExitCode::kUsage,
                   {kCodeTargetBusy, words.several + where + ": " + MachinesText(found) +
                                         ". Nothing was done: each of them would receive it; give "
                                         "each a namespace"}};
  }
  const bool runs_here =
      std::ranges::any_of(found, [](const auto& one) { return one.host == HostId(); });
  if (!global_.machine.empty() || runs_here) return std::nullopt;
  const auto here = MachineOfFilesHere(global_);
  if (here && SameMachine(*here, MachineOf(found.front()))) return std::nullopt;
  const auto beside = MachinesBeside(global_, here);
  if (!beside.empty()) {
    return Failure{
        ExitCode::kNoController,
        {kCodeNetError, beside.front().InsteadOf("actuators of " + MachinesText(found), global_)}};
  }
  if (!here) return std::nullopt;
  return Failure{ExitCode::kNoController,
                 {kCodeNetError,
                  "the machine of this host, " + MachineText(*here) + words.lacks + where +
                      machines + ". Nothing was done; --machine NAME speaks to another machine"}};
}

std::optional<Failure> MeantActuator::CheckTogether(
    const std::vector<std::string>& actuators) const {
  Statuses all;
  for (const std::string& actuator : actuators) {
    const Statuses found = OfName(actuator);
    all.insert(all.end(), found.begin(), found.end());
  }
  if (!global_.machine.empty() || AreOfOneMachine(all)) return std::nullopt;
  return Failure{ExitCode::kUsage,
                 {kCodeTargetBusy,
                  "several machines have it in " + NamespaceText(global_.name_space) + ": " +
                      MachinesText(all) + ". Nothing was done; --machine NAME means one of them"}};
}

bool MeantActuator::IsKnown(const std::string& actuator) const {
  return !OfName(actuator).empty();
}

bool MeantActuator::IsOfAnother(const std::string& actuator) const {
  const Statuses found = OfName(actuator);
  return !global_.machine.empty() && !found.empty() &&
         std::ranges::none_of(found, [this](const auto& one) { return IsNamed(one); });
}

Statuses MeantActuator::OfName(const std::string& actuator) const {
  Statuses of_name;
  for (const auto& [writer, known] : known_) {
    if (known.status.name == actuator) of_name.push_back(known.status);
  }
  return of_name;
}

Statuses MeantActuator::OfParticipants(
    const std::vector<transport::ParticipantId>& participants) const {
  Statuses of_them;
  for (const auto& [writer, known] : known_) {
    const bool is_one = std::ranges::find(participants, known.participant) != participants.end();
    if (is_one) of_them.push_back(known.status);
  }
  return of_them;
}

bool MeantActuator::IsNamed(const msg::ActuatorStatus& status) const {
  return status.machine == global_.machine || BeginsIdOf(MachineOf(status), global_.machine);
}

}  // namespace musher::cli
