#pragma once
// The signed manifest of a version. manifest.toml lists its files,
//
//   format = 1
//   robot = "cyberdog"
//   version = "1.4.0"
//   min_version = "1.2.0"               # the oldest version it can upgrade; may be missing
//   created = "2026-04-01T09:30:00Z"
//   [[file]]
//   path = "bin/musher-motion-manager"  # in the slot
//   size = 1234567                      # bytes
//   sha256 = "9f86d0…"
//   mode = "755"
//
// and manifest.sig is the signature of exactly these bytes.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/ota/disk.hpp"
#include "musher/ota/version.hpp"

namespace musher::ota {

inline constexpr const char* kManifestFile = "manifest.toml";
inline constexpr const char* kSignatureFile = "manifest.sig";
inline constexpr int kFormat = 1;
inline constexpr std::size_t kLargestManifest = 4 << 20;  // bytes

struct FileEntry {
  std::string path;
  std::uint64_t size_bytes = 0;
  std::string sha256;
  unsigned mode = 0644;

  friend bool operator==(const FileEntry&, const FileEntry&) = default;
};

struct Manifest {
  std::string robot;
  Version version;
  std::optional<Version> min_version;
  std::string created;
  std::vector<FileEntry> files;

  std::uint64_t SizeBytes() const;
};

// A manifest with the signed bytes.
struct SignedManifest {
  Manifest manifest;
  std::string text;
  std::string signature;
};

std::string FormatManifest(const Manifest& manifest);

// `file` is its name in messages. Checks everything except the files themselves.
Result<Manifest> ParseManifest(std::string_view text, const std::string& file);

// Why `path` may not be a file of a version; nullopt: it may.
std::optional<std::string> PathFault(std::string_view path);

// The manifest of a bundle or of a slot. Verifies the signature before it parses anything.
Result<SignedManifest> ReadManifest(Disk& disk, const std::string& folder,
                                    std::string_view public_pem);

}  // namespace musher::ota
