#include "musher/simulation/simulated_controller.hpp"

#include <algorithm>
#include <utility>

#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/step/emergency_stops.hpp"

namespace musher::simulation {
namespace {

// As Controller's.
constexpr Duration kStandbyPeriod = Milliseconds(100);
constexpr Duration kMajorityPeriod = Milliseconds(100);

}  // namespace

std::vector<UnreadFolder> UnreadFoldersOf(const Disk& disk) {
  std::vector<UnreadFolder> found = disk.unread;
  for (UnreadFolder& folder : found) {
    const auto before = std::ranges::find(disk.stops.unread, folder.mark, &UnreadFolder::mark);
    folder.answered = before != disk.stops.unread.end() && before->answered;
  }
  if (disk.opens == FolderOpens::kNo) {
    for (UnreadFolder& folder : found) folder.answered = false;
    found.push_back({"the state folder", "root", 1, false});
  }
  return found;
}

SimulatedController::SimulatedController(transport::sim::Network& network,
                                         const std::string& endpoint, std::size_t host,
                                         Hosts& hosts, const MachineConfig& config,
                                         const std::string& machine_id,
                                         SimulatedProcesses& processes, Disk& disk, Hooks hooks)
    : network_(network),
      config_(config),
      processes_(processes),
      disk_(disk),
      hooks_(std::move(hooks)),
      endpoint_(endpoint),
      host_(host),
      host_id_(hosts.Id(host)),
      pid_(hosts.NewPid(host)),
      serial_(hosts.NewSerial()),
      node_(network.MakeNode(endpoint)) {
  hosts.Attach(endpoint, host);
  ControllerShell::Dependencies dependencies;
  dependencies.node = node_.get();
  dependencies.links = cyberdog_.links;
  dependencies.processes = this;
  dependencies.process_probe = this;
  if (hooks_.connect) {
    HostUnits::Options options;
    options.since_boot = [this] { return network_.now().time_since_epoch(); };
    if (config_.own_units) options.own = hooks_.connect(node_->loop());
    units_ = std::make_unique<HostUnits>(
        node_->loop(), config_, [this] { return shell_->machine_identity(); },
        hooks_.connect(node_->loop()), std::move(options));
  }
  dependencies.hosts = units_.get();
  dependencies.own_units = config_.own_units;
  dependencies.journal = this;
  SetSaves(dependencies);
  dependencies.output = [](const std::string&) { return nullptr; };
  dependencies.wall_ns = [this] {
    return (network_.now().time_since_epoch() + wall_offset).count();
  };
  dependencies.rules = disk_.rules;
  dependencies.host = host_id_;
  dependencies.pid = pid_;
  dependencies.machine_id = machine_id;
  dependencies.incarnation = hosts.NewIncarnation(host);
  auto shell = ControllerShell::Make(std::move(dependencies), config_, ShellHooks());
  shell_ = std::move(shell).value();
}

void SimulatedController::SetSaves(ControllerShell::Dependencies& dependencies) {
  dependencies.save_epoch = [this](Epoch epoch, const auto& done) {
    Save(disk_.epoch, epoch, done);
  };
  dependencies.save_emergency_stops = [this](const StoredStops& stops, const auto& done) {
    Save(disk_.stops, stops, done);
  };
  dependencies.save_policy = [this](const StoredPolicy& policy, const auto& done) {
    Save(disk_.policy, policy, done);
  };
  dependencies.save_stop_intent = [this](bool intended, const auto& done) {
    Save(disk_.stop_intent, intended, done);
  };
  dependencies.save_remote_actuators = [this](const auto& actuators, const auto& done) {
    Save(disk_.remote, actuators, done);
  };
  dependencies.save_actuators = [this](const auto& actuators, const auto& done) {
    Save(disk_.actuators, actuators, done);
  };
  dependencies.save_children = [this](const std::vector<ChildProcess>& children, const auto& done) {
    disk_.children.clear();
    for (const ChildProcess& child : children) disk_.children[child.actuator] = child;
    disk_.children_host = host_id_;
    done(Ok());
  };
}

ControllerShell::Hooks SimulatedController::ShellHooks() {
  ControllerShell::Hooks hooks;
  hooks.on_record = [this](const action::Record& record) {
    if (manager_) manager_->OnRecord(record);
    if (hooks_.on_record) hooks_.on_record(record);
  };
  hooks.on_send = [this](const action::SendSwitch& command) {
    if (hooks_.on_send) hooks_.on_send(shell_->machine(), command);
  };
  hooks.on_power = [this](bool) {
    if (hooks_.on_power) hooks_.on_power();
  };
  hooks.on_stopped = hooks_.on_over;
  hooks.on_fenced = [this](const std::string&) {
    if (hooks_.on_over) hooks_.on_over();
  };
  hooks.open_services = [this] { return OpenServices(); };
  hooks.holds_answers = [this] {
    return (services_ && services_->HoldsAnswers()) || (manager_ && manager_->HoldsAnswers());
  };
  hooks.close_services = [this] {
    manager_ = nullptr;
    services_ = nullptr;
  };
  return hooks;
}

Result<> SimulatedController::OpenServices() {
  services_ = ControllerServices::Make(*node_, *shell_, [this](auto since, auto limit, auto done) {
                ReadDisk(since, limit, std::move(done));
              }).value();
  const auto save_text = [this](const std::string& name, const std::string& text) {
    disk_.files[name] = text;
  };
  manager_ = cyberdog_.open_services({*node_, *shell_, save_text}).value();
  return Ok();
}

void SimulatedController::ReadDisk(std::int64_t since_wall_ns, std::size_t limit, OnHistory done) {
  JournalReading reading;
  for (const JournalRow& row : disk_.recording) {
    const auto* entry = std::get_if<JournalEntry>(&row.item);
    if (entry != nullptr && entry->wall_ns >= since_wall_ns) reading.entries.push_back(*entry);
  }
  const std::size_t surplus = reading.entries.size() - std::min(limit, reading.entries.size());
  reading.entries.erase(reading.entries.begin(),
                        reading.entries.begin() + static_cast<std::ptrdiff_t>(surplus));
  node_->loop().Post([done = std::move(done), reading = std::move(reading)] { done(reading); });
}

template <class T>
void SimulatedController::Save(T& stored, const T& value,
                               const ControllerShell::Dependencies::OnSaved& done) {
  const auto write = [this, &stored, value, done] {
    if (WritesFail()) return done(Error{kCodeFailed, "the disk is full"});
    stored = value;
    done(Ok());
  };
  disk_.last_saves[&stored] = {serial_, [&stored, value] { stored = value; }};
  if (!disk_.stalled) return write();
  disk_.writes.push_back({serial_, [this, write] { node_->loop().Post(write); }});
}

// Rows that are not durable are lost with the process.
SimulatedController::~SimulatedController() {
  std::erase_if(disk_.writes, [this](const auto& write) { return write.controller == serial_; });
  std::erase_if(disk_.last_saves,
                [this](const auto& save) { return save.second.controller == serial_; });
  if (disk_.stalled && disk_.recording.size() > disk_.durable) {
    disk_.recording.resize(disk_.durable);
    disk_.gap = disk_.wants_snapshot = true;
  }
  network_.Crash(*node_);
}

// As Controller's.
StoredStops SimulatedController::LoadStops() const {
  const StoredStops own = opened_ == FolderOpens::kNo ? StoredStops{} : disk_.stops;
  StoredStops stops = Merge(own, StopsThatHold(own, disk_.other.stops, StopId(0)));
  stops.unread = UnreadFoldersOf(disk_);
  return stops;
}

// As Controller's.
StoredPolicy SimulatedController::LoadPolicy() {
  StoredPolicy policy = disk_.policy;
  if (opened_ == FolderOpens::kNo) {
    policy = {};
    policy.level = BatteryLevel::kLowPower;
  }
  if (disk_.level_taken) return policy;
  policy.level = std::max(policy.level, disk_.other.level);
  if (WritesFail() || disk_.stalled) return policy;
  disk_.policy = policy;
  disk_.level_taken = true;
  return policy;
}

void SimulatedController::Begin(bool takeover, Starter starter) {
  event::Begin begin;
  opened_ = disk_.opens;
  begin.epoch = opened_ == FolderOpens::kNo ? Epoch(0) : disk_.epoch;
  if (const auto& rival = shell_->rival()) {
    if (!takeover) return shell_->Refuse(Refused<Refusal::kAlreadyLed>(rival->process));
    begin.epoch = std::max(begin.epoch, rival->epoch);
  }
  std::vector<ChildProcess> children;
  for (const ActuatorConfig& actuator : config_.actuators) {
    const pid_t pid = FindOne(actuator.name);
    begin.running.push_back(pid != 0);
    begin.processes.push_back(pid);
    const auto child = disk_.children.find(actuator.name);
    const bool is_known = child != disk_.children.end() && disk_.children_host == host_id_;
    if (is_known && child->second.pid == pid) children.push_back(child->second);
    begin.ended.push_back(is_known && pid == 0);
  }
  begin.stops = LoadStops();
  begin.stop_intent = disk_.stop_intent;
  if (opened_ != FolderOpens::kNo) begin.remote = disk_.remote;
  if (opened_ != FolderOpens::kNo) begin.actuators = disk_.actuators;
  begin.policy = LoadPolicy();
  if (led_before_) GoOnFrom(config_, *led_before_, begin);
  begin.restarted = starter == Starter::kSupervisor;
  begin.supervised = starter != Starter::kPerson;
  begin.at_boot = starter == Starter::kBoot;
  begun_ = true;
  if (hooks_.on_begin) hooks_.on_begin(starter);
  shell_->Begin(std::move(begin), children);
  if (!config_.failover) return;
  majority_timer_ = node_->loop().Every(kMajorityPeriod, [this] { WatchMajority(); });
}

// As Controller's.
void SimulatedController::WatchMajority() {
  if (majority_.WhyRelease(config_, shell_->machine(), Now()).empty()) return;
  majority_timer_ = nullptr;
  shell_->ReleaseControl("the standby of another host, as far as this one can know", true);
}

void SimulatedController::StandBy() {
  standby_ = Standby::Make(*node_, config_, [this] { return shell_->machine_identity(); }).value();
  LeadWhatIsLost();
}

// As Controller's.
void SimulatedController::LeadWhatIsLost() {
  if (shell_->refused()) return;
  if (!standby_->WhyNot().empty()) {
    standby_timer_ = node_->loop().At(Now() + kStandbyPeriod, [this] { LeadWhatIsLost(); });
    return;
  }
  led_before_ = standby_->last_status();
  standby_ = nullptr;
  Begin(true, Starter::kSupervisor);
}

void SimulatedController::OnEnd(std::size_t host, std::int32_t pid, const ProcessExit& exit) {
  if (host != host_) return;
  const auto watcher = watchers_.extract(pid);
  if (watcher.empty()) return;
  node_->loop().Post([watchers = watcher.mapped(), exit] {
    for (const OnExit& on_exit : watchers) on_exit(exit);
  });
}

// A Musher actuator holds its name while it runs; the process of any other program is found by what
// a controller has stored about it.
pid_t SimulatedController::FindOne(const std::string& actuator) {
  const pid_t pid = processes_.PidOf(actuator, host_);
  if (!processes_.IsProgram(actuator)) return pid;
  const auto child = disk_.children.find(actuator);
  const bool known = child != disk_.children.end() && child->second.pid == pid &&
                     child->second.start_time == processes_.SerialOf(host_, pid);
  return known ? pid : 0;
}

std::vector<pid_t> SimulatedController::Find(const std::vector<std::string>& actuators) {
  std::vector<pid_t> found;
  found.reserve(actuators.size());
  for (const std::string& actuator : actuators) found.push_back(FindOne(actuator));
  return found;
}

Result<pid_t> SimulatedController::Start(const ProcessSpec& spec, OnExit on_exit) {
  if (!config_.IndexOf(spec.name)) return Error{kCodeUnSupport, "there is no power to switch"};
  if (hooks_.on_start) hooks_.on_start(spec.name);
  if (processes_.IsAlive(spec.name, host_)) return Error{kCodeTargetBusy, "it runs already"};
  const auto variable = [&spec](const char* name) {
    const auto found = spec.env.find(name);
    return found == spec.env.end() ? std::string() : found->second;
  };
  const std::int32_t pid = processes_.Launch(
      spec.name, host_, {variable("MUSHER_MACHINE"), variable("MUSHER_MACHINE_ID")});
  watchers_[pid].push_back(std::move(on_exit));
  return pid;
}

Result<> SimulatedController::Watch(pid_t pid, OnExit on_exit) {
  if (!processes_.Exists(host_, pid)) return Error{kCodeFailed, "no such process"};
  // Not a child: its exit code is not known.
  watchers_[pid].push_back([on_exit = std::move(on_exit)](const ProcessExit&) { on_exit({}); });
  return Ok();
}

Result<> SimulatedController::Prove(const std::string& actuator, pid_t pid, pid_t) {
  if (!processes_.Exists(host_, pid)) return Error{kCodeStateInvalid, "no such process"};
  if (processes_.PidOf(actuator, host_) == pid) return Ok();
  return Error{kCodePermissionDenied, "it is another actuator's process"};
}

void SimulatedController::TakeBacktrace(pid_t, Duration,
                                        std::function<void(Result<std::string>)> done) {
  node_->loop().Post([done = std::move(done)] { done(std::string("main()")); });
}

void SimulatedController::Append(JournalItem item) noexcept {
  if (std::holds_alternative<JournalInput>(item) && hooks_.on_input) hooks_.on_input();
  if (WritesFail()) {
    disk_.gap = disk_.wants_snapshot = true;
    return;
  }
  disk_.recording.push_back(
      {static_cast<std::int64_t>(disk_.recording.size()) + 1, std::move(item)});
}

bool SimulatedController::WantsSnapshot() noexcept {
  const bool lost = !WritesFail() && std::exchange(disk_.wants_snapshot, false);
  return ++inputs_ % 41 == 0 || lost;
}

}  // namespace musher::simulation
