#pragma once
// A new version into the slot that is not used. Each step leaves the robot with a version that
// starts; the one that changes which, MarkTrial(), is the replacement of one small file.
//
//   Check ─▶ (the machine to OTA) ─▶ Prepare ─▶ Copy ─▶ CheckWritten ─▶ MarkTrial ─▶ (restart)
//
// What fails before MarkTrial() has changed nothing that the robot starts from; but once Prepare()
// is done the version in the other slot is no more.
//
// Threads: one.

#include <memory>
#include <optional>
#include <string>

#include "musher/controller/ota/bundle.hpp"
#include "musher/controller/ota/root.hpp"

namespace musher::ota {

struct InstallOptions {
  bool allow_downgrade = false;
};

// Why a version may not follow the present one.
Result<> CheckVersion(const Manifest& manifest, const Version& present,
                      const InstallOptions& options);

class Installation {
 public:
  // Takes the lock of installers. `running`: the slot that a machine runs from now.
  static Result<Installation> Begin(const Root& root, std::string bundle, InstallOptions options,
                                    std::optional<Slot> running);

  // The bundle is whole, signed, for this robot, newer, and there is room for it.
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
  Slot slot_ = Slot::kB;
  Version present_;
  SignedManifest manifest_;
};

// The version that MarkRollback() would let be tried; fails where there is none. Changes nothing.
Result<Version> FindRollback(const Root& root, std::optional<Slot> running);

// Lets the other slot, which was confirmed once, be tried again. Gives its version.
Result<Version> MarkRollback(const Root& root, std::optional<Slot> running);

// A new root for the robot that the bundle is for, with the bundle as its first version.
Result<> InitRoot(Disk& disk, const std::string& path, const std::string& bundle,
                  const std::string& public_pem, RootConfig config, const OnBytes& on_bytes);

}  // namespace musher::ota
