#include "musher/ota/manifest.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <set>

#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/signature.hpp"

namespace musher::ota {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::size_t kMostFiles = 20'000;
constexpr std::size_t kLongestPath = 1024;  // characters
constexpr std::size_t kLongestName = 255;   // of a file or folder; limit of file systems
constexpr std::size_t kDigestDigits = 64;
constexpr unsigned kOwnerReads = 0400;

bool IsDigest(std::string_view text) {
  return text.size() == kDigestDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::optional<unsigned> Mode(std::string_view text) {
  const bool octal =
      text.size() == 3 && text.find_first_not_of("01234567") == std::string_view::npos;
  if (!octal) return std::nullopt;
  unsigned mode = 0;
  for (const char digit : text) mode = mode * 8 + static_cast<unsigned>(digit - '0');
  return (mode & kOwnerReads) != 0 ? std::optional(mode) : std::nullopt;
}

std::optional<Version> ReadVersion(TableReader& reader, std::string_view key) {
  const auto word = reader.String(key);
  if (!word) return std::nullopt;
  auto version = ParseVersion(word->text);
  if (!version) reader.Fault(word->at, key, "expected a version such as \"1.4.0\"");
  return version;
}

FileEntry ReadEntry(TableReader& reader) {
  FileEntry entry;
  reader.Require("path", "a path in the slot");
  reader.Require("size", "a number of bytes");
  reader.Require("sha256", "64 hexadecimal digits");
  reader.Require("mode", "permissions such as \"644\"");
  if (const auto path = reader.String("path")) {
    entry.path = path->text;
    if (const auto fault = PathFault(entry.path)) reader.Fault(path->at, "path", *fault);
  }
  if (const auto size = reader.Integer("size", 0, std::numeric_limits<std::int64_t>::max() >> 20)) {
    entry.size_bytes = static_cast<std::uint64_t>(*size);
  }
  if (const auto digest = reader.String("sha256")) {
    entry.sha256 = digest->text;
    if (!IsDigest(entry.sha256)) {
      reader.Fault(digest->at, "sha256", "expected 64 hexadecimal digits");
    }
  }
  if (const auto mode = reader.String("mode")) {
    const auto value = Mode(mode->text);
    if (!value) {
      reader.Fault(mode->at, "mode", "expected three octal digits with which its owner may read");
    }
    entry.mode = value.value_or(0);
  }
  reader.RefuseOthers();
  return entry;
}

// Reports a file that is listed twice, or whose path is also a folder.
std::optional<std::string> Collision(const std::vector<FileEntry>& files) {
  std::set<std::string_view> paths;
  for (const FileEntry& file : files) {
    if (!paths.insert(file.path).second) return file.path + " is listed twice";
  }
  for (const FileEntry& file : files) {
    for (std::size_t slash = file.path.find('/'); slash != std::string::npos;
         slash = file.path.find('/', slash + 1)) {
      const std::string_view folder = std::string_view(file.path).substr(0, slash);
      if (paths.contains(folder)) {
        return std::string(folder) + " is listed as a file, and as the folder of " + file.path;
      }
    }
  }
  return std::nullopt;
}

Manifest Read(TableReader& root, std::int64_t& format) {
  Manifest manifest;
  root.Require("format", "a number");
  format = root.Integer("format", 1, 1'000'000).value_or(kFormat);
  if (format != kFormat) return manifest;  // the rest is unknown
  root.Require("robot", "the robot's name");
  root.Require("version", "a version such as \"1.4.0\"");
  if (const auto robot = root.String("robot")) {
    manifest.robot = robot->text;
    if (!config_toml::IsName(robot->text)) {
      root.Fault(robot->at, "robot",
                 std::string("expected ") + std::string(config_toml::kNameRule));
    }
  }
  manifest.version = ReadVersion(root, "version").value_or(Version{});
  manifest.min_version = ReadVersion(root, "min_version");
  if (const auto created = root.String("created")) manifest.created = created->text;
  const auto tables = root.Tables("file");
  if (tables.empty()) root.Fault(root.At("file"), "file", "expected at least one file");
  if (tables.size() > kMostFiles) {
    root.Fault(root.At("file"), "file",
               "expected at most " + std::to_string(kMostFiles) + " files");
    return manifest;
  }
  return manifest;
}

Error First(Findings findings, const std::string& file, std::string_view text, bool paths) {
  const auto diagnostics = std::move(findings).Take(file, text);
  return FaultError(paths ? Fault::kBadPath : Fault::kBadManifest,
                    FormatDiagnostic(diagnostics.front()));
}

}  // namespace

std::uint64_t Manifest::SizeBytes() const {
  std::uint64_t size = 0;
  for (const FileEntry& file : files) size += file.size_bytes;
  return size;
}

std::string FormatManifest(const Manifest& manifest) {
  std::string text = "format = " + std::to_string(kFormat) +
                     "\nrobot = " + config_toml::Quote(manifest.robot) + "\nversion = \"" +
                     manifest.version.text + "\"\n";
  if (manifest.min_version) text += "min_version = \"" + manifest.min_version->text + "\"\n";
  text += "created = \"" + manifest.created + "\"\n";
  for (const FileEntry& file : manifest.files) {
    char mode[8];
    std::snprintf(mode, sizeof mode, "%03o", file.mode & 0777U);
    text += "\n[[file]]\npath = '" + file.path + "'\nsize = " + std::to_string(file.size_bytes) +
            "\nsha256 = \"" + file.sha256 + "\"\nmode = \"" + mode + "\"\n";
  }
  return text;
}

std::optional<std::string> PathFault(std::string_view path) {
  if (path.empty() || path.size() > kLongestPath) return "expected a path of 1 to 1024 characters";
  if (path.front() == '/') return "expected a path within the slot, found an absolute one";
  const auto odd = [](char c) {
    return static_cast<unsigned char>(c) < 0x20U || c == 0x7f || c == '\'' || c == '\\';
  };
  if (std::any_of(path.begin(), path.end(), odd)) {
    return "expected a path without control characters, quotation marks and '\\'";
  }
  if (path == kManifestFile || path == kSignatureFile) return "expected another name than musher's";
  while (true) {
    const std::string_view name = path.substr(0, path.find('/'));
    if (name == "..") return "expected a path within the slot, found one that leads out of it";
    if (name.empty() || name == "." || name.size() > kLongestName) {
      return "expected the names of folders and a file, separated by one '/'";
    }
    if (name.size() == path.size()) return std::nullopt;
    path.remove_prefix(name.size() + 1);
  }
}

Result<Manifest> ParseManifest(std::string_view text, const std::string& file) {
  const auto document = config_toml::ParseDocument(text);
  Findings findings;
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    findings.Error(fault->at, fault->message);
    return First(std::move(findings), file, text, false);
  }
  TableReader root(std::get<Table>(document), {1, 1}, "", findings);
  std::int64_t format = 0;
  Manifest manifest = Read(root, format);
  if (format != kFormat) {
    return FaultError(Fault::kUnknownFormat, file + " has format " + std::to_string(format) +
                                                 "; this musher supports " +
                                                 std::to_string(kFormat));
  }
  root.RefuseOthers();
  if (findings.HasErrors()) return First(std::move(findings), file, text, false);
  for (const config_toml::Value* value : root.Tables("file")) {
    TableReader reader(*value->As<Table>(), value->at, "file", findings);
    manifest.files.push_back(ReadEntry(reader));
    if (findings.HasErrors()) {
      const bool path = PathFault(manifest.files.back().path).has_value();
      return First(std::move(findings), file, text, path);
    }
  }
  if (const auto collision = Collision(manifest.files)) {
    return FaultError(Fault::kBadPath, file + ": " + *collision);
  }
  return manifest;
}

Result<SignedManifest> ReadManifest(Disk& disk, const std::string& folder,
                                    std::string_view public_pem) {
  const std::string file = folder + "/" + kManifestFile;
  auto text = ReadAll(disk, file, kLargestManifest);
  if (!text) {
    const bool missing = Is(text.error(), Fault::kMissing);
    return missing ? text.error() : FaultError(Fault::kBadManifest, text.error().message);
  }
  auto signature = ReadAll(disk, folder + "/" + kSignatureFile, 4096);
  if (!signature) {
    return FaultError(Fault::kUnsigned, "there is no signature: " + signature.error().message);
  }
  if (auto good = VerifySignature(text.value(), signature.value(), public_pem); !good) {
    return Error{good.error().code, folder + ": " + good.error().message};
  }
  auto manifest = ParseManifest(text.value(), file);
  if (!manifest) return manifest.error();
  return SignedManifest{std::move(manifest).value(), std::move(text).value(),
                        std::move(signature).value()};
}

}  // namespace musher::ota
