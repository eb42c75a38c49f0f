#pragma once
// A version on its way to a robot: a folder with manifest.toml, manifest.sig and payload/, which
// has the files.

#include <string>

#include "musher/controller/ota/files.hpp"
#include "musher/controller/ota/manifest.hpp"

namespace musher::ota {

inline constexpr const char* kPayload = "payload";

// Makes a bundle in the folder `out`, which must not be there yet, of all files below `folder`. Of
// `manifest` everything but the files is to be filled in.
Result<Manifest> MakeBundle(Disk& disk, const std::string& folder, Manifest manifest,
                            std::string_view private_pem, const std::string& out,
                            const OnBytes& on_bytes);

// Reads all of a bundle: signature, manifest, every file.
Result<SignedManifest> CheckBundle(Disk& disk, const std::string& bundle,
                                   std::string_view public_pem, const OnBytes& on_bytes);

}  // namespace musher::ota
