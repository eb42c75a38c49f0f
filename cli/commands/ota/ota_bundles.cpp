// musher ota keygen|bundle|init|verify: the commands that work on files only.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <filesystem>
#include <functional>

#include "musher/base/date_text.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/ota/ota_commands.hpp"
#include "musher/cli/commands/ota/ota_progress.hpp"
#include "musher/cli/commands/ota/ota_root.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/signature.hpp"
#include "musher/wire/security/authority.hpp"

namespace musher::cli {
namespace {

struct OtaKeygenOptions {
  std::string name;  // of the two files, without .key and .pub
};

struct OtaBundleOptions {
  std::string folder;
  std::string version;
  std::string min_version;  // may be empty
  std::string robot;        // empty: the machine's name, from the config
  std::string config = "robot.toml";
  std::string key;  // file of the private key
  std::string out;
};

struct OtaInitOptions {
  std::string root;
  std::string bundle;
  std::string key;  // file of the public key
  std::string config = "robot.toml";
};

struct OtaVerifyOptions {
  std::string bundle;
  std::string root;  // empty: $MUSHER_OTA_ROOT, else that of the running machine
  std::string key;   // for a bundle without a root
};

namespace fs = std::filesystem;

constexpr std::size_t kLargestKey = 16 << 10;  // bytes
constexpr unsigned kOthers = 077;

std::string Absolute(const std::string& path) {
  return fs::absolute(path).lexically_normal();
}

// A public key may be readable by everyone: that it is the wrong one comes first.
Result<std::string> ReadPrivateKey(ota::Disk& disk, const std::string& file) {
  auto key = ota::ReadAll(disk, file, kLargestKey);
  if (!key) return key;
  if (ota::CheckPublicKey(key.value())) {
    return Error{kCodeParametersInvalid,
                 file + " is a public key; a bundle is signed with the private one"};
  }
  const auto info = disk.Look(file);
  if (info && (info.value().mode & kOthers) != 0) {
    return Error{kCodePermissionDenied,
                 file + ": the signing key is readable by others; restrict it: chmod 600 " +
                     ShellWord(file)};
  }
  return key;
}

Result<std::string> ReadPublicKey(ota::Disk& disk, const std::string& file) {
  auto key = ota::ReadAll(disk, file, kLargestKey);
  if (!key) return key;
  if (const auto good = ota::CheckPublicKey(key.value()); !good) {
    return Error{kCodeParametersInvalid, file + " is " + good.error().message};
  }
  return key;
}

std::string Now() {
  return FormatUtc(std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
}

// Whether the rules that the config names are in `folder`, without an error, or on the robot alone.
// Prints which.
bool CheckRulesOf(const MachineConfig& config, const std::string& folder, Console& console) {
  UserRules rules;
  if (config.rules_file.empty()) return true;
  if (!RulesBelow(config, folder).empty()) return LoadUserRules("", config, console, rules);
  console.PrintError(config.rules_file +
                     ", which [safety] rules names, is not in the bundle: it is not below " +
                     folder + "; put it beside the config, or on the robot");
  return true;
}

// Makes the manifest from the options; nullopt: the error is already printed.
std::optional<ota::Manifest> ManifestFor(const OtaBundleOptions& options, Console& console) {
  ota::Manifest manifest;
  const auto read = [&](const std::string& text, const char* option) {
    auto version = ota::ParseVersion(text);
    if (!version) {
      console.Fail({kCodeParametersInvalid,
                    fmt::format("{} '{}' is not MAJOR.MINOR.PATCH, as in 1.4.0", option, text)});
    }
    return version;
  };
  const auto version = read(options.version, "--version");
  if (!version) return std::nullopt;
  manifest.version = *version;
  if (!options.min_version.empty()) {
    manifest.min_version = read(options.min_version, "--min-version");
    if (!manifest.min_version) return std::nullopt;
  }
  const auto config = LoadConfig(options.folder + "/" + options.config, console);
  if (!config) return std::nullopt;
  if (const auto fault = UpgradeFault(*config)) {
    console.Fail({kCodeParametersInvalid, *fault});
    return std::nullopt;
  }
  if (!CheckRulesOf(*config, options.folder, console)) return std::nullopt;
  manifest.robot = options.robot.empty() ? config->name : options.robot;
  manifest.created = Now();
  return manifest;
}

// Runs `work` and shows its progress on a terminal.
template <class T>
Result<T> Show(Console& console, const std::string& step,
               const std::function<Result<T>(const ota::OnBytes&)>& work) {
  OtaProgress progress(console);
  progress.Begin(step);
  return work([&](std::uint64_t bytes) {
    progress.Add(bytes);
    return true;
  });
}

ExitCode DoneWith(Console& console, const ota::Manifest& manifest, const std::string& where,
                  const std::string& text) {
  console.Print(console.mode().json ? OtaBundleJson(manifest, where) : text);
  return ExitCode::kDone;
}

std::string Size(const ota::Manifest& manifest) {
  const auto bytes = static_cast<double>(manifest.SizeBytes());
  const std::size_t files = manifest.files.size();
  return fmt::format("{} file{}, ", files, files == 1 ? "" : "s") +
         (bytes < 1e3   ? fmt::format("{} bytes", manifest.SizeBytes())
          : bytes < 1e6 ? fmt::format("{:.1f} kB", bytes / 1e3)
          : bytes < 1e9 ? fmt::format("{:.1f} MB", bytes / 1e6)
                        : fmt::format("{:.1f} GB", bytes / 1e9));
}

ExitCode OtaKeygen(const OtaKeygenOptions& options, const GlobalOptions& /*global*/,
                   Console& console) {
  ota::PosixDisk disk;
  const std::string secret = options.name + ".key";
  const std::string open = options.name + ".pub";
  for (const std::string& file : {secret, open}) {
    const auto existing = disk.Look(file);
    if (!existing || existing.value().kind == ota::Disk::Kind::kNothing) continue;
    return console.Fail({kCodeParametersInvalid, file + " already exists"});
  }
  const auto keys = ota::MakeKeyPair();
  if (!keys) return console.Fail(keys.error());
  if (auto w = ota::Replace(disk, secret, keys.value().private_pem, 0600); !w) {
    return console.Fail(w.error());
  }
  if (auto w = ota::Replace(disk, open, keys.value().public_pem, 0644); !w) {
    return console.Fail(w.error());
  }
  console.Print(console.mode().json
                    ? OtaKeysJson(secret, open)
                    : fmt::format("{} signs bundles: keep it off the robots, its owner can upgrade "
                                  "every one of them.\n{} goes to the robots.",
                                  secret, open));
  return ExitCode::kDone;
}

ExitCode OtaBundle(const OtaBundleOptions& options, const GlobalOptions& /*global*/,
                   Console& console) {
  ota::PosixDisk disk;
  const auto manifest = ManifestFor(options, console);
  if (!manifest) return ExitCode::kUsage;
  const auto key = ReadPrivateKey(disk, options.key);
  if (!key) return console.Fail(key.error());
  const auto made = Show<ota::Manifest>(console, "bundle", [&](const ota::OnBytes& on_bytes) {
    return ota::MakeBundle(disk, options.folder, *manifest, key.value(), options.out, on_bytes);
  });
  if (!made) return console.Fail(made.error());
  return DoneWith(console, made.value(), options.out,
                  fmt::format("{}: version {} for {}, {}", options.out, made.value().version.text,
                              made.value().robot, Size(made.value())));
}

ExitCode OtaInit(const OtaInitOptions& options, const GlobalOptions& /*global*/, Console& console) {
  ota::PosixDisk disk;
  const auto key = ReadPublicKey(disk, options.key);
  if (!key) return console.Fail(key.error());
  const std::string root = Absolute(options.root);
  ota::RootConfig config;
  config.config = options.config;
  const auto made = Show<void>(console, "init", [&](const ota::OnBytes& on_bytes) {
    return ota::InitRoot(disk, root, options.bundle, key.value(), config, on_bytes);
  });
  if (!made) return console.Fail({ExitCode::kNotDone, made.error()});
  const auto manifest = ota::ReadManifest(disk, root + "/slots/a", key.value());
  if (!manifest) return console.Fail({ExitCode::kNotDone, manifest.error()});
  const ota::Manifest& first = manifest.value().manifest;
  return DoneWith(console, first, root,
                  fmt::format("{}: version {} of {}; start it with: musher up {}", root,
                              first.version.text, first.robot, root));
}

ExitCode OtaVerify(const OtaVerifyOptions& options, const GlobalOptions& global, Console& console) {
  ota::PosixDisk disk;
  std::optional<ota::Root> root;
  std::string key_file = options.key;
  if (key_file.empty()) {
    const auto path = FindRoot(options.root, global);
    if (!path) return console.Fail({path.error().code, path.error().message + "; or --key FILE"});
    auto opened = ota::Root::Open(disk, path.value());
    if (!opened) return console.Fail(opened.error());
    root.emplace(std::move(opened).value());
  }
  const auto key =
      root ? Result<std::string>(root->public_key()) : ota::ReadAll(disk, key_file, kLargestKey);
  if (!key) return console.Fail(key.error());
  const auto read = Show<ota::SignedManifest>(console, "check", [&](const ota::OnBytes& on_bytes) {
    return ota::CheckBundle(disk, options.bundle, key.value(), on_bytes);
  });
  if (!read) return console.Fail({ExitCode::kNotDone, read.error()});
  const ota::Manifest& manifest = read.value().manifest;
  if (root && manifest.robot != root->config().robot) {
    return console.Fail({ExitCode::kNotDone, FaultError(ota::Fault::kOtherRobot,
                                                        "it is for robot " + manifest.robot +
                                                            ", not for " + root->config().robot)});
  }
  return DoneWith(
      console, manifest, options.bundle,
      fmt::format("{}: version {} for {}, {}; complete, signature valid", options.bundle,
                  manifest.version.text, manifest.robot, Size(manifest)));
}

void AddConfig(Grammar& grammar, CLI::App& app, std::string& config) {
  grammar
      .Offer(app.add_option("--config", config,
                            "The state config, relative to the folder of files;\n"
                            "default robot.toml"),
             Names::kFiles)
      ->type_name("FILE");
}

}  // namespace

void AddOtaKeygen(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("keygen", "Create the key pair that signs bundles", OtaKeygen, &family);
  app.add_option("NAME", options.name, "NAME.key stays with the signer, NAME.pub goes to robots")
      ->required()
      ->type_name("");
}

void AddOtaBundle(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("bundle", "Make a signed bundle from a folder of files", OtaBundle, &family);
  grammar
      .Offer(app.add_option("FOLDER", options.folder, "Programs in bin/, the state config, ..."),
             Names::kFolders)
      ->required()
      ->type_name("");
  app.add_option("--version", options.version, "MAJOR.MINOR.PATCH, as in 1.4.0")
      ->required()
      ->type_name("VERSION");
  app.add_option("--min-version", options.min_version, "The oldest version that it can upgrade")
      ->type_name("VERSION");
  app.add_option("--robot", options.robot, "Name of its robot; default the machine's name")
      ->type_name("NAME");
  AddConfig(grammar, app, options.config);
  grammar.Offer(app.add_option("--key", options.key, "Private key"), Names::kFiles)
      ->required()
      ->type_name("FILE");
  grammar
      .Offer(app.add_option("-o,--out", options.out, "The bundle; a new folder"), Names::kFolders)
      ->required()
      ->type_name("FOLDER");
}

void AddOtaInit(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("init", "Make an upgrade root from a robot's first bundle", OtaInit, &family);
  grammar
      .Offer(app.add_option("ROOT", options.root, "New folder, for `musher up ROOT`"),
             Names::kFolders)
      ->required()
      ->type_name("");
  grammar.Offer(app.add_option("--from", options.bundle, "The first bundle"), Names::kFolders)
      ->required()
      ->type_name("BUNDLE");
  grammar
      .Offer(app.add_option("--key", options.key, "Public key that verifies later bundles"),
             Names::kFiles)
      ->required()
      ->type_name("FILE");
  AddConfig(grammar, app, options.config);
}

void AddOtaVerify(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("verify", "Verify a bundle; changes nothing", OtaVerify, &family);
  AddBundle(grammar, app, options.bundle);
  grammar
      .Offer(app.add_option("--key", options.key, "Public key; default the key of the root"),
             Names::kFiles)
      ->type_name("FILE");
  AddRoot(grammar, app, options.root);
}

}  // namespace musher::cli
