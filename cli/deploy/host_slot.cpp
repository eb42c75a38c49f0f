#include "musher/cli/deploy/host_slot.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <vector>

#include "musher/base/words.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/signature.hpp"

namespace musher::cli {
namespace {

using ota::Disk;
using ota::Slot;
using ota::SlotState;

constexpr std::size_t kLargestSentKey = 16 << 10;  // bytes

std::string NewRoot(const std::string& root) {
  return root + ".new";
}

// A first version that was switched back: its processes may still run from it.
std::string UndoneRoot(const std::string& root) {
  return root + ".undone";
}

Result<bool> HasPath(Disk& disk, const std::string& path) {
  const auto info = disk.Look(path);
  if (!info) return info.error();
  return info.value().kind != Disk::Kind::kNothing;
}

// Whether the program or the working directory of a process is in this folder. Without root only
// the processes of its own user are seen.
Result<> CheckNoProcessFrom(const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  const std::string below = fs::weakly_canonical(folder, error).string() + "/";
  for (auto at = fs::directory_iterator("/proc", error); !error && at != fs::directory_iterator();
       at.increment(error)) {
    const std::string pid = at->path().filename().string();
    if (!std::all_of(pid.begin(), pid.end(), [](char c) { return c >= '0' && c <= '9'; })) continue;
    std::vector<fs::path> links = {at->path() / "exe", at->path() / "cwd"};
    std::error_code closed;  // a script is open while a shell executes it
    for (auto file = fs::directory_iterator(at->path() / "fd", closed);
         !closed && file != fs::directory_iterator(); file.increment(closed)) {
      links.push_back(file->path());
    }
    for (const fs::path& link : links) {
      std::error_code unseen;
      const std::string target = fs::read_symlink(link, unseen).string() + "/";
      if (unseen || !target.starts_with(below)) continue;
      std::string name;
      std::getline(std::ifstream(at->path() / "comm"), name);
      return Error{kCodeTargetBusy, "process " + pid + " (" + name + ") runs from " + folder +
                                        " still, which would be written over: `musher restart` "
                                        "its actuator first"};
    }
  }
  return Ok();
}

// The link is what the programs of a host are started by.
Result<> CheckLink(Disk& disk, const ota::Root& root) {
  const auto state = root.State();
  if (!state) return state.error();
  const std::string link = root.path() + "/current";
  const auto target = disk.ReadLink(link);
  if (!target) return target.error();
  const std::string right = "slots/" + std::string(ota::SlotName(state.value().confirmed));
  if (target.value() == right) return Ok();
  return Error{kCodeFailed, link + " leads to " + target.value() + " still: it was not replaced; " +
                                "run there: ln -sfn " + right + " " + ShellWord(link)};
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
  // Else the programs run from the slot that would be written.
  if (auto linked = CheckLink(disk, root.value()); !linked) return linked;
  auto installation = ota::Installation::Begin(root.value(), bundle, options, std::nullopt);
  if (!installation) return installation.error();
  ota::Installation& steps = installation.value();
  if (auto r = steps.Check({}); !r) return r;
  const std::string slot = root.value().SlotFolder(steps.slot());
  if (auto idle = CheckNoProcessFrom(slot); !idle) return idle;
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

Error NotStaged(const std::string& version) {
  return {
      kCodeTargetBusy,
      "version " + version +
          " is not staged any more: another installation was begun meanwhile, or it was undone"};
}

Result<> SwitchToFirst(Disk& disk, const std::string& root, const std::string& version) {
  const auto staged = PresentVersion(disk, NewRoot(root));
  if (!staged) return staged.error();
  if (staged.value() != version) return NotStaged(version);
  if (auto renamed = disk.Rename(NewRoot(root), root); !renamed) return renamed;
  return disk.Sync(ota::FolderOf(root));
}

Result<> PutAside(Disk& disk, const std::string& from, const std::string& root) {
  if (auto removed = ota::RemoveAll(disk, UndoneRoot(root)); !removed) return removed;
  if (auto renamed = disk.Rename(from, UndoneRoot(root)); !renamed) return renamed;
  return disk.Sync(ota::FolderOf(root));
}

// A switch that a lost connection has left behind does not find its version any more, and one that
// was cut in the middle leaves no trial boot of it. `other_runs`: another version than it runs.
Result<> Withdraw(const ota::Root& root, const std::string& version, bool other_runs) {
  const auto state = root.State();
  if (!state) return state.error();
  const auto other = root.LookAtManifest(ota::Other(state.value().confirmed));
  const bool tries =
      other_runs && state.value().on_trial_boot && other && other.value().text == version;
  if (state.value().installing != version && !tries) return Ok();
  return root.Change([&](const SlotState& now) -> Result<SlotState> {
    SlotState next = now;
    if (next.installing == version) next.installing.clear();
    if (tries) next.on_trial_boot = next.started = false;
    return next;
  });
}

Result<std::string> DigestOfSlot(const ota::Root& root, Slot slot) {
  const auto read = ota::ReadManifest(root.disk(), root.SlotFolder(slot), root.public_key());
  if (!read) return read.error();
  return ContentDigest(read.value().manifest);
}

// Where a slot has the version, whole: with its digest. Else nowhere.
PlacedVersion InSlot(const ota::Root& root, Slot slot, const std::string& version, Place place) {
  const auto named = root.LookAtManifest(slot);
  if (!named || named.value().text != version || !root.Look(slot)) return {};
  const auto digest = DigestOfSlot(root, slot);
  return digest ? PlacedVersion{place, digest.value()} : PlacedVersion{};
}

// Nothing else was ever in this root.
Result<bool> IsFirst(const ota::Root& root) {
  const auto state = root.State();
  if (!state) return state.error();
  const std::string other = root.SlotFolder(ota::Other(state.value().confirmed));
  const auto names = root.disk().List(other);
  if (!names) return names.error();
  return names.value().empty() && !state.value().last && state.value().installing.empty();
}

}  // namespace

std::string IncomingFolder(const std::string& root) {
  return root + ".incoming";
}

std::string ContentDigest(const ota::Manifest& manifest) {
  ota::Manifest content = manifest;
  content.created.clear();
  std::ranges::sort(content.files, {}, &ota::FileEntry::path);
  ota::Sha256 sha;
  sha.Add(ota::FormatManifest(content));
  return sha.Finish();
}

std::string FormatPlaced(const PlacedVersion& placed) {
  if (placed.place == Place::kNowhere) return "nowhere";
  return (placed.place == Place::kRuns ? "runs " : "staged ") + placed.digest;
}

PlacedVersion ParsePlaced(const std::string& line) {
  for (const Place place : {Place::kRuns, Place::kStaged}) {
    const std::string begin = FormatPlaced({place, ""});
    if (line.starts_with(begin)) return {place, line.substr(begin.size())};
  }
  return {};
}

Result<PlacedVersion> FindVersion(Disk& disk, const std::string& path, const std::string& version) {
  const auto present = PresentVersion(disk, path);
  if (!present) return present.error();
  const auto root = ota::Root::Open(disk, present.value() ? path : NewRoot(path));
  if (!root && !present.value()) return PlacedVersion();  // nothing whole was staged
  if (!root) return root.error();
  const auto state = root.value().State();
  if (!state) return state.error();
  const Slot confirmed = state.value().confirmed;
  if (!present.value()) return InSlot(root.value(), confirmed, version, Place::kStaged);
  if (present.value() == version) {
    if (const auto whole = root.value().Look(confirmed); !whole) return whole.error();
    const bool linked = CheckLink(disk, root.value()).ok();
    return InSlot(root.value(), confirmed, version, linked ? Place::kRuns : Place::kStaged);
  }
  if (state.value().installing != version) return PlacedVersion();
  return InSlot(root.value(), ota::Other(confirmed), version, Place::kStaged);
}

Result<> StageSlot(Disk& disk, const std::string& root, const std::string& version,
                   ota::InstallOptions options) {
  const std::string bundle = IncomingFolder(root) + "/bundle";
  const auto present = PresentVersion(disk, root);
  if (!present) return present.error();
  auto staged =
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
  if (!present.value()) return SwitchToFirst(disk, path, version);
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  if (present.value() == version) {
    // A switch that was cut before its last write left the link; CheckLink() says if it stays.
    if (!CheckLink(disk, root.value())) {
      [[maybe_unused]] const auto pointed = root.value().EndTrialBoot(version, Ok());
    }
    return CheckLink(disk, root.value());
  }
  const auto lock = disk.Take(root.value().InstallLock(), /*wait=*/false);
  if (!lock) return lock.error();
  auto marked = root.value().Change([&](const SlotState& state) -> Result<SlotState> {
    // Its files were read back when it was staged.
    const auto staged = root.value().LookAtManifest(ota::Other(state.confirmed));
    if (!staged) return staged.error();
    if (staged.value().text != version || state.installing != version) return NotStaged(version);
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
  auto present = PresentVersion(disk, path);
  if (!present) return present.error();
  if (!present.value()) {
    const auto staged = PresentVersion(disk, NewRoot(path));
    if (staged && staged.value() == version) {
      // It fails if a switch comes first: then the version is present.
      [[maybe_unused]] const auto aside = PutAside(disk, NewRoot(path), path);
    }
    present = PresentVersion(disk, path);
    if (!present) return present.error();
    if (!present.value()) return Ok();
  }
  const auto root = ota::Root::Open(disk, path);
  if (!root) return root.error();
  {
    const auto lock = disk.Take(root.value().InstallLock(), /*wait=*/true);
    if (!lock) return lock.error();
    // Now no switch is at work.
    present = PresentVersion(disk, path);
    if (!present) return present.error();
    if (present.value() == version) {
      const auto first = IsFirst(root.value());
      if (!first) return first.error();
      if (first.value()) return PutAside(disk, path, path);
    }
    if (auto withdrawn = Withdraw(root.value(), version, present.value() != version); !withdrawn)
      return withdrawn;
  }
  if (present.value() != version) return CheckLink(disk, root.value());
  const auto previous = ota::MarkRollback(root.value(), std::nullopt);
  if (!previous) return previous.error();
  if (auto ended = root.value().EndTrialBoot(previous.value().text, Ok()); !ended) return ended;
  return CheckLink(disk, root.value());
}

}  // namespace musher::cli
