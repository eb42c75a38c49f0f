#include "musher/controller/controller.hpp"

#include <unistd.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <utility>

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

// Which actuators' processes run on this host already, left by an earlier controller or by hand.
std::vector<bool> FindRunning(const MachineConfig& config, int domain_id) {
  std::vector<bool> running;
  for (const ActuatorConfig& actuator : config.actuators) {
    running.push_back(transport::NameLock::IsHeld(
        transport::NameLock::NameOf(domain_id, config.name_space, actuator.name)));
  }
  return running;
}

}  // namespace

Controller::Controller(transport::Node& node, const MachineConfig& config,
                       ControllerOptions options)
    : node_(node), config_(config), options_(std::move(options)), processes_(node.loop()) {}

Controller::~Controller() = default;

Result<std::unique_ptr<Controller>> Controller::Make(transport::Node& node, int domain_id,
                                                     const MachineConfig& config,
                                                     ControllerOptions options) {
  std::unique_ptr<Controller> controller(new Controller(node, config, std::move(options)));
  if (auto opened = controller->Open(domain_id); !opened) return opened.error();
  return controller;
}

Result<> Controller::Open(int domain_id) {
  auto store = StateStore::Open(config_.state_dir, config_.name);
  if (store) {
    store_.emplace(std::move(store).value());
  } else if (store.error().code == kCodeTargetBusy) {
    return store.error();
  } else {
    Trouble("no journal, no saved epoch: " + store.error().message);
  }
  if (store_) {
    JournalOptions options;
    options.max_bytes = config_.journal_size_bytes;
    options.on_trouble = [this](const std::string& message) { Trouble(message); };
    auto journal = std::make_unique<Journal>(store_->JournalFile(), std::move(options));
    file_journal_ = journal.get();
    journal_ = std::move(journal);
  } else {
    journal_ = std::make_unique<NoJournal>();
  }
  ControllerShell::World world;
  world.node = &node_;
  world.processes = &processes_;
  world.journal = journal_.get();
  world.save_epoch = [this](std::uint64_t epoch) { SaveEpoch(epoch); };
  world.log_file = [this](const std::string& name) { return store_ ? store_->LogFile(name) : ""; };
  world.wall_ns = WallNanoseconds;
  world.config_text = TextOf(config_);
  world.host = transport::HostId();
  world.pid = getpid();
  auto shell = ControllerShell::Make(std::move(world), config_, options_.hooks);
  if (!shell) return shell.error();
  shell_ = std::move(shell).value();
  auto services =
      ControllerServices::Make(node_, *shell_, store_ ? store_->JournalFile() : std::string());
  if (!services) return services.error();
  services_ = std::move(services).value();
  shell_->Begin(options_.by_hand, LoadEpoch(), FindRunning(config_, domain_id));
  return Ok();
}

std::uint64_t Controller::LoadEpoch() {
  if (!store_) return 0;
  const auto epoch = store_->LoadEpoch();
  if (epoch) return epoch.value();
  Trouble(epoch.error().message);
  return 0;
}

void Controller::SaveEpoch(std::uint64_t epoch) {
  if (!store_) return;
  if (const auto saved = store_->SaveEpoch(epoch); !saved) Trouble(saved.error().message);
}

void Controller::Trouble(const std::string& message) {
  if (options_.on_trouble) options_.on_trouble(message);
}

void Controller::FlushJournal(Duration timeout) {
  if (file_journal_ != nullptr) file_journal_->Flush(timeout);
}

}  // namespace musher
