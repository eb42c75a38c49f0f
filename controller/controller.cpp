#include "musher/controller/controller.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/end_controller.hpp"
#if MUSHER_HOSTS
#include "musher/controller/process/bus_systemd.hpp"
#include "musher/controller/process/host_units.hpp"
#include "musher/controller/process/own_systemd.hpp"
#endif
#include "musher/controller/process/network_namespace.hpp"
#include "musher/controller/storage/other_starts.hpp"
#include "musher/controller/storage/private_folder.hpp"
#include "musher/controller/storage/stored_power.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/step/emergency_stops.hpp"
#include "musher/transport/dds/settings.hpp"
#include "musher/transport/ros_environment.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// Discards entries, if there is no folder for a journal.
class NoJournal : public JournalSink {
 public:
  void Append(JournalItem) noexcept override {}
};

// The text of the config; empty if its file has changed or is too large for the journal.
std::string TextOf(const MachineConfig& config) {
  std::string text = ReadFile(config.file);
  const bool fits = static_cast<std::int64_t>(text.size()) < config.journal_size_bytes / 8;
  return fits && ConfigHash(text) == config.hash ? text : std::string();
}

std::int64_t WallNanoseconds() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

Error NoFolder() {
  return {kCodeFailed, "the controller has no folder"};
}

// An actuator that holds its name on this host has latched a status, which arrives soon.
constexpr Duration kStatusWithin = Milliseconds(1000);
constexpr Duration kStatusPollPeriod = Milliseconds(5);
constexpr Duration kStandbyPeriod = Milliseconds(100);
// The host of the controller that is gone may be off: nothing else is to wait for it longer than a
// login takes, such as the way down to the on_lost of what ran there.
constexpr Duration kReachOfStandby = Milliseconds(2500);
constexpr Duration kMajorityPeriod = Milliseconds(100);
// As often as the logs.
constexpr Duration kCheckFolderPeriod = Milliseconds(1000);

// A process that an earlier controller has started and the config does not list gets SIGKILL after
// this time.
constexpr Duration kUnlistedEndsWithin = Milliseconds(2000);

}  // namespace

Controller::Controller(transport::Node& node, int domain_id, const MachineConfig& config,
                       ControllerOptions options)
    : node_(node),
      domain_id_(domain_id),
      config_(config),
      options_(std::move(options)),
      disk_(node.loop()),
      processes_(node.loop(), disk_),
      process_probe_(node.loop(), processes_,
                     [this](const std::string& actuator) { return LockOf(actuator); }) {}

Controller::~Controller() = default;

Result<std::unique_ptr<Controller>> Controller::Make(transport::Node& node, int domain_id,
                                                     const MachineConfig& config,
                                                     ControllerOptions options) {
  std::unique_ptr<Controller> controller(
      new Controller(node, domain_id, config, std::move(options)));
  if (auto opened = controller->Open(); !opened) return opened.error();
  return controller;
}

Result<> Controller::Open() {
  if (auto once = RunsOnce(); !once) return once;
  if (auto opened = OpenStore(); !opened) return opened;
  // While it stands by, a client of this host speaks to the controller of the other one.
  if (!options_.standby) {
    if (auto taken = TakeName(); !taken) return taken;
  }
  if (store_) {
    JournalOptions options;
    options.max_bytes = config_.journal_size_bytes;
    options.on_moved = [this](const std::string& message) { Trouble(message); };
    options.on_writing = [this, alive = std::weak_ptr<bool>(alive_)](const Result<>& written) {
      node_.loop().Post([this, alive, written] {
        if (!alive.expired()) shell_->OnJournalWritten(written);
      });
    };
    auto journal = std::make_unique<Journal>(store_->JournalFile(), std::move(options));
    file_journal_ = journal.get();
    history_.emplace(node_.loop(), *journal);
    journal_ = std::move(journal);
    OpenLogs();
  } else {
    journal_ = std::make_unique<NoJournal>();
  }
  if (auto opened = OpenShell(); !opened) return opened;
  WatchNetwork();
  if (options_.standby) {
    auto standby = Standby::Make(node_, config_, [this] { return shell_->machine_identity(); });
    if (!standby) return standby.error();
    standby_ = std::move(standby).value();
    const auto reports = standby_->ReportHere(StandbyName(domain_id_, config_.name_space));
    if (!reports) {
      Trouble(reports.error().message +
              "; `musher status` of this host does not know of this standby");
    }
  }
  listen_for_others_ |= config_.transport == TransportProfile::kLan;
  const Duration listen = listen_for_others_ ? ListenTime(config_) : Duration{};
  // Not called directly: the hooks may use the controller, which its owner does not have yet.
  begin_later_ =
      node_.loop().At(node_.loop().Now() + listen, [this, listen] { BeginAfter(listen); });
  return Ok();
}

void Controller::WatchNetwork() {
  const auto profile = transport::dds::ChosenProfile(config_.transport);
  const char* uri = std::getenv("CYCLONEDDS_URI");
  const bool own_settings = uri != nullptr && transport::ReplacesProfile(config_.transport, uri);
  if (!profile || profile.value() != TransportProfile::kLan || own_settings) return;
  network_watch_ = transport::NetworkWatch::Make(
      node_.loop(), config_.interfaces, [this](const std::string& missed) {
        shell_->Remark(kCodeNetError,
                       missed +
                           " has come since this controller started, which does not use it: "
                           "other hosts do not reach it there. `musher up --detach "
                           "--takeover " +
                           config_.file +
                           "` replaces the controller, and no actuator is disturbed; `musher "
                           "doctor` names the actuators to restart");
      });
}

// On a slow link an actuator may have been discovered only now; its controller may follow.
void Controller::BeginAfter(Duration listen) {
  const auto first_status_at = shell_->peers().first_status_at();
  const bool settled = shell_->rival() || !first_status_at;
  const Time until = settled ? Time{} : *first_status_at + listen;
  const auto begin = [this] { BeginUnlessLed(); };
  if (node_.loop().Now() >= until) return begin();
  begin_later_ = node_.loop().At(until, begin);
}

// Whether this controller goes on standing by. One that leads after that goes on with what the
// controller before it has led, as after a takeover, and requests nothing.
bool Controller::StandBy() {
  if (!standby_) return false;
  const bool has_id = !shell_->machine_identity().id.empty();
  if (const std::string id = has_id ? "" : IdOfActuators(); !id.empty()) KeepIdentity(id);
  const std::string why = standby_->WhyNot();
  if (why.empty()) {
    led_before_ = standby_->last_status();
    standby_ = nullptr;
    if (auto taken = TakeName(); !taken) {
      shell_->Refuse(taken.error());
      return true;
    }
    WatchStopsHere();
    options_.takeover = options_.adopt = options_.restarted = options_.supervised = true;
    return false;
  }
  if (std::exchange(stood_by_for_, why) != why && options_.on_standby) options_.on_standby(why);
  begin_later_ = node_.loop().At(node_.loop().Now() + kStandbyPeriod, [this] { BeginUnlessLed(); });
  return true;
}

// A standby may lead what this controller does not reach.
void Controller::WatchMajority() {
  const std::string why = majority_.WhyRelease(config_, shell_->machine(), node_.loop().Now());
  if (why.empty()) return;
  majority_watch_ = nullptr;
  shell_->Remark(kCodeNetError, "this controller gives up the machine: " + why);
  shell_->ReleaseControl("the standby of another host, as far as this one can know", true);
}

// What runs here may belong to a controller of another host.
void Controller::BeginUnlessLed() {
  if (shell_->refused() || StandBy()) return;
  TakeIdOfActuators();
  if (const auto refusal = WhyNotBeside()) return shell_->Refuse(*refusal);
  if (!options_.before_begin) {
    CountHeld();
    return BeginOnceReceived(node_.loop().Now() + kStatusWithin);
  }
  options_.before_begin();
  CountHeld();
  // In a later turn: what was ended has left by then, or has sent its last.
  begin_later_ = node_.loop().At(node_.loop().Now(), [this] {
    shell_->ForgetEnded(RunsHere());
    BeginOnceReceived(node_.loop().Now() + kStatusWithin);  // the hook may have taken seconds
  });
}

// Why this controller must not begin beside a controller that leads a machine of the same name. As
// long as the id of this machine is not known, that controller may be of another robot, and a
// takeover would fence it.
std::optional<Error> Controller::WhyNotBeside() const {
  const auto& rival = shell_->rival();
  if (!rival) return std::nullopt;
  if (!store_ && !rival->here && shell_->machine_identity().id.empty()) {
    return Refused<Refusal::kIdNotKnown>(rival->process, config_.state_dir);
  }
  if (options_.takeover) return std::nullopt;
  // Without both ids only the names of the two machines can be compared.
  const bool may_be_another =
      !rival->here && (shell_->machine_identity().id.empty() || rival->machine.id.empty());
  return may_be_another ? Refused<Refusal::kNameLedElsewhere>(rival->process)
                        : Refused<Refusal::kAlreadyLed>(rival->process);
}

// An actuator runs here if a process holds its name, or has the pid of its status: it may run
// without the name.
ActuatorPeers::RunsHere Controller::RunsHere() const {
  return [this](const std::string& actuator, pid_t pid) {
    return NameLock::IsHeld(LockOf(actuator)) || (pid > 0 && StartTimeOf(pid));  // not a zombie
  };
}

void Controller::CountHeld() {
  held_ = 0;
  for (const ActuatorConfig& actuator : config_.actuators) {
    if (actuator.protocol != Protocol::kMusher) continue;
    held_ += NameLock::IsHeld(LockOf(actuator.name)) ? 1 : 0;
  }
}

// Waits for the statuses of running actuators: they contain the hash of their config.
void Controller::BeginOnceReceived(Time deadline) {
  if (shell_->refused()) return;  // meanwhile: another controller takes over
  const bool checks_configs = !options_.adopt && !options_.restarted;
  if (!checks_configs || shell_->peers().received_before_begin() >= held_ ||
      node_.loop().Now() >= deadline) {
    return Begin();
  }
  begin_later_ = node_.loop().At(node_.loop().Now() + kStatusPollPeriod,
                                 [this, deadline] { BeginOnceReceived(deadline); });
}

MachineOrigin Controller::Origin() const {
  const std::string& file = options_.started_from.empty() ? config_.file : options_.started_from;
  std::error_code error;
  const auto absolute = std::filesystem::absolute(file, error);
  return {config_.name, config_.name_space,
          domain_id_,   error ? file : absolute.lexically_normal().string(),
          "",           computer_};
}

// The processes of another namespace or domain do not find each other.
Result<> Controller::RunsOnce() const {
  const MachineOrigin machine = Origin();
  const auto other = FindOtherRun(machine, DefaultStateDirs(machine));
  if (!other) return Ok();
  return Error{kCodeTargetBusy, other->Text(machine)};
}

Result<> Controller::OpenStore() {
  auto store = TakeFromKilled([&] { return StateStore::Open(config_.state_dir, Origin()); },
                              [&] { return StateStore::OwnerOf(config_.state_dir); });
  if (!store && store.error().code == kCodePermissionDenied) return store.error();
  if (!store && store.error().code == kCodeTargetBusy && options_.takeover) {
    if (auto ended = EndOwner(); !ended) return ended;
    options_.adopt = true;  // its actuators belong to this machine
    store = StateStore::Open(config_.state_dir, Origin());
  }
  if (store) {
    if (auto reached = ReachesActuators(); !reached) return reached;
    store_ = std::make_shared<StateStore>(std::move(store).value());
    ShareStore();
    if (store_->copied_from()) Trouble(CopiedText());
  } else if (store.error().code == kCodeTargetBusy) {
    return Error{kCodeTargetBusy,
                 store.error().message + "; " + HowToReplaceOwnerOf(config_.state_dir)};
  } else {
    Trouble("no journal, nothing is saved: " + store.error().message);
  }
  last_config_hash_ = StateStore::ConfigHashIn(config_.state_dir);
  began_in_this_boot_ = StateStore::BeganInBootOf(config_.state_dir, HostId());
  return Ok();
}

// What this process does not reach keeps its controller.
Result<> Controller::EndOwner() {
  const pid_t owner = StateStore::OwnerOf(config_.state_dir);
  if (StateStore::IsOwner(config_.state_dir, owner) && !IsInOtherNetwork(owner)) {
    if (auto reached = CheckReached(node_, config_, owner); !reached) return reached;
  }
  return EndOwnerOf(config_.state_dir);
}

// The last controller of this folder ran in another network namespace, and its actuators run on
// there.
Result<> Controller::ReachesActuators() const {
  const auto beyond = StateStore::ChildrenInOtherNetworkIn(config_.state_dir, HostId());
  if (beyond.empty()) return Ok();
  return Error{kCodeTargetBusy,
               "actuators of this machine run in another network namespace, and a controller here "
               "would not reach them: " +
                   NamesOf(beyond) + "; as root, " +
                   InNetworkOf(beyond.front().pid, "musher up FILE") + " takes control of them"};
}

// A robot whose disk was copied, as with an image.
std::string Controller::CopiedText() const {
  return config_.state_dir + " was copied from another computer, whose machine has the id " +
         store_->copied_from()->substr(0, 8) + "; this machine has a new id, " +
         store_->machine_id().substr(0, 8);
}

// A robot that runs without readers is better than none.
void Controller::ShareStore() {
  if (config_.log_group.empty()) return;
  const std::string logs = config_.state_dir + "/logs";
  for (const std::string& folder : {config_.state_dir, logs}) {
    if (folder == logs && IsLink(logs)) continue;  // which no log follows
    if (const auto shared = ShareFolder(folder, config_.log_group); !shared) {
      Trouble("log_group: " + shared.error().message);
      return;
    }
  }
}

// One controller leads the actuators of a namespace, whatever its folder is.
Result<> Controller::TakeName() {
  const std::string name = LockOf("musher/controller");
  auto lock = TakeFromKilled([&] { return NameLock::Acquire(name); },
                             [&] { return NameLock::HolderOf(name).pid; });
  if (!lock && lock.error().code == kCodeTargetBusy) {
    const NameLock::Holder holder = NameLock::HolderOf(name);
    if (holder.trusted) {
      if (auto may = MayTakeOver(holder.pid); !may) return may;
    }
    if (!options_.takeover && holder.trusted) {
      return Refused<Refusal::kNameTaken>(holder.pid, NamespaceText(config_.name_space),
                                          HowToReplace(holder.pid));
    }
    if (!options_.takeover) {
      return Refused<Refusal::kNameHeld>(holder.Text(), NamespaceText(config_.name_space));
    }
    // A controller that we may not signal releases control when it receives a higher epoch.
    const auto is_it = [&] { return NameLock::CheckHolder(name, holder.pid); };
    // The list of processes of another user could name any process of the host.
    if (holder.trusted) {
      if (auto reached = CheckReached(node_, config_, holder.pid); !reached) return reached;
      taken_from_ = StateDirOfProcess(holder.pid);
    }
    listen_for_others_ = !holder.trusted || !EndController(holder.pid, is_it);
    options_.adopt |= !listen_for_others_;
    if (listen_for_others_) return Ok();
    lock = NameLock::Acquire(name);
  }
  if (!lock) return lock.error();
  name_.emplace(std::move(lock).value());
  return Ok();
}

// A controller only takes over from a controller of the same machine. The machine of a controller
// without a folder is unknown; it leads the same actuators.
Result<> Controller::MayTakeOver(pid_t controller) const {
  const auto theirs = OriginOfProcess(controller);
  if (!theirs || theirs->IsOf(Origin(), true)) return Ok();
  return Refused<Refusal::kLeadsOtherMachine>(controller, theirs->Text(), Origin().Text());
}

std::string Controller::LockOf(const std::string& actuator) const {
  return NameLock::NameOf(domain_id_, config_.name_space, actuator);
}

Result<> Controller::OpenShell() {
  ControllerShell::Dependencies dependencies;
  dependencies.node = &node_;
  dependencies.processes = &processes_;
  dependencies.process_probe = &process_probe_;
  if (auto opened = OpenHosts(); !opened) return opened;
  dependencies.hosts = hosts_.get();
  dependencies.own_units = hosts_ && config_.own_units;
  dependencies.host_environment = {{"ROS_DOMAIN_ID", std::to_string(domain_id_)}};
  dependencies.journal = journal_.get();
  AddSaves(dependencies);
  dependencies.child_mark = [this](const std::string& actuator) { return LockOf(actuator); };
  dependencies.output = [this](const std::string& name) {
    return logs_ ? logs_->Output(name) : nullptr;
  };
  for (const ControllerExtension& extension : options_.extensions) {
    dependencies.links.insert(extension.links.begin(), extension.links.end());
  }
  dependencies.wall_ns = WallNanoseconds;
  dependencies.rules = Rules();
  dependencies.config_text = TextOf(config_);
  dependencies.host = HostId();
  dependencies.host_name = HostName();
  dependencies.pid = getpid();
  dependencies.incarnation = incarnation_;
  if (store_) {
    dependencies.machine_id = store_->machine_id();
  } else if (const auto origin = LoadOrigin(config_.state_dir)) {
    const bool copied = IsOtherComputer(origin->computer, computer_);
    dependencies.machine_id = copied ? NewMachineId() : origin->id;
  }
  auto shell = ControllerShell::Make(std::move(dependencies), config_, ShellHooks());
  if (!shell) return shell.error();
  shell_ = std::move(shell).value();
  WatchStopsHere();
  return Ok();
}

void Controller::WatchStopsHere() {
  if (name_) stops_here_ = node_.loop().WhenReadable(name_->fd(), [this] { TakeStopsHere(); });
}

void Controller::GoOnWith(const msg::MachineStatus& status, event::Begin& begin) {
  GoOnFrom(config_, status, begin);
  if (!store_) return;
  disk_.Do(std::string(StoredName(Stored::kPolicy)),
           [store = store_, policy = begin.policy] { return store->SavePolicy(policy); });
}

// The systemds that run processes of this machine: of other hosts, and of this one.
Result<> Controller::OpenHosts() {
#if MUSHER_HOSTS
  if (config_.hosts.empty() && !config_.own_units) return Ok();
  HostUnits::Options options;
  if (options_.standby) options.reach_within = kReachOfStandby;
  if (config_.own_units) {
    const OwnSystemd own = FindOwnSystemd(transport::OwnEnvironment(), geteuid());
    if (!own.trouble.empty()) {
      return Error{kCodeFailed, "[controller] units = \"always\": " + own.trouble};
    }
    options.own = BySocket(node_.loop(), own.socket);
    options.own_unit = UnitOf(getpid());
  }
  hosts_ = std::make_unique<HostUnits>(
      node_.loop(), config_, [this] { return shell_->machine_identity(); }, BySsh(node_.loop()),
      std::move(options));
#endif
  return Ok();
}

// What has to survive this controller is written by the disk thread.
void Controller::AddSaves(ShellDependencies& dependencies) {
  using OnSaved = ShellDependencies::OnSaved;
  using Write = std::function<Result<>(StateStore&)>;
  const auto save = [this](Stored what, Write write, OnSaved done) {
    if (!store_) return done(NoFolder());
    disk_.Do(
        std::string(StoredName(what)),
        [store = store_, write = std::move(write)] { return write(*store); }, std::move(done));
  };
  dependencies.save_epoch = [save](Epoch epoch, OnSaved done) {
    save(
        Stored::kEpoch, [epoch](StateStore& store) { return store.SaveEpoch(epoch); },
        std::move(done));
  };
  dependencies.save_emergency_stops = [save](const StoredStops& stops, OnSaved done) {
    save(
        Stored::kEmergencyStops,
        [stops](StateStore& store) { return store.SaveEmergencyStops(stops); }, std::move(done));
  };
  dependencies.save_policy = [save](const StoredPolicy& policy, OnSaved done) {
    save(
        Stored::kPolicy, [policy](StateStore& store) { return store.SavePolicy(policy); },
        std::move(done));
  };
  dependencies.save_stop_intent = [save](bool intended, OnSaved done) {
    save(
        Stored::kStopIntent,
        [intended](StateStore& store) { return store.SaveStopIntent(intended); }, std::move(done));
  };
  dependencies.save_remote_actuators = [save](const std::vector<RemoteActuator>& actuators,
                                              OnSaved done) {
    save(
        Stored::kRemoteActuators,
        [actuators](StateStore& store) { return store.SaveRemoteActuators(actuators, HostId()); },
        std::move(done));
  };
  dependencies.save_actuators = [save](const std::vector<StoredActuator>& actuators, OnSaved done) {
    save(
        Stored::kActuators,
        [actuators](StateStore& store) { return store.SaveActuators(actuators, HostId()); },
        std::move(done));
  };
  if (store_) {
    dependencies.save_children = [this](const std::vector<ChildProcess>& children, OnSaved done) {
      const auto write = [store = store_, children] {
        return store->SaveChildren(children, HostId());
      };
      disk_.Do("processes", write, std::move(done));
    };
  }
}

ControllerShell::Hooks Controller::ShellHooks() {
  ControllerShell::Hooks hooks = options_.hooks;
  hooks.open_services = [this] { return OpenServices(); };
  hooks.holds_answers = [this] {
    return (services_ && services_->HoldsAnswers()) || (ros2_tools_ && ros2_tools_->Holds()) ||
           std::ranges::any_of(extensions_, [](const auto& one) { return one->HoldsAnswers(); });
  };
  hooks.close_services = [this] {
    ros2_tools_ = nullptr;
    extensions_.clear();
    services_ = nullptr;
    ros_nodes_ = nullptr;
  };
  hooks.on_record = [this](const action::Record& record) {
    for (const auto& extension : extensions_) extension->OnRecord(record);
    if (ros2_tools_) ros2_tools_->OnRecord(record);
    if (options_.hooks.on_record) options_.hooks.on_record(record);
  };
  return hooks;
}

// A command of this host hands its emergency stop over by the name of the controller: that takes no
// discovery, which a busy host delays by seconds.
void Controller::TakeStopsHere() {
  while (const auto message = name_->Receive()) {
    const msg::EmergencyStop stop = transport::DecodeStop(*message, WallNanoseconds());
    if (stop.engaged) shell_->OnStop(stop);
  }
}

Result<> Controller::OpenServices() {
  ReadHistory read_history;
  if (history_) {
    read_history = [this](std::int64_t since, std::size_t limit, OnHistory done) {
      history_->Read(since, limit, std::move(done));
    };
  }
  ros_nodes_ = std::make_unique<transport::RosNodes>(node_);
  auto services = ControllerServices::Make(node_, *shell_, std::move(read_history),
                                           MakeHostServer(), ros_nodes_.get());
  if (!services) return services.error();
  services_ = std::move(services).value();
  ros2_tools_ = std::make_unique<Ros2Tools>(node_, *shell_, *ros_nodes_, WallNanoseconds,
                                            ToString(incarnation_));
  return OpenExtensions();
}

// For the commands of this host. With credentials a call goes by DDS only, which knows what they
// permit.
std::unique_ptr<transport::HostServer> Controller::MakeHostServer() {
  if (!name_ || !config_.keys.empty()) return nullptr;
  auto here = transport::HostServer::Make(node_.loop(), LockOf("musher/calls"));
  if (here) return std::move(here).value();
  shell_->Remark(kCodeNetError, here.error().message +
                                    "; commands of this host reach this controller by DDS only");
  return nullptr;
}

Result<> Controller::OpenExtensions() {
  const auto save_text = [this](const std::string& name, const std::string& text) {
    if (!store_) return;
    disk_.Do(name, [store = store_, name, text] { return store->SaveText(name, text); });
  };
  bool served = false;
  for (const ControllerExtension& extension : options_.extensions) {
    if (!extension.open_services) continue;
    auto services = extension.open_services({node_, *shell_, save_text});
    if (!services) return services.error();
    if (!services.value()) continue;
    served |= extension.serves_manager;
    extensions_.push_back(std::move(services).value());
  }
  if (!config_.policy) return Ok();
  if (config_.policy->manager && !served) {
    Trouble(
        "[policy] manager has no effect: give the controller the extension that serves it, such "
        "as MachineController({cyberdog::Extension()})");
  }
  for (const std::string& key : config_.policy->unread_keys) {
    Trouble(key + " has no effect: no extension of this program reads it");
  }
  return Ok();
}

void Controller::Begin() {
  event::Begin begin;
  begin.by_hand = options_.by_hand;
  begin.epoch = LoadEpoch();
  TakeIdOfActuators();
  if (const auto refusal = WhyNotBeside()) return shell_->Refuse(*refusal);
  if (const auto& rival = shell_->rival()) begin.epoch = std::max(begin.epoch, rival->epoch);
  if (const std::string others = shell_->peers().RunningWithAnotherConfig(last_config_hash_);
      !others.empty() && !options_.adopt && !options_.restarted) {
    return shell_->Refuse(Refused<Refusal::kOtherConfigRuns>(others, config_.file));
  }
  TakeIdentity();
  if (store_) {
    disk_.Do("config",
             [store = store_, hash = config_.hash] { return store->SaveConfigHash(hash); });
    disk_.Do("boot", [store = store_] { return store->SaveBootOf(HostId()); });
  }
  const std::vector<ChildProcess> children = FindRunning(begin);
  begin.restarted = options_.restarted;
  begin.supervised = options_.supervised;
  begin.at_boot = options_.supervised && !options_.restarted && !began_in_this_boot_;
  begin.stops = LoadStops();
  const std::string no_power_off = WhyPowerForgottenIn(config_.state_dir);
  begin.policy = LoadPolicy();
  begin.stop_intent =
      store_ ? store_->LoadStopIntent() : StateStore::StopIntentIn(config_.state_dir);
  begin.remote = StateStore::RemoteActuatorsIn(LastFolder(), HostId());
  begin.actuators = LoadActuators();
  if (led_before_) GoOnWith(*led_before_, begin);
  shell_->Begin(std::move(begin), children);
  if (!no_power_off.empty()) shell_->Remark(kCodeStateInvalid, no_power_off);
  if (led_before_) {
    shell_->Remark(kCodeNetError, "this standby leads now: the controller of " +
                                      led_before_->machine + " (epoch " +
                                      std::to_string(led_before_->epoch) + ") is gone");
  }
  if (config_.failover) {
    majority_watch_ = node_.loop().Every(kMajorityPeriod, [this] { WatchMajority(); });
  }
  // The next controller of that folder would take them for processes that have ended unseen.
  if (!taken_from_.empty()) {
    disk_.Do("list of processes of the folder before",
             [folder = taken_from_] { return StateStore::ForgetChildren(folder); });
  }
  if (store_ && store_->copied_from()) shell_->Remark(kCodeOk, CopiedText());
  if (!store_) return shell_->OnJournalWritten(NoFolder());
  check_folder_ = node_.loop().Every(kCheckFolderPeriod, [this] { CheckFolder(); });
}

// The folder of the controller before this one: a takeover goes on from what is stored there.
const std::string& Controller::LastFolder() const {
  return taken_from_.empty() ? config_.state_dir : taken_from_;
}

// Where this machine may have its files when it is started otherwise.
std::vector<std::string> Controller::OtherFolders() const {
  const MachineOrigin machine = Origin();
  std::vector<std::string> folders = DefaultStateDirs(machine);
  for (std::string& folder : FoldersOfFile(machine, folders)) folders.push_back(std::move(folder));
  if (!taken_from_.empty()) folders.push_back(taken_from_);
  return folders;
}

// Includes the stops of the machine's other state folders: to start the machine in another way
// releases no stop and requests no state. In a folder that cannot be read a stop may be engaged.
// The machine's own folder is such a folder if it cannot be opened.
StoredStops Controller::LoadStops() {
  const std::string& own = config_.state_dir;
  StoredStops stops = store_ ? store_->LoadEmergencyStops() : OpenStopsIn(own);
  if (stops.led_elsewhere && options_.supervised) {
    Trouble(
        "a controller of another host has led this machine since this one: whether it has engaged "
        "an emergency stop is not known here, so a start at boot or after a crash waits for a "
        "request");
  }
  const MachineOrigin machine = Origin();
  std::vector<std::string> folders = OtherFolders();
  for (const StopsElsewhere& other : FindStopsElsewhere(own, machine, folders, stops)) {
    stops = Merge(stops, other.stops);
    const std::string what = other.stops.engaged.empty()
                                 ? "no state was requested since the last emergency stop in "
                                 : "an emergency stop is engaged in ";
    Trouble(what + other.state_dir +
            ", where this machine had its files when it was started otherwise; it holds");
  }
  if (!store_) folders.push_back(own);
  stops.unread = FindUnreadFolders(store_ ? own : "", machine, folders, stops.unread);
  for (const UnreadFolder& unread : stops.unread) {
    if (unread.answered) continue;
    Trouble("an emergency stop or a low battery may be recorded in " + unread.folder +
            ", where this machine may have its files: " + WhyUnread(unread));
  }
  return stops;
}

// The battery was as low as the lowest level in the machine's state folders. The machine's own
// folder takes a level of another folder over once, and stores it: samples may lift it later.
StoredPolicy Controller::LoadPolicy() {
  StoredPolicy policy = StateStore::PolicyIn(config_.state_dir);
  const bool forgets = !WhyPowerForgottenIn(config_.state_dir).empty();
  if (forgets && store_) {  // with the key of the policy's saves: see below
    disk_.Do(std::string(StoredName(Stored::kPolicy)),
             [store = store_, policy] { return store->SavePolicy(policy); });
  }
  if (!config_.policy || !config_.policy->battery) return policy;
  const auto taken = StateStore::LevelsTakenIn(config_.state_dir);
  std::vector<std::uint64_t> marks;
  bool is_new = false;
  for (const LevelElsewhere& other :
       FindLevelsElsewhere(config_.state_dir, Origin(), OtherFolders())) {
    marks.push_back(other.mark);
    if (std::ranges::count(taken, other.mark) != 0) continue;
    is_new = true;
    policy.level = std::max(policy.level, other.level);
    Trouble("the battery was low (" + std::string(LevelName(other.level)) + ") in " +
            other.state_dir + ", where this machine had its files when it was started otherwise");
  }
  if (!is_new || !store_) return policy;
  // With the key of the policy's saves: a retry of this one overwrites no newer one. Without its
  // marks the level is taken again at the next start.
  disk_.Do(std::string(StoredName(Stored::kPolicy)), [store = store_, policy, marks]() -> Result<> {
    if (auto saved = store->SavePolicy(policy); !saved) return saved;
    return store->SaveLevelsTaken(marks);
  });
  return policy;
}

// An actuator that only a person starts again stays down, also if the machine had another folder
// then. The machine's own folder takes the actuators of another folder over once.
std::vector<StoredActuator> Controller::LoadActuators() {
  std::vector<StoredActuator> actuators = StateStore::ActuatorsIn(LastFolder(), HostId());
  const auto taken = StateStore::ActuatorsTakenIn(config_.state_dir);
  std::vector<std::uint64_t> marks;
  bool is_new = false;
  for (const StayDownElsewhere& other :
       FindStayDownElsewhere(config_.state_dir, Origin(), OtherFolders())) {
    marks.push_back(other.mark);
    if (std::ranges::count(taken, other.mark) != 0) continue;
    is_new = true;
    std::vector<std::string> names;
    for (const StoredActuator& one : other.actuators) {
      names.push_back(one.name);
      const auto own = std::ranges::find(actuators, one.name, &StoredActuator::name);
      if (own == actuators.end()) {
        actuators.push_back(one);
      } else {
        own->stays_down = one.stays_down;
      }
    }
    Trouble("only a person starts " + Joined(names) + ", by " + other.state_dir +
            ", where this machine had its files when it was started otherwise");
  }
  if (!is_new || !store_) return actuators;
  disk_.Do(std::string(StoredName(Stored::kActuators)),
           [store = store_, actuators, marks]() -> Result<> {
             if (auto saved = store->SaveActuators(actuators, HostId()); !saved) return saved;
             return store->SaveActuatorsTaken(marks);
           });
  return actuators;
}

// The state folder may be removed under a running machine, or another volume mounted over it.
void Controller::CheckFolder() {
  const auto saved = std::make_shared<std::vector<std::string>>();
  disk_.Do(
      "state folder",
      [store = store_, saved]() -> Result<> {
        auto removed = store->SaveRemoved();
        if (!removed) return removed.error();
        *saved = std::move(removed).value();
        return Ok();
      },
      [this, saved](const Result<>& checked) {
        const std::string in = " in " + config_.state_dir;
        const bool known = std::exchange(folder_fails_, !checked);
        if (!checked && !known) {
          Trouble("files that were removed" + in +
                  " cannot be saved again: " + checked.error().message);
        } else if (checked && !saved->empty()) {
          Trouble(Joined(*saved) + in + " had been removed; saved again");
          shell_->Remark(kCodeFailed, Joined(*saved) + in +
                                          " had been removed, or another volume was mounted "
                                          "there; saved again");
        }
      });
}

// The machine id in the status of an actuator that runs already. An actuator that this host starts
// belongs here: on another host, a process of its name is of another machine. Without a state
// folder it is not known whether an actuator of another host is of this machine.
std::string Controller::IdOfActuators() const {
  for (const auto& [actuator, status] : shell_->peers().statuses_before_begin()) {
    const bool started_elsewhere = store_ && config_.actuators[actuator].command.empty();
    const bool belongs = status.host == HostId() || started_elsewhere;
    if (belongs && status.machine == config_.name && !status.machine_id.empty()) {
      return status.machine_id;
    }
  }
  return {};
}

// Without a state folder, the id of the actuators shows whether a controller of the same machine
// name is a rival.
void Controller::TakeIdOfActuators() {
  if (store_ || !shell_->machine_identity().id.empty()) return;
  shell_->SetMachineId(IdOfActuators());
}

// A machine has one id on all its hosts. A state folder without an id takes it from the replaced
// controller, or from an actuator. If the folder cannot be used and no id is found, this run gets a
// new id: with its name alone the controller would fence another robot of the same name.
void Controller::TakeIdentity() {
  if (!shell_->machine_identity().id.empty()) return;
  std::string id;
  if (const auto& rival = shell_->rival(); rival && (store_ || rival->here)) id = rival->machine.id;
  if (id.empty()) id = IdOfActuators();
  if (id.empty()) id = NewMachineId();
  KeepIdentity(id);
}

void Controller::KeepIdentity(const std::string& id) {
  shell_->SetMachineId(id);
  if (!store_) return;
  store_->SetMachineId(id);
  disk_.Do("machine", [store = store_] { return store->SaveMachineId(); });
}

Epoch Controller::LoadEpoch() {
  const auto epoch = StateStore::EpochIn(config_.state_dir);
  if (epoch) return epoch.value();
  Trouble(epoch.error().message);
  return 0;
}

// The robot runs without rules that cannot be read: they only report.
UserRules Controller::Rules() {
  UserRulesReading read = ReadRulesOf(config_);
  if (read.diagnostics.empty()) return std::move(read.rules);
  Trouble("the rules of [safety] are not checked: " + FormatDiagnostic(read.diagnostics.front()));
  return {};
}

void Controller::Trouble(const std::string& message) {
  if (options_.on_trouble) options_.on_trouble(message);
}

bool Controller::Flush(Duration timeout) {
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  const bool saved = disk_.Flush(timeout);
  const Duration left = deadline - std::chrono::steady_clock::now();
  return (file_journal_ == nullptr || file_journal_->Flush(std::max(left, Milliseconds(1)))) &&
         saved;
}

void Controller::OnceRecorded(std::function<void()> then) {
  static constexpr Duration kLongestWrite = Milliseconds(2000);
  if (file_journal_ == nullptr) return then();
  const auto write = [journal = file_journal_->access()]() -> Result<> {
    static_cast<void>(journal.Flush(kLongestWrite));
    return Ok();
  };
  disk_.Do("journal", write, [then = std::move(then)](const Result<>&) { then(); });
}

// --- the processes of the actuators that already run, and their logs ---

// Finds the actuators' processes that already run on this host, started by an earlier controller or
// by hand; returns those that a controller has started. Only trusted ones are watched and stopped
// with the machine.
std::vector<ChildProcess> Controller::FindRunning(event::Begin& begin) {
  std::vector<ChildProcess> stored;
  for (const std::string& folder : {config_.state_dir, taken_from_}) {
    if (folder.empty()) continue;
    const auto more = StateStore::LoadChildren(folder, HostId());
    stored.insert(stored.end(), more.begin(), more.end());
  }
  std::vector<MarkedActuator> marked;
  for (const ActuatorConfig& actuator : config_.actuators) {
    const std::string name = LockOf(actuator.name);
    begin.running.push_back(NameLock::IsHeld(name));
    begin.processes.push_back(0);
    const bool started_here = !actuator.command.empty() && actuator.host.empty();
    if (started_here) marked.push_back({actuator.name, name, begin.running.back()});
  }
  std::vector<ChildProcess> children = FindChildren(marked, stored);
  for (const ChildProcess& child : children) {
    const ActuatorIndex i = *config_.IndexOf(child.actuator);
    begin.running[i] = true;
    begin.processes[i] = child.pid;
  }
  for (const ActuatorIndex i : config_.actuators.Indices()) {
    if (begin.running[i] && begin.processes[i] == 0) begin.processes[i] = HolderOf(i);
  }
  begin.ended = PerActuator<bool>(begin.running.size(), false);
  for (const ChildProcess& child : stored) {
    const auto i = config_.IndexOf(child.actuator);
    const bool listed =
        i && !config_.actuators[*i].command.empty() && config_.actuators[*i].host.empty();
    if (listed) {
      begin.ended[*i] = !begin.running[*i];
    } else if (IsRunning(child)) {
      EndUnlisted(child);
    }
  }
  return children;
}

pid_t Controller::HolderOf(ActuatorIndex i) {
  const std::string& actuator = config_.actuators[i].name;
  const auto holder = NameLock::HolderOf(LockOf(actuator));
  if (holder.trusted) return holder.pid;
  // Its unit runs as that user, and finds it.
  if (config_.own_units && !config_.actuators[i].limits.user.empty()) return 0;
  shell_->Remark(kCodePermissionDenied,
                 holder.Text() + " holds the name of " + actuator +
                     " but belongs neither to root nor to user " + std::to_string(geteuid()) +
                     ": it is not watched or signalled, and " + actuator + " is not started");
  return 0;
}

// Stops a process that no controller controls any more. A process that holds its name is reported
// instead, see ActuatorPeers::RecordUnlisted.
void Controller::EndUnlisted(const ChildProcess& child) {
  if (NameLock::IsHeld(LockOf(child.actuator))) return;
  if (!processes_.Adopt(child.pid, child.start_time, nullptr)) return;
  shell_->Remark(kCodeStateInvalid, child.actuator + " (pid " + std::to_string(child.pid) +
                                        ") was started by an earlier controller, and " +
                                        config_.file + " does not start it: it is stopped");
  static_cast<void>(processes_.Signal(child.pid, SIGTERM).ok());
  kill_later_.push_back(node_.loop().At(node_.loop().Now() + kUnlistedEndsWithin, [this, child] {
    static_cast<void>(processes_.Signal(child.pid, SIGKILL).ok());
  }));
}

// Without a log the process is started anyway, and its output is lost.
void Controller::OpenLogs() {
  LogFilesOptions options;
  options.max_total_bytes = config_.logs_size_bytes;
  options.on_trouble = [this](const std::string& message) { Trouble(message); };
  const auto add = [&](const std::string& name, std::int64_t bytes) {
    options.logs.push_back({name, store_->LogFile(name), bytes});
  };
  for (const ActuatorConfig& actuator : config_.actuators) {
    const bool started_here = !actuator.command.empty() && actuator.host.empty();
    if (started_here) add(actuator.name, actuator.log_size_bytes);
  }
  if (config_.view) add("musher-view", config_.log_size_bytes);
  if (config_.policy) {
    const PowerPolicy& power = config_.policy->power;
    if (!power.off_command.empty()) add("power_off", config_.log_size_bytes);
    if (!power.reboot_command.empty()) add("reboot", config_.log_size_bytes);
  }
  options.logs.push_back({"the controller", ControllerLogFile(config_), config_.log_size_bytes,
                          /*open=*/false, LogMayBeLink(config_.log, config_.state_dir)});
  logs_ = std::make_unique<LogFiles>(node_.loop(), std::move(options));
}

}  // namespace musher
