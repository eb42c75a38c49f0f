#include "musher/cli/deploy/host_slot.hpp"

#include "musher/ota/fault.hpp"

namespace musher::cli {
namespace {

using ota::Disk;
using ota::Slot;
using ota::SlotState;

constexpr std::size_t kLargestSentKey = 16 << 10;  // bytes

std::string NewRoot(const std::string& root) {
  return root + ".new";
}

Result<bool> HasPath(Disk& disk, const std::string& path) {
  const auto info = disk.Look(path);
  if (!info) return info.error();
  return info.value().kind != Disk::Kind::kNothing;
}

Result<> StageFirst(Disk& disk, const std::string& root, const std::string& bundle) {
  const auto info = disk.Look(root);
  if (!info) return info.error();
  if (info.value().kind != Disk::Kind::kNothing) {
    const auto names = disk.List(root);
    if (!names) return names.error();
    if (!names.value().empty()) {
      return Error{kCodeStateInvalid, root + " is not an upgrade root and not empty: move it away"};
    }
  }
  const auto key = ota::ReadAll(disk, IncomingFolder(root) + "/ota.pub", kLargestSentKey);
  if (!key) return key.error();
  if (auto removed = ota::RemoveAll(disk, NewRoot(root)); !removed) return removed;
  return ota::InitRoot(disk, NewRoot(root), bundle, key.value(), {}, {});
}

Result<> StageNext(Disk& disk, const std::string& path, const std::string& bundle,
                   ota::InstallOptions options) {
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  auto installation = ota::Installation::Begin(root.value(), bundle, options, std::nullopt);
  if (!installation) return installation.error();
  ota::Installation& steps = installation.value();
  if (auto r = steps.Check({}); !r) return r;
  if (auto r = steps.Prepare(); !r) return r;
  if (auto r = steps.Copy({}); !r) return r;
  return steps.CheckWritten({});
}

// The version that runs; nullopt: there is no root.
Result<std::optional<std::string>> PresentVersion(Disk& disk, const std::string& path) {
  const auto there = HasPath(disk, path + "/" + ota::kRootFile);
  if (!there) return there.error();
  if (!there.value()) return std::optional<std::string>();
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  const auto state = root.value().State();
  if (!state) return state.error();
  const auto version = root.value().LookAtManifest(state.value().confirmed);
  if (!version) return version.error();
  return std::optional(version.value().text);
}

Result<> SwitchToFirst(Disk& disk, const std::string& root) {
  if (auto renamed = disk.Rename(NewRoot(root), root); !renamed) return renamed;
  return disk.Sync(ota::FolderOf(root));
}

// The link is what the programs of a host are started by.
Result<> CheckLink(Disk& disk, const ota::Root& root) {
  const auto state = root.State();
  if (!state) return state.error();
  const std::string link = root.path() + "/current";
  const auto target = disk.ReadLink(link);
  if (!target) return target.error();
  if (target.value() == "slots/" + std::string(ota::SlotName(state.value().confirmed))) return Ok();
  return Error{kCodeFailed, link + " leads to " + target.value() + " still: it was not replaced"};
}

}  // namespace

std::string IncomingFolder(const std::string& root) {
  return root + ".incoming";
}

Result<> StageSlot(Disk& disk, const std::string& root, const std::string& version,
                   ota::InstallOptions options) {
  const std::string bundle = IncomingFolder(root) + "/bundle";
  const auto present = PresentVersion(disk, root);
  if (!present) return present.error();
  const auto staged =
      present.value() ? StageNext(disk, root, bundle, options) : StageFirst(disk, root, bundle);
  [[maybe_unused]] const auto removed = ota::RemoveAll(disk, IncomingFolder(root));
  if (!staged) return staged;
  const std::string where = present.value() ? root : NewRoot(root);
  const auto opened = ota::Root::Open(disk, where);
  if (!opened) return opened.error();
  const auto state = opened.value().State();
  if (!state) return state.error();
  const Slot confirmed = state.value().confirmed;
  const auto written =
      opened.value().LookAtManifest(present.value() ? ota::Other(confirmed) : confirmed);
  if (!written) return written.error();
  if (written.value().text == version) return Ok();
  return Error{kCodeFailed, "version " + written.value().text + " was sent, not " + version};
}

Result<> SwitchSlot(Disk& disk, const std::string& path, const std::string& version) {
  const auto present = PresentVersion(disk, path);
  if (!present) return present.error();
  if (present.value() == version) return Ok();
  if (!present.value()) return SwitchToFirst(disk, path);
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  const auto lock = disk.Take(root.value().InstallLock(), /*wait=*/false);
  if (!lock) return lock.error();
  auto marked = root.value().Change([&](const SlotState& state) -> Result<SlotState> {
    const auto staged = root.value().Look(ota::Other(state.confirmed));
    if (!staged) return staged.error();
    if (staged.value().text != version || state.installing != version) {
      return Error{kCodeTargetBusy, "version " + version +
                                        " is not staged any more: another "
                                        "installation was begun meanwhile"};
    }
    SlotState next = state;
    next.on_trial_boot = true;
    next.started = next.taking_down = false;
    next.installing.clear();
    return next;
  });
  if (!marked) return marked;
  if (auto ended = root.value().EndTrialBoot(version, Ok()); !ended) return ended;
  return CheckLink(disk, root.value());
}

Result<> UndoSlot(Disk& disk, const std::string& path, const std::string& version) {
  const auto present = PresentVersion(disk, path);
  if (!present) return present.error();
  if (present.value() != version) return Ok();
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  const auto state = root.value().State();
  if (!state) return state.error();
  const bool first = !root.value().LookAtManifest(ota::Other(state.value().confirmed));
  if (first) {
    if (auto removed = ota::RemoveAll(disk, NewRoot(path)); !removed) return removed;
    if (auto renamed = disk.Rename(path, NewRoot(path)); !renamed) return renamed;
    return disk.Sync(ota::FolderOf(path));
  }
  const auto previous = ota::MarkRollback(root.value(), std::nullopt);
  if (!previous) return previous.error();
  if (auto ended = root.value().EndTrialBoot(previous.value().text, Ok()); !ended) return ended;
  return CheckLink(disk, root.value());
}

}  // namespace musher::cli
