#include "musher/ota/root.hpp"

#include <filesystem>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/files.hpp"
#include "musher/ota/signature.hpp"

namespace musher::ota {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::size_t kLargestSmallFile = 64 << 10;  // bytes

}  // namespace

std::string FormatRootConfig(const RootConfig& config) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(config.trial).count();
  return "# What is fixed for this robot, whatever version runs on it.\n\n"
         "robot = \"" +
         config.robot +
         "\"  # its name; bundles for another robot are refused\n"
         "key = \"" +
         config.key +
         "\"  # public key (PEM) that verifies bundles, relative to this file\n"
         "config = \"" +
         config.config +
         "\"  # the state config, relative to a slot\n"
         "trial_s = " +
         std::to_string(seconds) +
         "  # s for a new version to come up; after that the robot rolls back\n";
}

Result<RootConfig> ParseRootConfig(std::string_view text, const std::string& file) {
  const auto document = config_toml::ParseDocument(text);
  Findings findings;
  RootConfig config;
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
  } else {
    TableReader root(std::get<Table>(document), {1, 1}, "", findings);
    root.Require("robot", "the robot's name");
    if (const auto robot = root.String("robot")) {
      config.robot = robot->text;
      if (!config_toml::IsName(robot->text)) {
        root.Fault(robot->at, "robot", "expected " + std::string(config_toml::kNameRule));
      }
    }
    if (const auto key = root.String("key")) config.key = key->text;
    if (const auto path = root.String("config")) {
      config.config = path->text;
      if (const auto wrong = PathFault(path->text)) root.Fault(path->at, "config", *wrong);
    }
    if (const auto trial = root.Integer("trial_s", 1, 86'400, "s")) {
      config.trial = std::chrono::seconds(*trial);
    }
    root.RefuseOthers();
  }
  if (!findings.HasErrors()) return config;
  std::string message;
  for (const Diagnostic& diagnostic : std::move(findings).Take(file, text)) {
    message += (message.empty() ? "" : "\n") + FormatDiagnostic(diagnostic);
  }
  return Error{kCodeParametersInvalid, message};
}

Result<Root> Root::Open(Disk& disk, const std::string& path) {
  Root root(disk, path);
  const std::string file = path + "/" + kRootFile;
  const auto text = ReadAll(disk, file, kLargestSmallFile);
  if (!text) {
    return Error{kCodeParametersInvalid, path + " is not an upgrade root: " + text.error().message +
                                             "; `musher ota init` makes one"};
  }
  auto config = ParseRootConfig(text.value(), file);
  if (!config) return config.error();
  root.config_ = std::move(config).value();
  const std::string key = std::filesystem::path(path) / root.config_.key;
  auto pem = ReadAll(disk, key, kLargestSmallFile);
  if (!pem) return Error{kCodeParametersInvalid, pem.error().message};
  if (const auto good = CheckPublicKey(pem.value()); !good) {
    return Error{kCodeParametersInvalid, key + " is " + good.error().message};
  }
  root.public_pem_ = std::move(pem).value();
  return root;
}

std::string Root::SlotFolder(Slot slot) const {
  return path_ + "/slots/" + std::string(SlotName(slot));
}

SlotContent Root::LookAtManifest(Slot slot) const {
  auto read = ReadManifest(*disk_, SlotFolder(slot), public_pem_);
  if (!read) return read.error();
  Manifest& manifest = read.value().manifest;
  if (manifest.robot != config_.robot) {
    return FaultError(Fault::kOtherRobot, "it is for robot " + manifest.robot);
  }
  return std::move(manifest.version);
}

SlotContent Root::Look(Slot slot) const {
  const auto read = ReadManifest(*disk_, SlotFolder(slot), public_pem_);
  if (!read) return read.error();
  const auto same = CheckFiles(*disk_, SlotFolder(slot), read.value().manifest, {});
  if (!same) return same.error();
  const auto clean = CheckPrograms(*disk_, SlotFolder(slot), read.value().manifest);
  if (!clean) return clean.error();
  return LookAtManifest(slot);
}

std::optional<SlotState> Root::LoadState() const {
  const auto text = ReadAll(*disk_, StateFile(), kLargestSmallFile);
  return text ? ParseState(text.value()) : std::nullopt;
}

Result<SlotState> Root::State() const {
  if (const auto state = LoadState()) return *state;
  const auto boot =
      DecideBoot(std::nullopt, CurrentSlot(), [this](Slot slot) { return Look(slot); });
  if (!boot) return boot.error();
  return boot.value().next;
}

Result<> Root::Change(const std::function<Result<SlotState>(const SlotState&)>& change) const {
  const auto lock = LockState();
  if (!lock) return lock.error();
  const auto state = State();
  if (!state) return state.error();
  const auto next = change(state.value());
  if (!next) return next.error();
  return SaveOrPutBack(state.value(), next.value());
}

Result<Boot> Root::Boot(std::optional<Slot> running, bool takes_trial) const {
  // Without the lock (read-only disk, or a stopped holder) the start continues.
  const auto lock = LockState();
  const auto look = [this](Slot slot) { return Look(slot); };
  const auto state = LoadState();
  auto due = state;
  if (due && takes_trial) due->started = false;
  auto boot = DecideBoot(due, CurrentSlot(), look, running);
  if (!boot) return boot.error();
  ReportUnfinished(boot.value());
  if (state != boot.value().next) {
    const auto saved =
        state ? SaveOrPutBack(*state, boot.value().next) : SaveState(boot.value().next);
    if (!saved && boot.value().on_trial_boot) {
      SlotState untried = *state;
      untried.on_trial_boot = false;
      auto confirmed = DecideBoot(untried, CurrentSlot(), look);
      if (!confirmed) return confirmed.error();
      confirmed.value().reason = boot.value().reason + ", but not now: " + saved.error().message;
      return confirmed;
    }
    if (!saved) boot.value().reason += "; this cannot be saved: " + saved.error().message;
  }
  // Only for people: the link is not used while there is a state.
  if (CurrentSlot() != boot.value().next.confirmed) {
    [[maybe_unused]] const auto pointed = PointTo(boot.value().next.confirmed);
  }
  return boot;
}

// Unless its installer is at work.
void Root::ReportUnfinished(ota::Boot& boot) const {
  std::string& version = boot.next.installing;
  if (version.empty() || !disk_->Take(InstallLock(), /*wait=*/false)) return;
  boot.reason += (boot.reason.empty() ? "" : "; ") + ("the upgrade to version " + version) +
                 " did not finish, `musher ota install` repeats it";
  version.clear();
}

Result<> Root::PostponeTrialBoot() const {
  return Change([](const SlotState& state) -> Result<SlotState> {
    SlotState next = state;
    next.started = false;
    return next;
  });
}

Result<> Root::EndTrialBoot(const std::string& version, const Result<>& outcome) const {
  auto changed = Change([&](const SlotState& state) -> Result<SlotState> {
    // A controller that was taken over meanwhile may have saved the same.
    const bool kept = state.last && state.last->kept && state.last->version == version;
    if (!state.on_trial_boot && kept && outcome) return state;
    if (!state.on_trial_boot) return Error{kCodeStateInvalid, "no trial boot is running"};
    return AfterTrialBoot(state, version, outcome);
  });
  if (!changed || !outcome) return changed;
  const auto state = LoadState();
  if (!state) return Ok();
  [[maybe_unused]] const auto pointed = PointTo(state->confirmed);
  return Ok();
}

Result<> Root::Begin(Slot slot) const {
  SlotState state;
  state.confirmed = slot;
  if (auto saved = SaveState(state); !saved) return saved;
  return PointTo(slot);
}

std::optional<Slot> Root::CurrentSlot() const {
  const auto target = disk_->ReadLink(CurrentLink());
  if (!target) return std::nullopt;
  return SlotOf(std::filesystem::path(target.value()).filename().string());
}

Result<> Root::SaveState(const SlotState& state) const {
  return Replace(*disk_, StateFile(), FormatState(state), 0644);
}

// A save may fail once the file has its new content, by an error of the folder's sync. A version
// whose change was reported as failed must not be started by it then. A trial boot that is given up
// or postponed stays so.
Result<> Root::SaveOrPutBack(const SlotState& former, const SlotState& next) const {
  const Result<> saved = SaveState(next);
  const bool gives_up = former.on_trial_boot && next.confirmed == former.confirmed &&
                        (!next.on_trial_boot || !next.started);
  const auto is_due = [this](const SlotState& state) {
    const auto now = LoadState();
    return now && now->confirmed == state.confirmed && now->on_trial_boot == state.on_trial_boot &&
           now->started == state.started;
  };
  if (saved || gives_up || is_due(former) || !is_due(next)) return saved;
  [[maybe_unused]] const auto put_back = SaveState(former);
  if (!is_due(next)) return saved;
  return Error{saved.error().code, saved.error().message +
                                       "; the change cannot be put back either: the next start "
                                       "acts as if it had succeeded"};
}

Result<> Root::PointTo(Slot slot) const {
  const std::string next = CurrentLink() + ".new";
  if (auto removed = RemoveAll(*disk_, next); !removed) return removed;
  const std::string target = "slots/" + std::string(SlotName(slot));
  if (auto made = disk_->MakeLink(target, next); !made) return made;
  if (auto renamed = disk_->Rename(next, CurrentLink()); !renamed) return renamed;
  return disk_->Sync(path_);
}

Result<std::unique_ptr<Disk::Lock>> Root::LockState() const {
  return disk_->Take(path_ + "/ota_state.lock", /*wait=*/true);
}

}  // namespace musher::ota
