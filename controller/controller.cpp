#include "musher/controller/controller.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "musher/controller/cyberdog/serial_number.hpp"
#include "musher/controller/end_controller.hpp"
#include "musher/lifecycle/config_toml.hpp"
#include "musher/transport/host.hpp"

namespace musher {
namespace {

// Where entries go when there is no folder for a journal.
class NoJournal : public JournalSink {
 public:
  void Append(JournalItem) noexcept override {}
};

// What the config was read from; empty when its file says something else by now, or is too large
// for the journal.
std::string TextOf(const MachineConfig& config) {
  std::ifstream file(config.file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(file), {});
  const bool fits = static_cast<std::int64_t>(text.size()) < config.journal_size_bytes / 8;
  return fits && ConfigHash(text) == config.hash ? text : std::string();
}

std::int64_t WallNanoseconds() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

// Long enough to hear a living controller of another host, which is discovered within 500 ms.
constexpr Duration kLookAround = Milliseconds(1000);
constexpr Duration kSecuredLookAround = Milliseconds(4000);
// An actuator that holds its name here has latched a status, and is heard soon.
constexpr Duration kHeardWithin = Milliseconds(1000);
constexpr Duration kHeardPeriod = Milliseconds(5);
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
  if (auto opened = OpenStore(); !opened) return opened;
  if (auto taken = TakeName(); !taken) return taken;
  if (store_) {
    JournalOptions options;
    options.max_bytes = config_.journal_size_bytes;
    options.on_trouble = [this](const std::string& message) { Trouble(message); };
    auto journal = std::make_unique<Journal>(store_->JournalFile(), std::move(options));
    file_journal_ = journal.get();
    history_.emplace(node_.loop(), *journal);
    journal_ = std::move(journal);
    OpenLogs();
  } else {
    journal_ = std::make_unique<NoJournal>();
  }
  if (auto opened = OpenShell(); !opened) return opened;
  for (const ActuatorConfig& actuator : config_.actuators) {
    if (actuator.protocol != Protocol::kMusher) continue;
    held_ += transport::NameLock::IsHeld(LockOf(actuator.name)) ? 1 : 0;
  }
  look_around_ |= config_.transport == TransportProfile::kLan;
  Duration listen{};
  if (look_around_) listen = config_.keys.empty() ? kLookAround : kSecuredLookAround;
  // Never from here: the hooks may use the controller, which its owner does not have yet.
  begin_later_ =
      node_.loop().At(node_.loop().Now() + listen, [this, listen] { BeginAfter(listen); });
  return Ok();
}

// On a slow link an actuator may have been heard only now; its controller is still to come.
void Controller::BeginAfter(Duration listen) {
  const auto first_heard = shell_->first_heard();
  const bool settled = shell_->rival() || !first_heard;
  const Time until = settled ? Time{} : *first_heard + listen;
  const auto begin = [this] { BeginOnceHeard(node_.loop().Now() + kHeardWithin); };
  if (node_.loop().Now() >= until) return begin();
  begin_later_ = node_.loop().At(until, begin);
}

// What an actuator runs with is in its status.
void Controller::BeginOnceHeard(Time deadline) {
  const bool judges = !options_.adopt && !options_.restarted;
  if (!judges || shell_->HeardBeforeBegin() >= held_ || node_.loop().Now() >= deadline) {
    return Begin();
  }
  begin_later_ = node_.loop().At(node_.loop().Now() + kHeardPeriod,
                                 [this, deadline] { BeginOnceHeard(deadline); });
}

MachineOrigin Controller::Origin() const {
  const std::string& file = options_.started_from.empty() ? config_.file : options_.started_from;
  std::error_code error;
  const auto absolute = std::filesystem::absolute(file, error);
  return {config_.name, config_.name_space, domain_id_,
          error ? file : absolute.lexically_normal().string()};
}

Result<> Controller::OpenStore() {
  auto store = StateStore::Open(config_.state_dir, Origin());
  if (!store && store.error().code == kCodePermissionDenied) return store.error();
  if (!store && store.error().code == kCodeTargetBusy && options_.takeover) {
    if (auto ended = EndOwnerOf(config_.state_dir); !ended) return ended;
    options_.adopt = true;  // what it led is this machine's
    store = StateStore::Open(config_.state_dir, Origin());
  }
  if (store) {
    led_with_ = store.value().LoadConfigHash();
    store_ = std::make_shared<StateStore>(std::move(store).value());
  } else if (store.error().code == kCodeTargetBusy) {
    return Error{kCodeTargetBusy,
                 store.error().message + "; `musher status` shows it, --takeover ends it"};
  } else {
    Trouble("no journal, no saved epoch: " + store.error().message);
  }
  return Ok();
}

// One controller leads the actuators of a namespace, whatever its folder is.
Result<> Controller::TakeName() {
  const std::string name = LockOf("musher/controller");
  auto lock = transport::NameLock::Acquire(name);
  if (!lock && lock.error().code == kCodeTargetBusy) {
    const transport::NameLock::Holder holder = transport::NameLock::HolderOf(name);
    const std::string leads =
        "the actuators of " + (config_.name_space.empty()
                                   ? std::string("the empty namespace")
                                   : "namespace '" + config_.name_space + "'");
    if (holder.trusted) {
      if (auto may = MayTakeOver(holder.pid); !may) return may;
    }
    if (!options_.takeover && holder.trusted) {
      return Error{kCodeTargetBusy, "a controller, process " + std::to_string(holder.pid) +
                                        ", leads " + leads +
                                        " already; `musher status` shows it, --takeover ends it"};
    }
    if (!options_.takeover) {
      return Error{kCodeTargetBusy,
                   holder.Text() + " holds the name of the controller of " + leads +
                       "; if it is one, `musher status` shows it; --takeover begins beside it"};
    }
    // One that is not ours to end lets go when it hears of a higher epoch.
    const auto is_it = [&] { return transport::NameLock::CheckHolder(name, holder.pid); };
    look_around_ = !holder.trusted || !EndController(holder.pid, is_it);
    options_.adopt |= !look_around_;
    if (look_around_) return Ok();
    lock = transport::NameLock::Acquire(name);
  }
  if (!lock) return lock.error();
  name_.emplace(std::move(lock).value());
  return Ok();
}

// Only the controller of this very machine is ended by another one. Of a controller without a
// folder that is not known; it leads the same actuators.
Result<> Controller::MayTakeOver(pid_t controller) const {
  const auto theirs = OriginOfProcess(controller);
  if (!theirs || theirs->IsOf(Origin(), true)) return Ok();
  return Error{kCodePermissionDenied,
               "process " + std::to_string(controller) + " leads another machine, " +
                   theirs->Text() + ", in the namespace and domain of this one, " +
                   Origin().Text() +
                   ": give one of them a `namespace` of its own in [controller], or another "
                   "domain (--domain)"};
}

std::string Controller::LockOf(const std::string& actuator) const {
  return transport::NameLock::NameOf(domain_id_, config_.name_space, actuator);
}

// Which actuators' processes run on this host already, left by an earlier controller or by hand.
// Only one that is to be trusted is watched and ended with the machine.
void Controller::FindRunning(event::Begin& begin) {
  for (const ActuatorConfig& actuator : config_.actuators) {
    const std::string name = LockOf(actuator.name);
    begin.running.push_back(transport::NameLock::IsHeld(name));
    const auto holder =
        begin.running.back() ? transport::NameLock::HolderOf(name) : transport::NameLock::Holder{};
    begin.processes.push_back(holder.trusted ? holder.pid : 0);
    if (!begin.running.back() || holder.trusted) continue;
    shell_->Remark(kCodePermissionDenied, holder.Text() + " holds the name of " + actuator.name +
                                              ", and is neither root's nor of user " +
                                              std::to_string(geteuid()) +
                                              ": it is not watched or signalled, and " +
                                              actuator.name + " is not started beside it");
  }
}

Result<> Controller::OpenShell() {
  ControllerShell::World world;
  world.node = &node_;
  world.processes = &processes_;
  world.process_probe = &process_probe_;
  world.journal = journal_.get();
  using OnSaved = ControllerShell::World::OnSaved;
  using Write = std::function<Result<>(StateStore&)>;
  const auto save = [this](Stored what, Write write, OnSaved done) {
    if (!store_) return done(Error{kCodeFailed, "the controller has no folder"});
    disk_.Do(
        std::string(StoredName(what)),
        [store = store_, write = std::move(write)] { return write(*store); }, std::move(done));
  };
  world.save_epoch = [save](std::uint64_t epoch, OnSaved done) {
    save(
        Stored::kEpoch, [epoch](StateStore& store) { return store.SaveEpoch(epoch); },
        std::move(done));
  };
  world.save_emergency_stops = [save](const StoredStops& stops, OnSaved done) {
    save(
        Stored::kEmergencyStops,
        [stops](StateStore& store) { return store.SaveEmergencyStops(stops); }, std::move(done));
  };
  world.save_policy = [save](const StoredPolicy& policy, OnSaved done) {
    save(
        Stored::kPolicy, [policy](StateStore& store) { return store.SavePolicy(policy); },
        std::move(done));
  };
  world.save_stop_intent = [save](bool intended, OnSaved done) {
    save(
        Stored::kStopIntent,
        [intended](StateStore& store) { return store.SaveStopIntent(intended); }, std::move(done));
  };
  world.output = [this](const std::string& name) { return logs_ ? logs_->Output(name) : nullptr; };
  world.wall_ns = WallNanoseconds;
  world.config_text = TextOf(config_);
  world.host = transport::HostId();
  world.pid = getpid();
  world.incarnation = incarnation_;
  ControllerShell::Hooks hooks = options_.hooks;
  hooks.open_services = [this] { return OpenServices(); };
  hooks.holds_answers = [this] {
    return (services_ && services_->HoldsAnswers()) || (ros2_tools_ && ros2_tools_->Holds());
  };
  hooks.close_services = [this] {
    ros2_tools_ = nullptr;
    manager_ = nullptr;
    services_ = nullptr;
  };
  hooks.on_record = [this](const action::Record& record) {
    if (manager_) manager_->OnRecord(record);
    if (ros2_tools_) ros2_tools_->OnRecord(record);
    if (options_.hooks.on_record) options_.hooks.on_record(record);
  };
  auto shell = ControllerShell::Make(std::move(world), config_, std::move(hooks));
  if (!shell) return shell.error();
  shell_ = std::move(shell).value();
  return Ok();
}

Result<> Controller::OpenServices() {
  ReadHistory read_history;
  if (history_) {
    read_history = [this](std::int64_t since, std::size_t limit, OnHistory done) {
      history_->Read(since, limit, std::move(done));
    };
  }
  auto services = ControllerServices::Make(node_, *shell_, std::move(read_history));
  if (!services) return services.error();
  services_ = std::move(services).value();
  cyberdog::Host host;
  host.serial_number = cyberdog::ReadSerialNumber();
  host.save_text = [this](const std::string& name, const std::string& text) {
    if (!store_) return;
    disk_.Do(name, [store = store_, name, text] { return store->SaveText(name, text); });
  };
  auto manager = cyberdog::Manager::Make(node_, *shell_, host);
  if (!manager) return manager.error();
  manager_ = std::move(manager).value();
  ros2_tools_ =
      std::make_unique<Ros2Tools>(node_, *shell_, WallNanoseconds, std::to_string(incarnation_));
  return Ok();
}

void Controller::Begin() {
  event::Begin begin;
  begin.by_hand = options_.by_hand || config_.ros2.started_by_manager;
  begin.epoch = LoadEpoch();
  if (const auto& rival = shell_->rival()) {
    if (!options_.takeover) {
      return shell_->Refuse({kCodeTargetBusy, "a controller leads this machine already: " +
                                                  rival->who + "; --takeover ends its leadership"});
    }
    if (rival->machine != config_.name) {
      return shell_->Refuse(
          {kCodePermissionDenied, rival->who + " leads another machine, " + rival->machine +
                                      ", in the namespace and domain of this one, " + config_.name +
                                      "; --takeover does not end it"});
    }
    begin.epoch = std::max(begin.epoch, rival->epoch);
  }
  if (const std::string others = shell_->RunningWithAnotherConfig(led_with_);
      !others.empty() && !options_.adopt && !options_.restarted) {
    return shell_->Refuse(
        {kCodeTargetBusy, others + " already, with another config than " + config_.file +
                              ": `musher down --without-controller` ends what runs, and `musher "
                              "up --adopt` takes it over all the same"});
  }
  if (store_) {
    disk_.Do("config",
             [store = store_, hash = config_.hash] { return store->SaveConfigHash(hash); });
  }
  FindRunning(begin);
  begin.restarted = options_.restarted;
  if (store_) {
    begin.stops = store_->LoadEmergencyStops();
    begin.policy = store_->LoadPolicy();
    begin.stop_intent = store_->LoadStopIntent();
  }
  shell_->Begin(std::move(begin));
}

std::uint64_t Controller::LoadEpoch() {
  if (!store_) return 0;
  const auto epoch = store_->LoadEpoch();
  if (epoch) return epoch.value();
  Trouble(epoch.error().message);
  return 0;
}

// Without a log its process is started all the same, and what it prints is lost.
void Controller::OpenLogs() {
  LogFilesOptions options;
  options.max_total_bytes = config_.logs_size_bytes;
  options.on_trouble = [this](const std::string& message) { Trouble(message); };
  const auto add = [&](const std::string& name, std::int64_t bytes) {
    options.logs.push_back({name, store_->LogFile(name), bytes});
  };
  for (const ActuatorConfig& actuator : config_.actuators) {
    if (!actuator.command.empty()) add(actuator.name, actuator.log_size_bytes);
  }
  if (config_.policy) {
    const PowerPolicy& power = config_.policy->power;
    if (!power.off_command.empty()) add("power_off", config_.log_size_bytes);
    if (!power.reboot_command.empty()) add("reboot", config_.log_size_bytes);
  }
  options.logs.push_back(
      {"the controller", ControllerLogFile(config_), config_.log_size_bytes, /*open=*/false});
  logs_ = std::make_unique<LogFiles>(node_.loop(), std::move(options));
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

}  // namespace musher
