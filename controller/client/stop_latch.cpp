#include "musher/controller/client/stop_latch.hpp"

#include <algorithm>
#include <random>
#include <span>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/health/health.hpp"
#include "musher/lifecycle/machine/machine.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// Limits of what is kept about other machines.
constexpr std::size_t kMostMachines = 8;
constexpr std::size_t kLongestUnknownMachine = 80;
constexpr std::size_t kMostOrigins = 64;  // of releases, and of heartbeats
constexpr std::size_t kMostFound = 64;    // processes' hosts of the machines that are meant
constexpr const char* kElsewhere = "not found here, it may run on another host";
constexpr const char* kSecondProcess =
    "several processes run as it, and one of them has not latched the stop";
constexpr const char* kOnlyEarlier =
    "only an earlier stop of it is known, which its controller does not list";
constexpr const char* kEndedAlone =
    "its process has ended without a controller, and what it had switched on may be on";
constexpr const char* kEndedOn =
    "its process has ended, and what it had switched on may be on: it was in ";
constexpr const char* kExitUnknown = "silent, and its exit is not known: it may still run";

// Whether the actuator may move. A lost actuator may, unless its process is known to have ended: on
// another host "crashed" only means silent, and a frozen process is as silent as an exited one. So
// may an actuator that a new controller does not control yet, if the controller has found its
// process, or knows from the disk that it ran on another host. One that has reported its TearDown
// is off, though its process may run on for another actuator.
bool MayMove(const msg::ActuatorInfo& actuator, const std::string& controller_host) {
  const auto is = [&](Presence presence) { return actuator.presence == PresenceName(presence); };
  const bool is_off = actuator.state == kTearDown && actuator.target.empty();
  if (is_off && !is(Presence::kStarting)) return false;
  if (is(Presence::kPresent) || is(Presence::kStarting)) return true;
  if (actuator.health == HealthName(Health::kHung) ||
      actuator.health == HealthName(Health::kPartitioned)) {
    return true;
  }
  const bool elsewhere =
      is(Presence::kAbsent) && !actuator.host.empty() && actuator.host != controller_host;
  return actuator.pid != 0 || elsewhere;
}

// Whether an actuator may have something switched on in the state. A state of the user counts.
bool IsOn(std::string_view state) {
  const auto rank = BuiltInRank(state);
  const bool before = state == kUninitialized || state == kSetUp || state == kSelfCheck;
  return !before && state != kTearDown && (!rank || *rank > *BuiltInRank(kDeActive));
}

std::string WhereEnded(const std::string& state) {
  return state.empty() || state == kUnknownState ? kEndedAlone : kEndedOn + state;
}

// Whether the process of the actuator has exited while it was on, as far as its state says, and
// none has taken its place: no stop reaches what it had switched on.
bool EndedOn(const msg::ActuatorInfo& actuator) {
  return actuator.presence == PresenceName(Presence::kLost) && IsOn(actuator.state);
}

// Why the actuator may not be stopped, as the controller reports it; empty: no reason.
std::string TroubleOf(const msg::ActuatorInfo& actuator) {
  if (actuator.health == HealthName(Health::kWell)) return "";
  const bool exit_unknown = actuator.presence == PresenceName(Presence::kLost) &&
                            actuator.health == HealthName(Health::kCrashed) && actuator.pid != 0;
  return exit_unknown ? kExitUnknown : actuator.health;
}

// Whether both names may be of one boot of a host; an empty name may be of any. DDS keeps a status
// from before a reboot until its writer is lost. The name of a host is its boot id, a '/' and more.
bool MayBeOneBoot(const std::string& host, const std::string& other) {
  const auto boot = [](std::string_view name) { return name.substr(0, name.find('/')); };
  return host.empty() || other.empty() || boot(host) == boot(other);
}

bool IsIn(const std::vector<MachineIdentity>& machines, const MachineIdentity& machine) {
  return std::ranges::any_of(machines, [&](const auto& one) { return SameMachine(one, machine); });
}

}  // namespace

std::vector<std::string> EstopReport::Missing() const {
  std::vector<std::string> missing;
  for (const Actuator& actuator : actuators) {
    if (!actuator.stopped) missing.push_back(actuator.name);
  }
  return missing;
}

bool EstopReport::found() const {
  return controller || std::any_of(actuators.begin(), actuators.end(),
                                   [](const Actuator& actuator) { return actuator.found; });
}

std::string EstopReport::WhyNotHeld() const {
  if (held || (controller && !controller_latched)) return "";
  if (earlier) {
    return "this stop has not arrived; only an earlier one holds the machine, and its release "
           "would "
           "free it";
  }
  return controller ? "the controller has not received it yet" : "";
}

bool EstopReport::settled() const {
  return controller == controller_latched && held &&
         std::all_of(actuators.begin(), actuators.end(), [](const Actuator& actuator) {
           return actuator.stopped || actuator.unsupported || actuator.ended;
         });
}

msg::EmergencyStop NewEmergencyStop(std::string by, std::string_view reason) {
  std::random_device random;
  const std::uint64_t id = (std::uint64_t{random()} << 32U) | random() | 1U;  // not 0
  msg::EmergencyStop stop;
  stop.id = id;
  stop.engaged = true;
  stop.by = std::move(by);
  stop.reason = reason.substr(0, kLongestStopReason);
  return stop;
}

void HandOverStop(const msg::EmergencyStop& stop, int domain_id, const std::string& name_space) {
  NameLock::Send(NameLock::NameOf(domain_id, name_space, "musher/controller"), msg::Encode(stop));
}

StopView ViewFromHere(const StopScope& scope, std::optional<msg::MachineStatus> controller) {
  const std::string names = NameLock::NameOf(scope.domain_id, scope.name_space, "");
  StopView view;
  view.controller = std::move(controller);
  view.has_controller = NameLock::IsHeld(names + "musher/controller");
  view.lan = scope.lan;
  view.machines = scope.machines;
  view.running_here = NameLock::HeldBelow(names);
  return view;
}

StopLatch::StopLatch(transport::Node& node, const std::string& name_space, msg::EmergencyStop stop,
                     StopOptions options)
    : node_(node),
      loop_(node.loop()),
      topic_(transport::EmergencyStopTopic(name_space)),
      stop_(std::move(stop)),
      options_(std::move(options)),
      begun_(loop_.Now()) {}

Result<std::unique_ptr<StopLatch>> StopLatch::Begin(transport::Node& node,
                                                    const std::string& name_space,
                                                    const msg::EmergencyStop& stop,
                                                    StopOptions options) {
  std::unique_ptr<StopLatch> latch(new StopLatch(node, name_space, stop, std::move(options)));
  if (!latch->ContinueFrom(latch->options_.notes)) {
    transport::Qos stops_qos = transport::kLatchedQos;
    stops_qos.depth = static_cast<int>(kMostMachines) + 1;  // a sample for each machine
    auto stops = transport::MakePublisher<msg::EmergencyStop>(node, latch->topic_, stops_qos);
    if (!stops) return stops.error();
    latch->stops_ = std::move(stops).value();
    if (auto published = latch->stops_->Publish(stop); !published) return published.error();
  }
  transport::SubscriptionEvents events;
  events.on_writer_lost = [self = latch.get()](transport::EndpointId writer) {
    for (auto& [name, processes] : self->received_) {
      std::erase_if(processes, [writer](const Received& one) { return one.writer == writer; });
    }
    std::erase_if(self->received_, [](const auto& received) { return received.second.empty(); });
    std::erase_if(self->not_counted_, [writer](const auto& one) { return one.second == writer; });
    if (self->options_.on_change) self->options_.on_change();
  };
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(latch->options_.with_keys);
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      node, transport::ActuatorStatusTopic(name_space),
      [self = latch.get()](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (transport::IsFrom(status, info)) self->OnStatus(status, info);
      },
      qos, std::move(events));
  if (!statuses) return statuses.error();
  latch->statuses_ = std::move(statuses).value();
  latch->FollowReleases(name_space);
  if (!latch->named()) {
    latch->found_by_ = latch->loop_.At(latch->begun_ + latch->TimeToFind(),
                                       [self = latch.get()] { self->WithdrawIfReleased(); });
  }
  return latch;
}

// Where it may not subscribe, the stop stays published: nothing may keep it from being engaged.
void StopLatch::FollowReleases(const std::string& name_space) {
  auto heartbeats = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node_, transport::ControllerHeartbeatTopic(name_space),
      [this](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (heartbeat.participant == 0 || !transport::IsOwn(heartbeat.participant, info)) return;
        Meet({heartbeat.machine, heartbeat.machine_id}, heartbeat.host);
        Note(controllers_, {transport::ParticipantId(heartbeat.participant),
                            {heartbeat.machine, heartbeat.machine_id}});
      },
      transport::kLatchedFromManyQos);
  if (heartbeats) heartbeats_ = std::move(heartbeats).value();
  auto releases = transport::SubscribeToStops(
      node_, name_space, [this](const msg::EmergencyStop& stop, const transport::SampleInfo& info) {
        if (stop.engaged || stop.id != stop_.id) return;
        Note(releases_, {info.participant, {stop.machine, stop.machine_id}});
      });
  if (releases) published_releases_ = std::move(releases).value();
}

bool StopLatch::IsMeant(const MachineIdentity& machine) const {
  if (IsIn(addressed_, machine)) return true;
  const bool narrowed = !stops_ && stops_by_id_;
  return !narrowed && (SameMachine(given(), machine) || BeginsIdOf(machine, id_begins_));
}

// Addresses every machine whose id begins so, even if there are several: no other answer is safe.
void StopLatch::AddBeginningOfId(std::string beginning, const std::vector<MachineIdentity>& known) {
  id_begins_ = std::move(beginning);
  for (const MachineIdentity& machine : known) {
    if (BeginsIdOf(machine, id_begins_) && !withdrawn_) Address(machine);
  }
}

// How long other machines than the first one may take to be found.
Duration StopLatch::TimeToFind() const {
  if (options_.lan) return kLanDiscovery;
  return options_.with_keys ? kSecuredDiscovery : kDiscovery;
}

// A stop that names no machine is for all, whenever they are found: it goes to no ids.
void StopLatch::Meet(const MachineIdentity& machine, const std::string& host) {
  const bool known = named() ? !machine.name.empty() && !machine.id.empty()
                             : !machine.name.empty() || !machine.id.empty();
  if (!known || withdrawn_) return;
  const bool runs_there =
      named() && std::ranges::any_of(found_, [&](const Found& one) {
        return !host.empty() && one.host == host && one.machine.name == machine.name;
      });
  if (!runs_there && !IsMeant(machine)) return;
  const Found found{machine, host};
  if (std::ranges::count(found_, found) != 0 || found_.size() >= kMostFound) return;
  found_.push_back(found);
  if (named()) Address(machine);
  if (publisher_ != nullptr && (by_ids() || !named())) publisher_->Note(NoteOf(found));
  if (by_ids() || !named() || narrow_at_) return;
  narrow_at_ = loop_.At(loop_.Now() + TimeToFind(), [this] { Narrow(); });
}

void StopLatch::Address(const MachineIdentity& machine) {
  if (IsIn(addressed_, machine) || addressed_.size() >= kMostMachines) return;
  addressed_.push_back(machine);
  msg::EmergencyStop stop = stop_;
  stop.machine = machine.name;
  stop.machine_id = machine.id;
  const bool covered = SameMachine(given(), machine);
  if (stops_ && !covered) static_cast<void>(stops_->Publish(stop));
  if (covered && !stop_.machine_id.empty()) return;
  if (!stops_by_id_) {
    transport::Qos qos = transport::kLatchedQos;
    qos.depth = static_cast<int>(kMostMachines);
    auto made = transport::MakePublisher<msg::EmergencyStop>(node_, topic_, qos);
    if (!made) return;
    stops_by_id_ = std::move(made).value();
  }
  static_cast<void>(stops_by_id_->Publish(stop));
}

// From now on the stop goes to the ids of the found machines alone. Not if there are more machines
// than it can address: each of them may be meant.
void StopLatch::Narrow() {
  if (!stops_by_id_ || addressed_.size() >= kMostMachines) return;
  stops_ = nullptr;
  if (publisher_ == nullptr) return;
  for (const Found& found : found_) publisher_->Note(NoteOf(found));
}

std::string StopLatch::NoteOf(const Found& found) {
  const msg::Bytes bytes =
      msg::Encode(msg::MachineInfo{found.machine.name, "", found.host, 0, found.machine.id});
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Continues from the notes of the program. Returns whether the program had narrowed the stop to
// ids. A stop that was given an id stays as it was given.
bool StopLatch::ContinueFrom(const DetachedPublisher::Notes& notes) {
  for (const std::string& note : notes) {
    const auto info = msg::Decode<msg::MachineInfo>(std::as_bytes(std::span(note)));
    if (!info) continue;
    found_.push_back({{info->machine, info->machine_id}, info->host});
    if (named()) Address(found_.back().machine);
  }
  return stop_.machine_id.empty() && stops_by_id_ != nullptr;
}

void StopLatch::ContinueWith(DetachedPublisher& publisher) {
  if (withdrawn_) return publisher.Cancel();
  publisher_ = &publisher;
  if (named() && !by_ids()) return;
  for (const Found& found : found_) publisher.Note(NoteOf(found));
}

void StopLatch::Note(std::vector<Origin>& origins, Origin origin) {
  if (!IsMeant(origin.machine)) return;
  const bool known = std::any_of(origins.begin(), origins.end(), [&origin](const Origin& one) {
    return one.participant == origin.participant && one.machine == origin.machine;
  });
  if (known) return;
  if (origins.size() >= kMostOrigins) origins.erase(origins.begin());
  origins.push_back(std::move(origin));
  WithdrawIfReleased();
}

// Whether each machine that the stop is for has released it. Where more are found than are kept,
// each of the others may not have.
bool StopLatch::IsReleased() const {
  std::vector<MachineIdentity> meant = named() ? machines_ : Machines();
  if (meant.size() >= kMostMachines) return false;
  meant.insert(meant.end(), addressed_.begin(), addressed_.end());
  if (named()) {
    if (addressed_.empty()) meant.push_back(given());
  } else {
    const bool all_found = loop_.Now() >= begun_ + TimeToFind() && found_.size() < kMostFound;
    const std::string here = HostId();
    const bool one_here = !here.empty() && std::ranges::count(found_, here, &Found::host) != 0;
    if (!all_found || !one_here) return false;
    for (const Found& one : found_) meant.push_back(one.machine);
  }
  return std::ranges::all_of(
      meant, [this](const MachineIdentity& machine) { return IsReleasedFor(machine); });
}

void StopLatch::WithdrawIfReleased() {
  if (withdrawn_ || !IsReleased()) return;
  withdrawn_ = true;
  stops_ = nullptr;
  stops_by_id_ = nullptr;
  narrow_at_ = nullptr;
  found_by_ = nullptr;
  if (publisher_ != nullptr) std::exchange(publisher_, nullptr)->Cancel();
  if (options_.on_change) options_.on_change();
}

// Whether a controller of the machine has released the stop.
bool StopLatch::IsReleasedFor(const MachineIdentity& machine) const {
  return std::any_of(releases_.begin(), releases_.end(), [&](const Origin& release) {
    return SameMachine(release.machine, machine) &&
           std::any_of(controllers_.begin(), controllers_.end(), [&](const Origin& controller) {
             return controller.participant == release.participant &&
                    SameMachine(controller.machine, machine);
           });
  });
}

void StopLatch::OnStatus(const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
  const MachineIdentity theirs{status.machine, status.machine_id};
  Meet(theirs, status.host);
  // What is torn down is off, and latches nothing any more: it neither confirms nor prevents.
  const bool is_off = status.emergency_stop == 0 && status.state == kTearDown &&
                      status.target.empty() && status.stop_trouble.empty();
  const bool counts = IsMeant(theirs) && !is_off;
  if (counts) {
    not_counted_.erase(status.name);
  } else if (!status.host.empty() && status.host == HostId() &&
             not_counted_.size() < kMostOrigins) {
    not_counted_[status.name] = info.writer;
  }
  if (!IsMeant(theirs)) return;
  Note(machines_, theirs);
  std::vector<Received>& processes = received_[status.name];
  const StopId latched(status.emergency_stop);
  const bool has_it =
      latched == StopId(stop_.id) || std::ranges::count(status.other_stops, stop_.id) != 0;
  const bool known = std::ranges::any_of(processes, [&](const Received& last) {
    return last.writer == info.writer && last.latched == latched && last.has_it == has_it &&
           last.trouble == status.stop_trouble && last.host == status.host;
  });
  if (known) return;
  // One process of a host at most has the name of the actuator.
  std::erase_if(processes, [&](const Received& last) {
    return last.writer == info.writer || last.host == status.host;
  });
  if (!is_off) {
    processes.push_back(
        {info.writer, latched, has_it, status.stop_trouble, loop_.Now() - begun_, status.host});
  }
  if (processes.empty()) received_.erase(status.name);
  if (options_.on_change) options_.on_change();
}

// The machines with an actuator or a controller that was received, as far as the stop means them;
// each once.
std::vector<MachineIdentity> StopLatch::Machines() const {
  std::vector<MachineIdentity> machines = machines_;
  for (const Origin& controller : controllers_) Note(machines, controller.machine);
  return machines;
}

void StopLatch::Note(std::vector<MachineIdentity>& machines, const MachineIdentity& machine) {
  const auto same = std::find_if(machines.begin(), machines.end(),
                                 [&](const auto& known) { return SameMachine(known, machine); });
  if (same == machines.end()) {
    if (machines.size() < kMostMachines) machines.push_back(machine);
    return;
  }
  if (same->id.empty()) same->id = machine.id;
  if (same->name.empty()) same->name = machine.name;
}

EstopReport StopLatch::Report(const std::optional<msg::MachineStatus>& controller,
                              const std::vector<std::string>& expected) const {
  EstopReport report;
  report.by = stop_.by;
  report.reason = stop_.reason;
  report.machines = Machines();
  if (controller) {
    report.controller = true;
    report.controller_latched = controller->emergency_stop;
    for (const std::string& unsaved : controller->not_on_disk) {
      if (unsaved.starts_with(StoredName(Stored::kEmergencyStops))) report.not_on_disk = unsaved;
    }
    for (const msg::ActuatorInfo& actuator : controller->actuators) {
      const bool ended = !MayMove(actuator, controller->host);
      if (ended && !EndedOn(actuator) && !received_.contains(actuator.name)) continue;
      auto& taken = Take(report, actuator.name, TroubleOf(actuator), controller);
      const auto received = received_.find(actuator.name);
      const bool outdated =
          received != received_.end() &&
          std::ranges::none_of(received->second, [&actuator](const Received& one) {
            return MayBeOneBoot(actuator.host, one.host);
          });
      if (outdated) taken.stopped = taken.before = false;
      if (ended && !taken.stopped && EndedOn(actuator)) {
        taken.ended = !actuator.restarting;  // else its successor latches the stop
        taken.trouble = WhereEnded(actuator.state);
      }
      taken.unsupported = actuator.protocol != ProtocolName(Protocol::kMusher);
      if (taken.unsupported) {
        taken.trouble = "emergency stop not supported (" + actuator.protocol + ")";
      }
    }
  }
  const auto listed = [&report](const std::string& name) {
    return std::any_of(report.actuators.begin(), report.actuators.end(),
                       [&name](const auto& actuator) { return actuator.name == name; });
  };
  for (const auto& [name, received] : received_) {
    if (!listed(name)) Take(report, name, "", controller);
  }
  for (const std::string& name : expected) {
    if (!listed(name)) Take(report, name, "", controller);
  }
  const bool other = controller && !controller->emergency_stop_by.empty() &&
                     (controller->emergency_stop_by != stop_.by ||
                      controller->emergency_stop_reason != stop_.reason);
  const bool before = std::any_of(report.actuators.begin(), report.actuators.end(),
                                  [](const auto& actuator) { return actuator.before; });
  report.held = IsHeld(report, controller);
  if (before || other) report.earlier.emplace();
  if (report.earlier && controller) {
    *report.earlier = {controller->emergency_stop_by, controller->emergency_stop_reason};
  }
  return report;
}

// The controller may have learned of the stop from an actuator first, without its origin. The
// program that engaged the stop must not exit before the controller has received it from the
// program itself. The status of the controller shows the origin of the first stop only. A
// controller that lists another stop of the same person has replaced this stop by it; then this
// stop is held if an actuator still has it. Actuators that the controller has lost do not count:
// DDS keeps their last statuses for a while.
bool StopLatch::IsHeld(const EstopReport& report,
                       const std::optional<msg::MachineStatus>& controller) const {
  if (withdrawn()) return true;
  const std::string id = transport::StopIdText(StopId(stop_.id));
  if (controller && std::ranges::count(controller->stop_ids, id) != 0) {
    const bool first = controller->stop_ids.front() == id;
    return !first || !controller->emergency_stop_by.empty();
  }
  const auto is_lost = [&controller](const std::string& name) {
    return std::ranges::any_of(controller->actuators, [&name](const msg::ActuatorInfo& one) {
      return one.name == name && one.presence != PresenceName(Presence::kPresent);
    });
  };
  const auto has_it = [&](const EstopReport::Actuator& one) {
    return one.stopped && !is_lost(one.name);
  };
  const bool has_holder = controller && std::ranges::any_of(report.actuators, has_it);
  const bool is_of_person = controller && controller->emergency_stop_by == stop_.by;
  const bool waited = loop_.Now() - begun_ >= kDiscovery;
  const bool replaced = has_holder && (is_of_person || waited);
  return (!controller || replaced) &&
         std::ranges::all_of(report.actuators, [this](const EstopReport::Actuator& actuator) {
           return !actuator.stopped ||
                  std::ranges::all_of(received_.at(actuator.name), &Received::has_it);
         });
}

// A controller reports which actuators belong to the machine. What its config lists no more may
// still run, or have crashed while it was on: this host knows. Without a controller there may be
// more than the counted ones: actuators with a process on this host, actuators whose status is
// received, and actuators that may run on other hosts according to the files of this host.
EstopReport StopLatch::Report(const StopView& view) const {
  // A controller of another host may be of another machine than what runs here.
  const bool lists_all = view.controller && (named() || view.controller->host == HostId());
  EstopReport report = Report(view.controller, lists_all ? UnlistedHere(view) : view.running_here);
  if (view.controller) {
    for (const MachineHere* machine : MachinesOf(view)) {
      AddLost(report, Unlisted(machine->lost, *view.controller));
    }
  } else {
    for (const MachineHere* machine : MachinesOf(view)) {
      AddElsewhere(report, machine->elsewhere);
      if (machine->lan) AddElsewhere(report, machine->actuators);
      // Where nothing runs, they may have been torn down without a controller.
      if (!view.running_here.empty()) AddLost(report, machine->lost);
    }
  }
  report.unknown = WhyUnknown(view);
  return report;
}

// Processes of this host that its controller does not list: an earlier config did. Not those that
// answer as actuators of another machine, or as torn down.
std::vector<std::string> StopLatch::UnlistedHere(const StopView& view) const {
  if (view.controller->host != HostId()) return {};
  std::vector<std::string> unlisted;
  for (const std::string& name : view.running_here) {
    const bool listed =
        std::ranges::count(view.controller->actuators, name, &msg::ActuatorInfo::name) != 0;
    if (!listed && !not_counted_.contains(name)) unlisted.push_back(name);
  }
  return unlisted;
}

// The machines of this host that the stop is for.
std::vector<const MachineHere*> StopLatch::MachinesOf(const StopView& view) const {
  std::vector<const MachineHere*> meant;
  for (const MachineHere& machine : view.machines) {
    const bool received = machines_.empty() || IsIn(machines_, machine.identity);
    const bool meant_here =
        named() || view.running_here.empty() || machine.HasOneOf(view.running_here);
    if (IsMeant(machine.identity) && received && meant_here) meant.push_back(&machine);
  }
  return meant;
}

std::string StopLatch::WhyUnknown(const StopView& view) const {
  if (const auto several = Machines(); several.size() > 1) {
    // They may have actuators of the same names, and only one controller is followed.
    std::string unknown = "several machines have received the stop (";
    for (const MachineIdentity& machine : several) {
      if (!unknown.ends_with('(')) unknown += ", ";
      unknown += MachineText(machine).substr(0, kLongestUnknownMachine);
    }
    const auto has_name_of_another = [&several](const MachineIdentity& machine) {
      return std::ranges::count(several, machine.name, &MachineIdentity::name) > 1;
    };
    const bool by_id = std::ranges::any_of(several, has_name_of_another);
    return unknown + "); `musher estop --machine " + (by_id ? "ID" : "NAME") +
           "` stops one of them and confirms that";
  }
  if (view.controller) return "";
  if (view.has_controller) return "the controller does not answer";
  const std::vector<const MachineHere*> machines = MachinesOf(view);
  for (const MachineHere* machine : machines) {
    if (machine->unread.empty()) continue;
    return "no controller answers, and " + machine->unread +
           ", so the machine may have actuators on other hosts";
  }
  const auto is_lan = [](const MachineHere* machine) { return machine->lan; };
  if (view.lan || std::ranges::any_of(machines, is_lan)) {
    return "no controller answers, so the actuators of other hosts are not known";
  }
  for (const std::string& name : view.running_here) {
    const auto has = [&name](const MachineHere* machine) {
      return std::ranges::count(machine->actuators, name) != 0;
    };
    if (std::ranges::any_of(machines, has)) continue;
    return "no controller answers, and no config of a machine with " + name +
           " is found on this host, so it may have actuators on other hosts";
  }
  return "";
}

void StopLatch::AddElsewhere(EstopReport& report, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto is_it = [&name](const EstopReport::Actuator& one) { return one.name == name; };
    if (std::ranges::any_of(report.actuators, is_it)) continue;
    EstopReport::Actuator& actuator = report.actuators.emplace_back();
    actuator.name = name;
    actuator.trouble = kElsewhere;
    actuator.found = false;
  }
}

// Adds the lost actuators that the last controller has stored, unless they were started since.
void StopLatch::AddLost(EstopReport& report, const std::vector<StoredActuator>& lost) {
  for (const StoredActuator& one : lost) {
    const auto is_it = [&one](const EstopReport::Actuator& other) {
      return other.name == one.name && other.found;
    };
    if (!IsOn(one.lost_in) || std::ranges::any_of(report.actuators, is_it)) continue;
    std::erase_if(report.actuators, [&one](const auto& other) { return other.name == one.name; });
    EstopReport::Actuator& actuator = report.actuators.emplace_back();
    actuator.name = one.name;
    actuator.trouble = WhereEnded(one.lost_in);
    actuator.ended = true;
  }
}

std::vector<StoredActuator> StopLatch::Unlisted(std::vector<StoredActuator> actuators,
                                                const msg::MachineStatus& controller) {
  std::erase_if(actuators, [&controller](const StoredActuator& one) {
    return std::ranges::count(controller.actuators, one.name, &msg::ActuatorInfo::name) != 0;
  });
  return actuators;
}

bool StopLatch::IsOver(const EstopReport& report) const {
  const bool discovered = report.controller || loop_.Now() - begun_ >= kDiscovery;
  return discovered && report.settled() && report.unknown.empty();
}

// A controller that lists this stop, and not the earlier one, has released or replaced the earlier
// one, or has not received it. So a status with that one alone may be from before the release: the
// newer one is late, and its actuator free.
bool StopLatch::MayBeReleased(const Received& one,
                              const std::optional<msg::MachineStatus>& controller) const {
  const auto lists = [&controller](StopId stop) {
    return std::ranges::count(controller->stop_ids, transport::StopIdText(stop)) != 0;
  };
  return controller && !one.has_it && lists(StopId(stop_.id)) && !lists(one.latched);
}

EstopReport::Actuator& StopLatch::Take(EstopReport& report, const std::string& name,
                                       const std::string& trouble,
                                       const std::optional<msg::MachineStatus>& controller) const {
  EstopReport::Actuator& actuator = report.actuators.emplace_back();
  actuator.name = name;
  actuator.trouble = trouble;
  const auto received = received_.find(name);
  if (received == received_.end()) return actuator;
  const std::vector<Received>& processes = received->second;
  if (std::ranges::count(processes, StopId(0), &Received::latched) != 0) {
    if (actuator.trouble.empty() && processes.size() > 1) actuator.trouble = kSecondProcess;
    return actuator;
  }
  const auto not_done =
      std::ranges::find_if(processes, [](const Received& one) { return !one.trouble.empty(); });
  if (not_done != processes.end()) {
    actuator.trouble = not_done->trouble;
    return actuator;
  }
  const auto released = [&](const Received& one) { return MayBeReleased(one, controller); };
  if (std::ranges::any_of(processes, released)) {
    if (actuator.trouble.empty()) actuator.trouble = kOnlyEarlier;
    return actuator;
  }
  actuator.stopped = true;
  for (const Received& one : processes) {
    actuator.before |= one.latched != StopId(stop_.id);
    actuator.after = std::max(actuator.after, one.after);
  }
  if (actuator.before) actuator.after = {};
  return actuator;
}

}  // namespace musher
