#include "musher/simulation/robot.hpp"

#include <signal.h>

#include <algorithm>
#include <utility>

#include "musher/wire/lifecycle_wire.hpp"

namespace musher::simulation {
namespace {

// Runs its callbacks by a script.
class ScriptedModule : public Module {
 public:
  ScriptedModule(const Script& script, std::string name)
      : script_(script), name_(std::move(name)) {}
  Act Run(const State& state) override { return script_ ? script_(name_, state) : Act{}; }

 private:
  const Script script_;
  const std::string name_;
};

// How long a controller listens for others before it begins, with several hosts.
constexpr Duration kListenTime = Milliseconds(1000);
// After so long a silent participant of profile lan is lost: a standby waits longer.
constexpr Duration kLanLease = std::chrono::seconds(2);
// How long the controller before it has to release control.
constexpr Duration kReleaseTimeout = Milliseconds(1000);
// How often the battery and the body publish their status. The body of a simulated world does so
// often enough for a world that runs ten times as fast.
constexpr Duration kBodyPeriod = std::chrono::seconds(1);
constexpr Duration kWorldBodyPeriod = Milliseconds(100);

msg::BmsStatus BatteryAt(int percent, bool charging) {
  msg::BmsStatus status;
  status.batt_soc = static_cast<std::uint8_t>(percent);
  status.power_wired_charging = charging;
  return status;
}

// As `musher up` reads it on the host of that controller.
MachineConfig ConfigOn(MachineConfig config, const Layout& layout, std::size_t controller) {
  if (config.failover) TakeOwnHosts(config, {layout.hosts[layout.controllers[controller]]});
  return config;
}

}  // namespace

SimRobot::SimRobot(std::uint64_t seed, MachineConfig config, Script script, const Layout& layout)
    : SimRobot(std::make_unique<World>(seed, layout.hosts), nullptr, std::move(config),
               std::move(script), layout) {}

SimRobot::SimRobot(SimRobot& beside, MachineConfig config, Script script, Layout layout)
    : SimRobot(nullptr, &beside, std::move(config), std::move(script), std::move(layout)) {}

SimRobot::SimRobot(std::unique_ptr<World> world, SimRobot* beside, MachineConfig config,
                   Script script, Layout layout)
    : config_(std::move(config)),
      layout_(std::move(layout)),
      configs_({ConfigOn(config_, layout_, 0), ConfigOn(config_, layout_, 1)}),
      world_(std::move(world)),
      network_(world_ ? world_->network : beside->network_),
      hosts_(world_ ? world_->hosts : beside->hosts_),
      switched_on_(network_.now()),
      environment_(network_.MakeNode("environment")),
      processes_(network_, config_, hosts_, layout_) {
  if (config_.failover) network_.SetLease(kLanLease);
  processes_.make_module = [script = std::move(script)](const std::string& name) {
    return std::make_unique<ScriptedModule>(script, name);
  };
  network_.on_write = [this, others = std::move(network_.on_write)](
                          transport::ParticipantId participant, const std::string& topic,
                          const msg::Bytes& bytes) {
    if (others) others(participant, topic, bytes);
    if (!on_write) return;
    for (const auto& controller : controllers_) {
      if (controller && controller->participant() == participant) {
        on_write(*controller, topic, bytes);
      }
    }
  };
  const bool units = config_.own_units ||
                     std::ranges::any_of(config_.actuators, [](const ActuatorConfig& actuator) {
                       return !actuator.host.empty();
                     });
  if (units) {
    systemds_ = std::make_unique<SimulatedSystemds>(network_, config_, hosts_, processes_);
  }
  processes_.on_end = [this](std::size_t host, std::int32_t pid, const ProcessExit& exit) {
    if (systemds_) systemds_->OnEnd(host, pid, exit);
    for (const auto& controller : controllers_) {
      if (controller) controller->OnEnd(host, pid, exit);
    }
  };
}

SimRobot::~SimRobot() {
  processes_.on_end = {};
  network_.on_write = {};
  on_killed = {};
  CrashController();
}

void SimRobot::Open(std::size_t which) {
  SimulatedController::Hooks hooks;
  hooks.on_input = [this] {
    if (on_input) on_input();
  };
  hooks.on_record = [this, which](const action::Record& record) {
    if (on_record_of) on_record_of(*controllers_[which], record);
    if (on_record) on_record(record);
  };
  hooks.on_send = [this](const Machine& machine, const action::SendSwitch& command) {
    if (on_send) on_send(machine, command);
  };
  hooks.on_start = [this, which](const std::string& name) {
    if (on_start) on_start(*controllers_[which], name);
  };
  hooks.on_signal = [this, which](std::int32_t pid) {
    if (on_signal) on_signal(*controllers_[which], pid);
  };
  hooks.on_begin = [this, which](Starter starter) {
    if (on_begin) on_begin(*controllers_[which], starter);
  };
  hooks.on_power = [this] {
    if (on_power) on_power();
  };
  // A controller that has stopped the machine stays, for the checks; a fenced one ends.
  hooks.on_over = [this, which] {
    const auto serial = controllers_[which]->serial();
    environment_->loop().Post([this, which, serial] {
      const auto& controller = controllers_[which];
      // The next controller may already run in its place.
      if (!controller || controller->serial() != serial || controller->leads()) return;
      EndController(which);
      const auto& other = controllers_[1 - which];
      if (other && other->leads() && other->shell().machine().phase == Phase::kStopped) {
        EndController(1 - which);  // a real one has exited by itself
      }
    });
  };
  if (systemds_) {
    hooks.connect = [this, which](transport::EventLoop& loop) {
      return systemds_->From(layout_.controllers[which], loop, [this, which](const auto& name) {
        if (on_start) on_start(*controllers_[which], name);
      });
    };
  }
  controllers_[which] = std::make_unique<SimulatedController>(
      network_, layout_.prefix + kControllerEndpoints[which], layout_.controllers[which], hosts_,
      configs_[which], layout_.machine_id, processes_, DiskOf(which), std::move(hooks));
  controllers_ever_.insert(controllers_[which]->participant());
}

void SimRobot::StartController(Duration listens) {
  Open(0);
  RunFor(listens);
  controllers_[0]->Begin(true);
}

void SimRobot::LaunchController(std::size_t which, bool takeover, Duration listens,
                                Starter starter) {
  Open(which);
  if (listens == Duration::zero()) return controllers_[which]->Begin(takeover, starter);
  transport::EventLoop& loop = controllers_[which]->node().loop();
  begins_[which] = loop.At(loop.Now() + listens, [this, which, takeover, starter] {
    controllers_[which]->Begin(takeover, starter);
  });
}

// With profile lan there may be a controller on another host.
Duration SimRobot::ListenTime() const {
  return config_.transport == TransportProfile::kLan ? kListenTime : Duration::zero();
}

void SimRobot::StartStandby() {
  if (!config_.failover || OneHost() || controllers_[1]) return;
  Open(1);
  controllers_[1]->StandBy();
}

void SimRobot::StartRival(bool takeover) {
  const bool in_place = takeover && controllers_[1] && controllers_[1]->stands_by();
  if (in_place) EndController(1);
  if (controllers_[1]) return;
  if (!OneHost()) return LaunchController(1, takeover, kListenTime);
  const auto& first = controllers_[0];
  if (first && first->leads() && first->shell().machine().phase == Phase::kStopped) {
    EndController(0);  // a real one has exited by itself
  }
  if (!first) return LaunchController(1, takeover, ListenTime());
  if (takeover) TakeOverOnSameHost();
}

void SimRobot::TakeBack() {
  if (!controllers_[0] && !OneHost()) LaunchController(0, true, kListenTime);
}

// The first controller is requested to release control, and killed if it does not within a second.
void SimRobot::TakeOverOnSameHost() {
  if (takes_over_) return;
  const bool stuck = controllers_[0]->frozen;
  if (!stuck) {
    controllers_[0]->shell().ReleaseControl("process " + std::to_string(hosts_.NewPid(0)) +
                                            " of this host");
  }
  const Duration timeout = stuck ? kReleaseTimeout : Milliseconds(1);
  takes_over_ = environment_->loop().At(environment_->loop().Now() + timeout, [this] {
    takes_over_.reset();
    if (controllers_[1]) return;
    KillController(0);
    LaunchController(1, true, ListenTime());
  });
}

void SimRobot::EndController(std::size_t which) {
  begins_[which].reset();
  controllers_[which].reset();
}

void SimRobot::KillController(std::size_t which) {
  if (!controllers_[which]) return;
  if (on_killed) on_killed(*controllers_[which]);
  const bool led = controllers_[which]->leads();
  for (const auto& [host, client] : clients_) {
    if (led) client->OnControllerKilled();
  }
  EndController(which);
}

void SimRobot::CrashController() {
  KillController(0);
  KillController(1);
}

void SimRobot::CrashLeader() {
  const SimulatedController* leading = leader();
  for (std::size_t which = 0; which < controllers_.size(); ++which) {
    if (leading != nullptr && controllers_[which].get() == leading) return KillController(which);
  }
}

void SimRobot::RebootHost(std::size_t host) {
  for (std::size_t which = 0; which < controllers_.size(); ++which) {
    if (controllers_[which] && controllers_[which]->host() == host) KillController(which);
  }
  if (systemds_) systemds_->PowerOff(host);
  processes_.EndAllOn(host);
  clients_.erase(host);
  std::vector<StopId> ended;
  for (const auto& [id, program] : stop_programs_) {
    if (program->host() == host) ended.push_back(id);
  }
  if (permits_ && permits_->host() == host) EndPermits();
  for (const StopId id : ended) {
    stop_programs_.erase(id);
    if (on_stop_withdrawn) on_stop_withdrawn(id);
  }
  hosts_.Reboot(host);
}

void SimRobot::BootHost(std::size_t host) {
  hosts_.SetBooted(host);
  if (systemds_) systemds_->Boot(host);
}

void SimRobot::FreezeController() {
  if (SimulatedController* leading = leader()) {
    leading->frozen = true;
    network_.Pause(leading->node());
  }
}

void SimRobot::ThawController() {
  for (const auto& controller : controllers_) {
    if (!controller || !std::exchange(controller->frozen, false)) continue;
    controller->thawed = network_.now();
    network_.Resume(controller->node());
  }
}

void SimRobot::CrashActuator(const std::string& name) {
  if (IsAlive(name)) processes_.End(name, {ProcessExit::Kind::kKilled, SIGKILL});
}

void SimRobot::FillDisk(bool full) {
  for (Disk& disk : disks_) disk.full = full;
}

void SimRobot::StallDisk(bool stalled) {
  for (Disk& disk : disks_) {
    if (stalled && !disk.stalled) disk.durable = disk.recording.size();
    disk.stalled = stalled;
    if (stalled) continue;
    for (const Disk::Write& write : std::exchange(disk.writes, {})) write.end();
  }
}

void SimRobot::LoseFiles() {
  for (Disk& disk : disks_) {
    disk.epoch = 0;
    disk.stops = {};
    disk.stop_intent = false;
    disk.remote.clear();
    disk.actuators.clear();
    disk.policy = {};
    disk.files.clear();
    disk.recording.clear();
    disk.durable = 0;
    disk.gap = disk.wants_snapshot = true;
  }
}

void SimRobot::SaveAgain() {
  for (Disk& disk : disks_) {
    if (disk.full || disk.stalled) continue;
    for (const auto& [stored, save] : disk.last_saves) save.end();
  }
}

Client& SimRobot::ClientOn(std::size_t host) {
  auto& client = clients_[host];
  if (!client) client = std::make_unique<Client>(network_, hosts_, config_, layout_, host);
  return *client;
}

std::vector<const Client::Request*> SimRobot::OpenRequests() const {
  std::vector<const Client::Request*> open;
  for (const auto& [host, client] : clients_) {
    for (const Client::Request& request : client->open()) open.push_back(&request);
  }
  return open;
}

void SimRobot::AddUnreadFolder(std::uint64_t mark) {
  for (Disk& disk : disks_) disk.unread.push_back({"/var/lib/musher/other", "root", mark});
}

bool SimRobot::FindsUnreadFolder(const SimulatedController& controller) const {
  const bool second = !OneHost() && controllers_[1].get() == &controller;
  const auto found = UnreadFoldersOf(disks_[second ? 1 : 0]);
  return std::ranges::count(found, false, &UnreadFolder::answered) != 0;
}

void SimRobot::SetFolderOpens(FolderOpens opens) {
  for (Disk& disk : disks_) disk.opens = opens;
}

void SimRobot::ChangeUser() {
  CrashController();
  by_other_user_ = !by_other_user_;
  for (Disk& disk : disks_) {
    std::swap(disk.stops, disk.other.stops);
    std::swap(disk.policy.level, disk.other.level);
    std::swap(disk.policy.lowering, disk.other.lowering);
    disk.level_taken = false;
  }
}

void SimRobot::JumpWallClock(Duration by) {
  for (const auto& controller : controllers_) {
    if (controller) controller->wall_offset += by;
  }
}

StopId SimRobot::EngageEmergencyStop(StopId id, std::size_t panel, const std::string& by) {
  Panel& p = panels_[panel];
  if (!p.node) {
    p.node = network_.MakeNode(layout_.prefix + "panel-" + std::to_string(panel));
    p.button =
        transport::MakePublisher<msg::EmergencyStop>(
            *p.node, transport::EmergencyStopTopic(config_.name_space), transport::kLatchedQos)
            .value();
  }
  static_cast<void>(p.button->Publish({id.value(), true, by, ""}));
  if (id != 0) return id;
  transport::SampleInfo info;  // as every receiver gets it
  info.written_ns = Duration(network_.now().time_since_epoch()).count();
  return StopId(transport::StopIdOf(info));
}

StopView SimRobot::ViewOf(std::size_t host) const {
  StopView view;
  view.lan = config_.transport == TransportProfile::kLan;
  MachineHere machine{{config_.name, ""}, view.lan};
  for (const auto& controller : controllers_) {
    view.has_controller |= controller && controller->host() == host;
  }
  for (const ActuatorConfig& actuator : config_.actuators) {
    machine.actuators.push_back(actuator.name);
    if (IsAlive(actuator.name) && processes_.IsAlive(actuator.name, host)) {
      view.running_here.push_back(actuator.name);
    }
  }
  view.machines.push_back(std::move(machine));
  return view;
}

MachineIdentity SimRobot::EngageByProgram(StopId id, std::size_t host, const StopLinks& links,
                                          bool named) {
  StopClient::Options options;
  options.endpoint = layout_.prefix + "estop-" + ToString(id);
  options.host = host;
  options.name_space = config_.name_space;
  options.delay_most = links.delay_most;
  options.loss = links.loss;
  options.discovery_most = links.discovery_most;
  options.view = [this, host] { return ViewOf(host); };
  if (ViewOf(host).has_controller) options.machine = identity();
  if (named) options.machine = {config_.name, ""};
  MachineIdentity machine = options.machine;
  stop_programs_[id] = std::make_unique<StopClient>(
      network_, hosts_, std::move(options), id,
      [this, id](bool confirmed) {
        if (on_stop_program) on_stop_program(id, confirmed);
      },
      [this, id] {
        environment_->loop().Post([this, id] {
          stop_programs_.erase(id);
          if (on_stop_withdrawn) on_stop_withdrawn(id);
        });
      });
  return machine;
}

bool SimRobot::StopStaysPublished(StopId id) const {
  const auto program = stop_programs_.find(id);
  return program != stop_programs_.end() && program->second->stays_published();
}

void SimRobot::EndStopPrograms() {
  for (const auto& [id, program] : std::exchange(stop_programs_, {})) {
    if (on_stop_withdrawn) on_stop_withdrawn(id);
  }
}

void SimRobot::SetBattery(int percent, bool charging) {
  battery_ = BatteryAt(percent, charging);
  PublishBody();
}

void SimRobot::GlitchBattery(int percent, bool charging) {
  OpenBody();
  PublishBattery(*battery_publisher_, BatteryAt(percent, charging));
}

void SimRobot::SetOtherBattery(std::optional<int> percent) {
  other_battery_.reset();
  if (percent) other_battery_ = BatteryAt(*percent, false);
  OpenBody();
}

std::optional<int> SimRobot::battery() const {
  return battery_ ? std::optional<int>(battery_->batt_soc) : std::nullopt;
}

void SimRobot::SetMotion(std::int32_t motion) {
  motion_.emplace();
  motion_->motion_id = motion;
  PublishBody();
}

void SimRobot::StartPermits(std::size_t host) {
  permits_ = std::make_unique<PermitConsole>(
      network_, hosts_, layout_.prefix + "console-" + std::to_string(++consoles_), host,
      config_.name_space, identity(), [this](Time stamp) {
        if (on_permit) on_permit(stamp);
      });
}

void SimRobot::EndPermits() {
  permits_.reset();
}

void SimRobot::StartClock() {
  clock_ = std::make_unique<WorldClock>(network_, [this](Time time) {
    if (on_clock) on_clock(time);
  });
}

void SimRobot::OpenBody() {
  const std::string prefix = config_.name_space.empty() ? "" : config_.name_space + "/";
  if (!body_timer_) {
    const BatteryPolicy battery;
    const LowPowerPolicy low_power;
    const PolicyConfig policy = config_.policy.value_or(PolicyConfig{});
    for (auto* publisher : {&battery_publisher_, &other_battery_publisher_}) {
      *publisher = transport::MakePublisher<msg::BmsStatus>(
                       *environment_, prefix + policy.battery.value_or(battery).topic)
                       .value();
    }
    motion_publisher_ = transport::MakePublisher<msg::MotionStatus>(
                            *environment_, prefix + policy.low_power.value_or(low_power).topic)
                            .value();
    const bool of_world = config_.clock == ClockSource::kTopic;
    body_timer_ = environment_->loop().Every(of_world ? kWorldBodyPeriod : kBodyPeriod,
                                             [this] { PublishBody(); });
  }
}

void SimRobot::PublishBattery(transport::Publisher<msg::BmsStatus>& publisher,
                              const msg::BmsStatus& status) {
  if (battery_silent_) return;
  if (on_battery) on_battery(status.batt_soc, status.power_wired_charging);
  static_cast<void>(publisher.Publish(status));
}

void SimRobot::PublishBody() {
  OpenBody();
  if (battery_) PublishBattery(*battery_publisher_, *battery_);
  if (other_battery_) PublishBattery(*other_battery_publisher_, *other_battery_);
  if (!motion_) return;
  if (on_motion) on_motion(motion_->motion_id);
  static_cast<void>(motion_publisher_->Publish(*motion_));
}

void SimRobot::ReleaseEmergencyStop() {
  SimulatedController* leading = leader();
  if (leading == nullptr || leading->frozen) return;
  leading->shell().ReleaseEmergencyStop("a person", [this, leading](const Result<>& released) {
    if (on_release_answered) on_release_answered(*leading, released);
  });
}

void SimRobot::Restart(const std::string& name) {
  SimulatedController* leading = leader();
  if (leading != nullptr && !leading->frozen) {
    leading->shell().Restart(name, "", [](const Result<>&) {});
  }
}

SimulatedController* SimRobot::leader() {
  const auto standing = [](const SimulatedController& controller) {
    const Machine& machine = controller.shell().machine();
    return std::pair(machine.phase != Phase::kStopped, machine.epoch);
  };
  SimulatedController* highest = nullptr;
  for (const auto& controller : controllers_) {
    if (!controller || !controller->leads()) continue;
    if (highest == nullptr || standing(*controller) > standing(*highest)) {
      highest = controller.get();
    }
  }
  return highest;
}

std::size_t SimRobot::leaders() const {
  return static_cast<std::size_t>(
      std::count_if(controllers_.begin(), controllers_.end(), [](const auto& controller) {
        return controller && controller->leads() &&
               controller->shell().machine().phase != Phase::kStopped;
      }));
}

std::vector<std::string> SimRobot::journal() const {
  std::vector<std::string> messages;
  for (const JournalRow& row : recording()) {
    if (const auto* entry = std::get_if<JournalEntry>(&row.item)) {
      messages.push_back(entry->message);
    }
  }
  return messages;
}

bool SimRobot::RunUntil(const std::function<bool()>& done, Duration limit) {
  return network_.RunUntil(done, network_.now() + limit);
}

std::optional<SwitchResult> SimRobot::Set(const State& target,
                                          const std::optional<std::string>& actuator,
                                          Duration limit) {
  auto* leading = leader();
  if (leading == nullptr) return std::nullopt;
  auto reply = std::make_shared<std::optional<SwitchResult>>();
  leading->shell().SetState(target, actuator,
                            [reply](const SwitchResult& result) { *reply = result; });
  RunUntil([&] { return reply->has_value(); }, limit);
  return *reply;
}

std::optional<ActuatorReport> SimRobot::ReportOf(const std::string& name) const {
  const ActuatorReport* report = processes_.ReportOf(name);
  return report == nullptr ? std::nullopt : std::optional(*report);
}

const ActuatorReport* SimRobot::ReportOf(ActuatorIndex actuator,
                                         const ActuatorReport& followed) const {
  const std::string& name = config_.actuators[actuator].name;
  for (std::size_t host = 0; host < hosts_.size(); ++host) {
    const ActuatorReport* report = processes_.ReportOf(name, host);
    if (report != nullptr && report->incarnation == followed.incarnation &&
        report->host == followed.host) {
      return report;
    }
  }
  return processes_.ReportOf(name);
}

}  // namespace musher::simulation
