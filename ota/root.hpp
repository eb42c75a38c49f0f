#pragma once
// An upgrade root: the folder of a robot's software that `musher ota` upgrades:
//
//   ota.toml        fixed settings of this robot: its name, the key of signatures (see below)
//   ota.pub         the public key
//   slots/a, b      one version each: its files, its manifest.toml and manifest.sig
//   ota_state       which slot is started (slots.hpp); only this file decides
//   current         a link to the confirmed slot, for people, and used if ota_state is lost
//   state           the controller's folder, unless the config sets another one
//   *.lock          install.lock: held by an installer; ota_state.lock: by a process that changes
//                   ota_state; run.lock: by the controller of a machine that was started from here,
//                   or by an installer while there is none
//
// `musher` itself is not in a slot: it chooses between them.
//
// Threads: one.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/base/time.hpp"
#include "musher/ota/manifest.hpp"
#include "musher/ota/slots.hpp"

namespace musher::ota {

inline constexpr const char* kRootFile = "ota.toml";

struct RootConfig {
  std::string robot;                           // name in accepted bundles
  std::string key = "ota.pub";                 // file of the public key, relative to the root
  std::string config = "robot.toml";           // the state config in a slot
  Duration trial = std::chrono::seconds(300);  // limit for a new version to come up

  friend bool operator==(const RootConfig&, const RootConfig&) = default;
};

// The text of an ota.toml, with every key explained.
std::string FormatRootConfig(const RootConfig& config);
Result<RootConfig> ParseRootConfig(std::string_view text, const std::string& file);

class Root {
 public:
  // `path`: absolute. The disk must outlive it. Fails if ota.toml or the key is wrong.
  static Result<Root> Open(Disk& disk, const std::string& path);

  Disk& disk() const { return *disk_; }
  const std::string& path() const { return path_; }
  const RootConfig& config() const { return config_; }
  const std::string& public_key() const { return public_pem_; }
  std::string SlotFolder(Slot slot) const;
  std::string ConfigFile(Slot slot) const { return SlotFolder(slot) + "/" + config_.config; }
  std::string InstallLock() const { return path_ + "/install.lock"; }
  std::string RunLock() const { return path_ + "/run.lock"; }

  // The version of a slot after a full check: all files compared with the manifest, and no other
  // programs.
  SlotContent Look(Slot slot) const;
  // The version in the slot's manifest, without a check of the files.
  SlotContent LookAtManifest(Slot slot) const;

  // The state on disk; nullopt: lost or damaged.
  std::optional<SlotState> LoadState() const;
  // The state on disk, or a reconstructed one if it is lost.
  Result<SlotState> State() const;
  // Replaces the state by the result of `change`, under the lock. After an Error no version is due
  // that was not due before, as far as the disk permits that.
  Result<> Change(const std::function<Result<SlotState>(const SlotState&)>& change) const;

  // Chooses which slot is started now, and saves that. Does not begin a trial boot that cannot be
  // saved. `running`: the slot whose actuators run, see DecideBoot(). `takes_trial`: a trial boot
  // that was started is that of a process which lives, and is taken over: it goes on.
  Result<ota::Boot> Boot(std::optional<Slot> running = std::nullopt,
                         bool takes_trial = false) const;
  // The trial boot of the last start was not begun: the next start begins it.
  Result<> PostponeTrialBoot() const;
  // Ends the running trial boot.
  Result<> EndTrialBoot(const std::string& version, const Result<>& outcome) const;
  // Initialises the state: the first version of a new root is in this slot.
  Result<> Begin(Slot slot) const;

 private:
  void ReportUnfinished(ota::Boot& boot) const;
  Root(Disk& disk, std::string path) : disk_(&disk), path_(std::move(path)) {}

  std::string StateFile() const { return path_ + "/ota_state"; }
  std::string CurrentLink() const { return path_ + "/current"; }
  std::optional<Slot> CurrentSlot() const;
  Result<> SaveState(const SlotState& state) const;
  Result<> SaveOrPutBack(const SlotState& former, const SlotState& next) const;
  Result<> PointTo(Slot slot) const;
  Result<std::unique_ptr<Disk::Lock>> LockState() const;

  Disk* disk_;
  std::string path_;
  RootConfig config_;
  std::string public_pem_;
};

}  // namespace musher::ota
