#pragma once
// A robot with upgrades on a simulated disk: bundles of some versions, and a root that has one.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "musher/ota/fault.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/signature.hpp"
#include "musher/test/ota/sim_disk.hpp"

namespace musher::ota::testing {

inline const KeyPair& TheKeys() {
  static const KeyPair keys = MakeKeyPair().value();
  return keys;
}

inline std::map<std::string, std::string> FilesOf(const std::string& version) {
  return {{"bin/legs", std::string(700, 'l') + version},
          {"bin/voice", std::string(300, 'v') + version},
          {"data/empty", ""},
          {"robot.toml", "# version " + version + "\n"}};
}

inline constexpr const char* kRoot = "/robot";

inline std::string BundleOf(const std::string& version) {
  return "/bundles/" + version;
}

inline Manifest ManifestOf(const std::string& version) {
  Manifest manifest;
  manifest.robot = "dog";
  manifest.version = ParseVersion(version).value();
  manifest.created = "2026-04-01T09:30:00Z";
  return manifest;
}

inline void MakeBundleOf(SimDisk& disk, const Manifest& manifest, const std::string& out) {
  const std::string folder = "/built/" + manifest.version.text;
  for (const auto& [path, content] : FilesOf(manifest.version.text)) {
    disk.Put(folder + "/" + path, content);
  }
  disk.Put("/bundles/.keep", "");
  const auto made = MakeBundle(disk, folder, manifest, TheKeys().private_pem, out, {});
  ASSERT_TRUE(made) << made.error().message;
}

// A disk with bundles of these versions, and the first of them installed.
inline std::unique_ptr<SimDisk> DiskWith(const std::vector<std::string>& versions) {
  auto disk = std::make_unique<SimDisk>();
  for (const std::string& version : versions) {
    MakeBundleOf(*disk, ManifestOf(version), BundleOf(version));
  }
  const auto made =
      InitRoot(*disk, kRoot, BundleOf(versions.front()), TheKeys().public_pem, {}, {});
  EXPECT_TRUE(made) << made.error().message;
  return disk;
}

inline Root OpenRoot(Disk& disk) {
  return Root::Open(disk, kRoot).value();
}

// All steps of an installation, as without a machine.
inline Result<> Install(Disk& disk, const std::string& bundle, InstallOptions options = {}) {
  const auto root = Root::Open(disk, kRoot);
  if (!root) return root.error();
  auto installation = Installation::Begin(root.value(), bundle, options, std::nullopt);
  if (!installation) return installation.error();
  Installation& steps = installation.value();
  if (auto r = steps.Check({}); !r) return r;
  if (auto r = steps.Prepare(); !r) return r;
  if (auto r = steps.Copy({}); !r) return r;
  if (auto r = steps.CheckWritten({}); !r) return r;
  return steps.MarkTrialBoot();
}

// Whether a slot has exactly the files of a version, checked without the code under test.
inline bool Holds(const SimDisk& disk, Slot slot, const std::string& version) {
  const std::string folder = std::string(kRoot) + "/slots/" + std::string(SlotName(slot));
  for (const auto& [path, content] : FilesOf(version)) {
    if (!disk.IsThere(folder + "/" + path) || disk.Content(folder + "/" + path) != content) {
      return false;
    }
  }
  return true;
}

}  // namespace musher::ota::testing
