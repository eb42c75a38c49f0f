#pragma once
// The folder that a robot's software lives in, when it is upgraded by `musher ota`:
//
//   ota.toml        what is fixed for this robot: its name, whose signature counts (see below)
//   ota.pub         the public key
//   slots/a, b      a version each: its files, its manifest.toml and manifest.sig
//   ota_state       which of them is started (slots.hpp); the one thing that decides
//   current         a link to the confirmed one, for people, and for the day ota_state is lost
//   state           the controller's folder, unless the config puts it elsewhere
//   *.lock          who works here: install.lock an installer, ota_state.lock whoever changes
//                   ota_state, run.lock the controller of a machine that was started from here
//
// `musher` itself is not in a slot: it is what chooses between them.
//
// Threads: one.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/controller/ota/manifest.hpp"
#include "musher/controller/ota/slots.hpp"
#include "musher/lifecycle/time.hpp"

namespace musher::ota {

inline constexpr const char* kRootFile = "ota.toml";

struct RootConfig {
  std::string robot;                           // whose bundles are taken
  std::string key = "ota.pub";                 // file of the public key, relative to the root
  std::string config = "robot.toml";           // the state config in a slot
  Duration trial = std::chrono::seconds(300);  // that a new version has to come up

  friend bool operator==(const RootConfig&, const RootConfig&) = default;
};

// The text of an ota.toml, with every key explained.
std::string FormatRootConfig(const RootConfig& config);
Result<RootConfig> ParseRootConfig(std::string_view text, const std::string& file);

class Root {
 public:
  // `path` absolute. The disk must outlive it. An Error says what is wrong with ota.toml or the
  // key.
  static Result<Root> Open(Disk& disk, const std::string& path);

  Disk& disk() const { return *disk_; }
  const std::string& path() const { return path_; }
  const RootConfig& config() const { return config_; }
  const std::string& public_key() const { return public_pem_; }
  std::string SlotFolder(Slot slot) const;
  std::string ConfigFile(Slot slot) const { return SlotFolder(slot) + "/" + config_.config; }
  std::string InstallLock() const { return path_ + "/install.lock"; }
  std::string RunLock() const { return path_ + "/run.lock"; }

  // All of a slot, read and compared with its manifest; and that it has no programs beside those.
  SlotContent Look(Slot slot) const;
  // The same without its files: what it says it is.
  SlotContent LookAtManifest(Slot slot) const;

  // What is on disk; nullopt: lost or damaged.
  std::optional<SlotState> LoadState() const;
  // What is on disk, or what is to be made of it when it is lost.
  Result<SlotState> State() const;
  // Replaces the state by what `change` makes of it, while nobody else does.
  Result<> Change(const std::function<Result<SlotState>(const SlotState&)>& change) const;

  // Chooses what is started now, and remembers that. A trial boot that cannot be remembered is not
  // begun.
  Result<ota::Boot> Boot() const;
  // The end of the trial boot under way.
  Result<> EndTrialBoot(const std::string& version, const Result<>& outcome) const;
  // The first version of a new root is in this slot.
  Result<> Begin(Slot slot) const;

 private:
  Root(Disk& disk, std::string path) : disk_(&disk), path_(std::move(path)) {}

  std::string StateFile() const { return path_ + "/ota_state"; }
  std::string CurrentLink() const { return path_ + "/current"; }
  std::optional<Slot> CurrentSlot() const;
  Result<> SaveState(const SlotState& state) const;
  Result<> PointTo(Slot slot) const;
  Result<std::unique_ptr<Disk::Lock>> LockState() const;

  Disk* disk_;
  std::string path_;
  RootConfig config_;
  std::string public_pem_;
};

}  // namespace musher::ota
