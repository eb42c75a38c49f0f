#pragma once
// Installs a new version into the unused slot. After each step the robot has a version that starts;
// the step that changes which one, MarkTrialBoot(), atomically replaces one small file.
//
//   Check ─▶ (machine to OTA) ─▶ Prepare ─▶ Copy ─▶ CheckWritten ─▶ MarkTrialBoot ─▶ (restart)
//
// A failure before MarkTrialBoot() does not change what the robot starts; but Prepare() deletes the
// version in the other slot.
//
// Threads: one.

#include <memory>
#include <optional>
#include <string>

#include "musher/ota/bundle.hpp"
#include "musher/ota/root.hpp"

namespace musher::ota {

struct InstallOptions {
  bool allow_downgrade = false;
};

// Fails if this version may not replace the current one.
Result<> CheckVersion(const Manifest& manifest, const Version& present,
                      const InstallOptions& options);

class Installation {
 public:
  // Takes the install lock. `running`: the slot that a machine runs from now; nullopt: none does,
  // and the start of one waits for the end of this installation.
  static Result<Installation> Begin(const Root& root, std::string bundle, InstallOptions options,
                                    std::optional<Slot> running);

  // Checks that the bundle is complete, signed, for this robot and newer, and fits on the disk.
  Result<> Check(const OnBytes& on_bytes);
  Result<> Prepare();
  Result<> Copy(const OnBytes& on_bytes);
  Result<> CheckWritten(const OnBytes& on_bytes);
  Result<> MarkTrialBoot();

  Slot slot() const { return slot_; }
  const Version& present() const { return present_; }
  // After Check().
  const Manifest& manifest() const { return manifest_.manifest; }

 private:
  Installation(const Root& root, std::string bundle, InstallOptions options)
      : root_(&root), bundle_(std::move(bundle)), options_(options) {}
  Result<> CheckRoom() const;

  const Root* root_;
  std::string bundle_;
  InstallOptions options_;
  std::unique_ptr<Disk::Lock> lock_;
  std::unique_ptr<Disk::Lock> run_lock_;  // null if a machine runs
  Slot slot_ = Slot::kB;
  Version present_;
  SignedManifest manifest_;
};

// The version that MarkRollback() would mark; fails if there is none. Changes nothing.
Result<Version> FindRollback(const Root& root, std::optional<Slot> running);

// Marks the other slot, which was confirmed once, for a trial boot. Returns its version.
Result<Version> MarkRollback(const Root& root, std::optional<Slot> running);

// Makes a new upgrade root for the bundle's robot, with the bundle as its first version.
Result<> InitRoot(Disk& disk, const std::string& path, const std::string& bundle,
                  const std::string& public_pem, RootConfig config, const OnBytes& on_bytes);

}  // namespace musher::ota
