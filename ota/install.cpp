#include "musher/ota/install.hpp"

#include "musher/ota/fault.hpp"
#include "musher/ota/files.hpp"

namespace musher::ota {
namespace {

constexpr std::uint64_t kBlock = 4096;        // bytes that a file takes at least
constexpr std::uint64_t kReserve = 1U << 20;  // bytes, for folders and for ota_state itself

std::string Megabytes(std::uint64_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

std::uint64_t NeededBytes(const Manifest& manifest) {
  std::uint64_t bytes = kReserve;
  for (const FileEntry& file : manifest.files) bytes += file.size_bytes + kBlock;
  return bytes;
}

// The size of a folder, as far as it can be read.
std::uint64_t Taken(Disk& disk, const std::string& folder) {
  std::uint64_t bytes = 0;
  const auto files = FilesBelow(disk, folder);
  if (!files) return 0;
  for (const std::string& path : files.value()) {
    if (const auto info = disk.Look(folder + "/" + path)) bytes += info.value().size_bytes;
  }
  return bytes;
}

// Refuses a slot that is a link: it would redirect the files.
Result<> MakeEmptySlot(Disk& disk, const std::string& folder) {
  if (auto removed = RemoveAll(disk, folder); !removed) return removed;
  return disk.MakeFolder(folder);
}

Result<> FillSlot(const Root& root, Slot slot, const std::string& bundle,
                  const SignedManifest& manifest, const OnBytes& on_bytes) {
  Disk& disk = root.disk();
  const std::string folder = root.SlotFolder(slot);
  if (auto made = MakeEmptySlot(disk, folder); !made) return made;
  if (auto copied = CopyFiles(disk, bundle + "/" + kPayload, folder, manifest.manifest, on_bytes);
      !copied) {
    return copied;
  }
  if (auto w = WriteAll(disk, folder + "/" + kManifestFile, manifest.text, 0644); !w) return w;
  if (auto w = WriteAll(disk, folder + "/" + kSignatureFile, manifest.signature, 0644); !w) {
    return w;
  }
  if (auto synced = SyncTree(disk, folder); !synced) return synced;
  return disk.Sync(FolderOf(folder));
}

Result<> CheckState(const SlotState& state, std::optional<Slot> running) {
  if (!running) return Ok();
  if (state.on_trial_boot && state.started) {
    return Error{kCodeTargetBusy, "a trial boot is running; wait for its outcome"};
  }
  if (*running != state.confirmed) {
    return Error{kCodeTargetBusy,
                 "the machine runs from the slot that the installation would change; run `musher "
                 "down`, then try again"};
  }
  return Ok();
}

// Held by a change of a root from which no machine runs: none is started meanwhile. Null if one
// runs.
Result<std::unique_ptr<Disk::Lock>> KeepFromStarting(const Root& root,
                                                     std::optional<Slot> running) {
  if (running) return std::unique_ptr<Disk::Lock>();
  auto lock = root.disk().Take(root.RunLock(), /*wait=*/false);
  if (lock || lock.error().code != kCodeTargetBusy) return lock;
  return Error{kCodeTargetBusy, "a machine is being started from " + root.path() +
                                    "; try again once it runs: " + lock.error().message};
}

}  // namespace

Result<> CheckVersion(const Manifest& manifest, const Version& present,
                      const InstallOptions& options) {
  const auto order = Compare(manifest.version, present);
  const std::string both = "version " + manifest.version.text + ", the robot has " + present.text;
  if (std::is_eq(order)) return FaultError(Fault::kNotNewer, "it is the same version: " + both);
  if (std::is_lt(order) && !options.allow_downgrade) {
    return FaultError(Fault::kNotNewer, "it is older: " + both + "; --allow-downgrade accepts it");
  }
  if (manifest.min_version && std::is_lt(Compare(present, *manifest.min_version))) {
    return FaultError(Fault::kTooFar, "it can only upgrade version " + manifest.min_version->text +
                                          " or newer, the robot has " + present.text);
  }
  return Ok();
}

Result<Installation> Installation::Begin(const Root& root, std::string bundle,
                                         InstallOptions options, std::optional<Slot> running) {
  Installation installation(root, std::move(bundle), options);
  auto lock = root.disk().Take(root.InstallLock(), /*wait=*/false);
  if (!lock) {
    if (lock.error().code != kCodeTargetBusy) return lock.error();
    return Error{kCodeTargetBusy, "another installation is running: " + lock.error().message};
  }
  installation.lock_ = std::move(lock).value();
  auto stays_down = KeepFromStarting(root, running);
  if (!stays_down) return stays_down.error();
  installation.run_lock_ = std::move(stays_down).value();
  const auto state = root.State();
  if (!state) return state.error();
  if (auto good = CheckState(state.value(), running); !good) return good.error();
  installation.slot_ = Other(state.value().confirmed);
  const auto present = root.LookAtManifest(state.value().confirmed);
  if (!present) {
    return Error{present.error().code, "slot " + std::string(SlotName(state.value().confirmed)) +
                                           " is damaged: " + present.error().message};
  }
  installation.present_ = present.value();
  return installation;
}

Result<> Installation::Check(const OnBytes& on_bytes) {
  // The manifest first: the rest of a refused bundle need not be read.
  auto manifest = ReadManifest(root_->disk(), bundle_, root_->public_key());
  if (!manifest) return manifest.error();
  const Manifest& offered = manifest.value().manifest;
  if (offered.robot != root_->config().robot) {
    return FaultError(Fault::kOtherRobot,
                      "it is for robot " + offered.robot + ", not for " + root_->config().robot);
  }
  if (auto good = CheckVersion(offered, present_, options_); !good) return good;
  auto whole = CheckBundle(root_->disk(), bundle_, root_->public_key(), on_bytes);
  if (!whole) return whole.error();
  if (whole.value().text != manifest.value().text) {
    return FaultError(Fault::kAltered, bundle_ + " changes while it is read");
  }
  manifest_ = std::move(whole).value();
  return CheckRoom();
}

Result<> Installation::CheckRoom() const {
  const auto free = root_->disk().FreeBytes(root_->path() + "/slots");
  if (!free) return free.error();
  const std::uint64_t have = free.value() + Taken(root_->disk(), root_->SlotFolder(slot_));
  const std::uint64_t need = NeededBytes(manifest_.manifest);
  if (need <= have) return Ok();
  return FaultError(Fault::kNoSpace, "it needs " + Megabytes(need) + " in " + root_->path() +
                                         "/slots, there are " + Megabytes(have));
}

Result<> Installation::Prepare() {
  return root_->Change([this](const SlotState& state) -> Result<SlotState> {
    if (Other(state.confirmed) != slot_) {
      return Error{kCodeTargetBusy, "another process changed the slot state meanwhile; try again"};
    }
    SlotState next = state;
    next.on_trial_boot = next.started = next.other_good = next.taking_down = false;
    next.installing = manifest_.manifest.version.text;
    return next;
  });
}

Result<> Installation::Copy(const OnBytes& on_bytes) {
  return FillSlot(*root_, slot_, bundle_, manifest_, on_bytes);
}

Result<> Installation::CheckWritten(const OnBytes& on_bytes) {
  const std::string folder = root_->SlotFolder(slot_);
  const auto written = ReadManifest(root_->disk(), folder, root_->public_key());
  if (!written) return written.error();
  if (auto same = CheckFiles(root_->disk(), folder, written.value().manifest, on_bytes); !same) {
    return Error{same.error().code, "what was written cannot be read back from " + folder + ": " +
                                        same.error().message};
  }
  return Ok();
}

Result<> Installation::MarkTrialBoot() {
  return root_->Change([this](const SlotState& state) -> Result<SlotState> {
    if (Other(state.confirmed) != slot_) {
      return Error{kCodeTargetBusy, "another process changed the slot state meanwhile; try again"};
    }
    SlotState next = state;
    next.on_trial_boot = true;
    next.started = next.taking_down = false;
    next.installing.clear();
    return next;
  });
}

namespace {

// The version of the unconfirmed slot, if it may be trial-booted again.
Result<Version> RollbackTarget(const Root& root, const SlotState& state,
                               std::optional<Slot> running) {
  if (auto good = CheckState(state, running); !good) return good.error();
  const Slot other = Other(state.confirmed);
  if (!state.other_good) {
    return FaultError(Fault::kNoVersion, "no version to roll back to: slot " +
                                             std::string(SlotName(other)) +
                                             " has no version that was confirmed here");
  }
  return root.Look(other);
}

}  // namespace

Result<Version> FindRollback(const Root& root, std::optional<Slot> running) {
  const auto state = root.State();
  return state ? RollbackTarget(root, state.value(), running) : state.error();
}

Result<Version> MarkRollback(const Root& root, std::optional<Slot> running) {
  const auto lock = root.disk().Take(root.InstallLock(), /*wait=*/false);
  if (!lock) return lock.error();
  const auto stays_down = KeepFromStarting(root, running);
  if (!stays_down) return stays_down.error();
  std::optional<Version> version;
  const auto changed = root.Change([&](const SlotState& state) -> Result<SlotState> {
    auto content = RollbackTarget(root, state, running);
    if (!content) return content.error();
    version = std::move(content).value();
    SlotState next = state;
    next.on_trial_boot = true;
    next.started = next.taking_down = false;
    next.installing.clear();
    return next;
  });
  if (!changed) return changed.error();
  return *version;
}

Result<> InitRoot(Disk& disk, const std::string& path, const std::string& bundle,
                  const std::string& public_pem, RootConfig config, const OnBytes& on_bytes) {
  const auto there = disk.Look(path + "/ota_state");
  if (!there) return there.error();
  if (there.value().kind != Disk::Kind::kNothing) {
    return Error{kCodeStateInvalid,
                 path + " is already an upgrade root; `musher ota install` upgrades it"};
  }
  const auto manifest = CheckBundle(disk, bundle, public_pem, on_bytes);
  if (!manifest) return manifest.error();
  config.robot = manifest.value().manifest.robot;
  for (const std::string& folder : {path, path + "/slots"}) {
    if (auto made = disk.MakeFolder(folder); !made) return made;
  }
  if (auto w = Replace(disk, path + "/" + config.key, public_pem, 0644); !w) return w;
  if (auto w = Replace(disk, path + "/" + kRootFile, FormatRootConfig(config), 0644); !w) return w;
  const auto root = Root::Open(disk, path);
  if (!root) return root.error();
  if (auto filled = FillSlot(root.value(), Slot::kA, bundle, manifest.value(), on_bytes); !filled) {
    return filled;
  }
  if (auto made = MakeEmptySlot(disk, root.value().SlotFolder(Slot::kB)); !made) return made;
  if (const auto good = root.value().Look(Slot::kA); !good) return good.error();
  if (auto synced = disk.Sync(FolderOf(path)); !synced) return synced;
  return root.value().Begin(Slot::kA);
}

}  // namespace musher::ota
