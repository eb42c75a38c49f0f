// musher deploy CONFIG: copies what a config names to its other hosts, as a version in the slots of
// an upgrade root there, and switches all of them to it, or none. With --restart what runs there is
// restarted then.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "musher/base/date_text.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/deploy/deployment.hpp"
#include "musher/cli/deploy/host_slot.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/restart_call.hpp"
#include "musher/ota/posix_disk.hpp"
#include "musher/ota/signature.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestKeyFile = 16 << 10;  // bytes

struct DeployCommand {
  std::string config;
  std::string version;
  std::string key;   // file of the private key; the public one is beside it
  std::string from;  // empty: the folder of the config
  bool allow_downgrade = false;
  bool restart = false;
  std::string step;  // on a host; empty: none
  std::string root;
};

// nullopt: they are read.
std::optional<Error> ReadSigningKeys(const std::string& file, DeployOptions& options) {
  ota::PosixDisk disk;
  auto secret = ota::ReadAll(disk, file, kLargestKeyFile);
  if (!secret) return secret.error();
  const auto info = disk.Look(file);
  constexpr unsigned kOfOthers = 077;
  if (info && (info.value().mode & kOfOthers) != 0) {
    return Error{kCodePermissionDenied,
                 file + ": the signing key is readable by others; restrict it: chmod 600 " +
                     ShellWord(file)};
  }
  const std::string open = fs::path(file).replace_extension(".pub").string();
  auto shown = ota::ReadAll(disk, open, kLargestKeyFile);
  if (!shown) return shown.error();
  if (const auto good = ota::CheckPublicKey(shown.value()); !good) {
    return Error{kCodeParametersInvalid, open + " is " + good.error().message};
  }
  options.private_pem = std::move(secret).value();
  options.public_pem = std::move(shown).value();
  return std::nullopt;
}

ExitCode TakeStep(const DeployCommand& options, Console& console) {
  ota::PosixDisk disk;
  const std::string root = fs::path(options.root).lexically_normal().string();
  if (options.version.empty() || !root.starts_with('/') || root.size() < 2) {
    return console.Fail(
        {kCodeParametersInvalid, "--step needs --version and --root with an absolute path"});
  }
  if (options.step == "look") {
    const auto found = FindVersion(disk, root, options.version);
    if (!found) return console.Fail({ExitCode::kNotDone, found.error()});
    console.Print(FormatPlaced(found.value()));
    return ExitCode::kDone;
  }
  const auto taken = options.step == "stage"
                         ? StageSlot(disk, root, options.version, {options.allow_downgrade})
                     : options.step == "switch" ? SwitchSlot(disk, root, options.version)
                                                : UndoSlot(disk, root, options.version);
  if (!taken) return console.Fail({ExitCode::kNotDone, taken.error()});
  if (console.mode().json) {
    console.Print(JsonLine({{"version", options.version},
                            {"hosts", OrderedJson::array()},
                            {"restarted", OrderedJson::array()}}));
  }
  return ExitCode::kDone;
}

std::string DeployJson(const DeployPlan& plan, const std::string& version,
                       const std::set<std::string>& had,
                       const std::vector<std::string>& restarted) {
  auto hosts = OrderedJson::array();
  for (const HostFiles& files : plan.hosts) {
    hosts.push_back({{"host", files.host->name},
                     {"root", files.root},
                     {"files", files.files.size()},
                     {"changed", !had.contains(files.host->name)}});
  }
  return JsonLine({{"version", version}, {"hosts", hosts}, {"restarted", restarted}});
}

std::vector<std::string> ActuatorsOf(const DeployPlan& plan) {
  std::vector<std::string> actuators;
  for (const HostFiles& files : plan.hosts) {
    actuators.insert(actuators.end(), files.actuators.begin(), files.actuators.end());
  }
  return actuators;
}

// One after the other, by the controller of the machine of the config; the others run on where one
// is not back. Also those of hosts that had the version: they may have been started before.
std::optional<Failure> RestartAll(const std::vector<std::string>& actuators,
                                  const MachineConfig& config, GlobalOptions global,
                                  Console& console) {
  if (actuators.empty()) return std::nullopt;
  if (!global.name_space_given) global.name_space = config.name_space;
  if (global.machine.empty()) global.machine = config.name;
  // The transport reads it from the environment. Other hosts are reached by no other profile.
  setenv("MUSHER_TRANSPORT", "lan", /*replace=*/0);
  const auto link = Link::OpenForCalls(global, &console);
  for (std::size_t i = 0; i < actuators.size(); ++i) {
    if (console.mode().terminal && !console.mode().json) console.Note("restart " + actuators[i]);
    auto failure = RestartActuator(*link, actuators[i]);
    if (!failure) continue;
    const std::vector<std::string> left(actuators.begin() + static_cast<std::ptrdiff_t>(i),
                                        actuators.end());
    failure->error.message.insert(
        0, "all hosts have the version, and not restarted with it: " + Joined(left) + "; ");
    return failure;
  }
  return std::nullopt;
}

// Where a version is that was not deployed.
std::string WhereItIs(const std::string& version, const DeployOutcome& outcome) {
  if (outcome.unknown) return "version " + version + " may be on a host";
  if (outcome.had.empty()) return "version " + version + " is on no host";
  return "version " + version + " is on no other host than before: " + Joined(outcome.had);
}

// What was done, and what is still to be.
std::string DeployText(const DeployPlan& plan, const std::string& version,
                       const std::set<std::string>& had, bool restarted) {
  std::string text;
  for (const HostFiles& files : plan.hosts) {
    text += fmt::format("{}: {} {} in {}, {}\n", files.host->name,
                        had.contains(files.host->name) ? "has had version" : "version", version,
                        files.root, Counted(files.files.size(), "file"));
  }
  const std::vector<std::string> actuators = ActuatorsOf(plan);
  if (restarted) return text + "restarted: " + Joined(actuators);
  text += "what runs there has it after its next start: musher restart";
  for (const std::string& actuator : actuators) text += " " + actuator;
  return text;
}

ExitCode RunDeploy(const DeployCommand& options, const GlobalOptions& global, Console& console) {
  if (!options.step.empty()) return TakeStep(options, console);
  for (const auto& [value, name] :
       {std::pair(&options.config, "CONFIG"), std::pair(&options.version, "--version VERSION"),
        std::pair(&options.key, "--key FILE")}) {
    if (value->empty()) {
      return console.Fail(
          {kCodeParametersInvalid, std::string("missing ") + name + "; see musher deploy --help"});
    }
  }
  DeployOptions deploy;
  const auto version = ota::ParseVersion(options.version);
  if (!version) {
    return console.Fail(
        {kCodeParametersInvalid,
         fmt::format("--version '{}' is not MAJOR.MINOR.PATCH, as in 1.4.0", options.version)});
  }
  const auto config = LoadConfig(options.config, console);
  if (!config) return ExitCode::kUsage;
  if (const auto error = ReadSigningKeys(options.key, deploy)) return console.Fail(*error);
  deploy.robot = config->name;
  deploy.version = *version;
  deploy.install.allow_downgrade = options.allow_downgrade;
  deploy.created =
      FormatUtc(std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now()));
  const std::string folder =
      options.from.empty() ? fs::absolute(config->file).parent_path().string() : options.from;
  const auto plan = PlanDeployment(*config, folder);
  if (!plan) return console.Fail(plan.error());
  for (const std::string& note : plan.value().notes) console.PrintError(note);
  const UniqueFd signals = TakeEndSignals();
  deploy.interrupt = signals.get();
  const DeployOutcome outcome = Deploy(plan.value(), deploy, [&](const std::string& step) {
    if (console.mode().terminal && !console.mode().json) console.Note(step);
  });
  if (!outcome.troubles.empty()) {
    std::string text;
    for (const std::string& trouble : outcome.troubles) text += trouble + "\n";
    text += WhereItIs(version->text, outcome);
    return console.Fail(
        {outcome.interrupted ? ExitCode::kInterrupted : ExitCode::kNotDone, {kCodeFailed, text}});
  }
  const std::vector<std::string> restarted =
      options.restart ? ActuatorsOf(plan.value()) : std::vector<std::string>();
  if (const auto failure = RestartAll(restarted, *config, global, console)) {
    return console.Fail(*failure);
  }
  console.Print(console.mode().json
                    ? DeployJson(plan.value(), version->text, outcome.had, restarted)
                    : DeployText(plan.value(), version->text, outcome.had, options.restart));
  return ExitCode::kDone;
}

}  // namespace

void AddDeploy(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("deploy", "Copy what a config names to its other hosts: all, or none", RunDeploy,
                  "musher deploy robot.toml --version 1.4.0 --key robot.key");
  grammar.Offer(app.add_option("CONFIG", options.config, "State config (TOML)"), Names::kConfigs)
      ->type_name("");
  app.add_option("--version", options.version, "MAJOR.MINOR.PATCH, as in 1.4.0")
      ->type_name("VERSION");
  grammar
      .Offer(app.add_option("--key", options.key,
                            "Private key of `musher ota keygen`; the public one is\nbeside it"),
             Names::kFiles)
      ->type_name("FILE");
  grammar
      .Offer(app.add_option("--from", options.from,
                            "Folder of the files, with those of one host in FROM/HOST;\n"
                            "default that of the config"),
             Names::kFolders)
      ->type_name("FOLDER");
  app.add_flag("--allow-downgrade", options.allow_downgrade, "Also an older version");
  app.add_flag("--restart", options.restart,
               "Then restart the actuators of these hosts, one after the\nother");
  grammar.OneOf(app.add_option("--step", options.step,
                               "What `musher deploy` runs on each host, instead of CONFIG,\n"
                               "--key and --from"),
                {"look", "stage", "switch", "undo"});
  app.add_option("--root", options.root, "With --step: the upgrade root")->type_name("FOLDER");
}

}  // namespace musher::cli
