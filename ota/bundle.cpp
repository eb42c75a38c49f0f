#include "musher/ota/bundle.hpp"

#include "musher/ota/fault.hpp"
#include "musher/ota/signature.hpp"

namespace musher::ota {
namespace {

constexpr unsigned kPermissions = 0777;

std::string PayloadOf(const std::string& bundle) {
  return bundle + "/" + kPayload;
}

Result<> ListFiles(Disk& disk, const std::string& folder, Manifest& manifest,
                   const OnBytes& on_bytes) {
  const auto paths = FilesBelow(disk, folder);
  if (!paths) return paths.error();
  for (const std::string& path : paths.value()) {
    if (const auto fault = PathFault(path))
      return FaultError(Fault::kBadPath, path + ": " + *fault);
    const auto info = disk.Look(folder + "/" + path);
    if (!info) return info.error();
    auto digest = DigestOf(disk, folder + "/" + path, on_bytes);
    if (!digest) return digest.error();
    manifest.files.push_back(
        {path, digest.value().size_bytes, digest.value().sha256, info.value().mode & kPermissions});
  }
  if (manifest.files.empty()) return FaultError(Fault::kMissing, folder + " has no files");
  return Ok();
}

}  // namespace

Result<Manifest> MakeBundle(Disk& disk, const std::string& folder, Manifest manifest,
                            std::string_view private_pem, const std::string& out,
                            const OnBytes& on_bytes) {
  const auto there = disk.Look(out);
  if (!there) return there.error();
  if (there.value().kind != Disk::Kind::kNothing) {
    return Error{kCodeParametersInvalid, out + " already exists"};
  }
  if (auto listed = ListFiles(disk, folder, manifest, on_bytes); !listed) return listed.error();
  const std::string text = FormatManifest(manifest);
  // Does not make a bundle that no robot would accept.
  if (const auto parsed = ParseManifest(text, kManifestFile); !parsed) return parsed.error();
  if (text.size() > kLargestManifest) {
    return FaultError(Fault::kBadManifest, "there are too many files for one manifest");
  }
  const auto signature = Sign(text, private_pem);
  if (!signature) return signature.error();
  const auto write = [&]() -> Result<> {
    if (auto made = disk.MakeFolder(out); !made) return made;
    if (auto made = disk.MakeFolder(PayloadOf(out)); !made) return made;
    if (auto copied = CopyFiles(disk, folder, PayloadOf(out), manifest, on_bytes); !copied) {
      return copied;
    }
    if (auto w = WriteAll(disk, out + "/" + kManifestFile, text, 0644); !w) return w;
    if (auto w = WriteAll(disk, out + "/" + kSignatureFile, signature.value(), 0644); !w) return w;
    if (auto synced = SyncTree(disk, out); !synced) return synced;
    return disk.Sync(FolderOf(out));
  };
  if (auto written = write(); !written) {
    [[maybe_unused]] const auto removed = RemoveAll(disk, out);
    return written.error();
  }
  return manifest;
}

Result<SignedManifest> CheckBundle(Disk& disk, const std::string& bundle,
                                   std::string_view public_pem, const OnBytes& on_bytes) {
  const auto info = disk.Look(bundle);
  if (!info) return info.error();
  if (info.value().kind != Disk::Kind::kFolder) {
    return FaultError(Fault::kMissing, bundle + " is not a bundle: it is not a folder");
  }
  auto manifest = ReadManifest(disk, bundle, public_pem);
  if (!manifest) return manifest.error();
  const Manifest& listed = manifest.value().manifest;
  if (auto good = CheckNothingElse(disk, PayloadOf(bundle), listed); !good) {
    return Error{good.error().code, bundle + ": " + good.error().message};
  }
  if (auto good = CheckFiles(disk, PayloadOf(bundle), listed, on_bytes); !good) {
    return Error{good.error().code, bundle + ": " + good.error().message};
  }
  return manifest;
}

}  // namespace musher::ota
