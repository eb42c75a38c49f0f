#pragma once
// A bundle: a version for a robot, as a folder with manifest.toml, manifest.sig and payload/, which
// contains the files.

#include <string>

#include "musher/ota/files.hpp"
#include "musher/ota/manifest.hpp"

namespace musher::ota {

inline constexpr const char* kPayload = "payload";

// Makes a bundle in the folder `out`, which must not exist, from all files below `folder`. The
// caller fills in `manifest` except its files.
Result<Manifest> MakeBundle(Disk& disk, const std::string& folder, Manifest manifest,
                            std::string_view private_pem, const std::string& out,
                            const OnBytes& on_bytes);

// Verifies a bundle: signature, manifest, every file.
Result<SignedManifest> CheckBundle(Disk& disk, const std::string& bundle,
                                   std::string_view public_pem, const OnBytes& on_bytes);

}  // namespace musher::ota
