// musher up FILE|ROOT: starts a machine. The controller gets a process of its own, forked before
// any thread or DDS socket exists; this process stays in the foreground and prints events.
//
// The controller of an upgrade root may have to restart from another slot. It executes this program
// again, in the same process and with --resume: its pid stays the same for its launcher and for
// systemd, and its memory keeps nothing of the previous machine.

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/base/date_text.hpp"
#include "musher/base/diagnostic.hpp"
#include "musher/base/host.hpp"
#include "musher/base/program_path.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/up_launcher.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/config/group_check.hpp"
#include "musher/cli/config/key_check.hpp"
#include "musher/cli/console/signals.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/cli/start/controller_process.hpp"
#include "musher/cli/start/slot_run.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/security/check.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::cli {
namespace {

struct UpOptions {
  std::string file;  // or an upgrade root
  bool detach = false;
  bool takeover = false;  // replace a running controller
  bool adopt = false;     // take control of actuators that run with another config, too
  // A supervisor starts it, perhaps again after a crash: complete a TearDown that was under way.
  bool restarted = false;
  bool standby = false;  // lead once the controller of another host has failed
  // For a controller that restarts itself: its connection to the launcher, the launcher's pid or 0,
  // and the lock of its root.
  struct Resume {
    int progress = -1;
    int launcher = 0;
    int root_lock = -1;  // the descriptor that holds it; -1: none
  };
  std::optional<Resume> resume;
};

constexpr unsigned kLeaveTime = 2;  // seconds, for leaving the domain

// How a controller process exits once DDS has shut down or the time for that is over.
struct End {
  int exit_code = 0;
  std::vector<char*> argv;  // of the program to execute instead; may be empty
  std::vector<char*> environment;
  std::string program;
};
End the_end;  // global, for the signal handler

// Async-signal-safe.
[[noreturn]] void EndNow() {
  if (!the_end.argv.empty()) {
    alarm(0);  // it would survive execve()
    sigset_t alarms;
    sigemptyset(&alarms);
    sigaddset(&alarms, SIGALRM);
    sigprocmask(SIG_UNBLOCK, &alarms, nullptr);
    execve(the_end.program.c_str(), the_end.argv.data(), the_end.environment.data());
    the_end.exit_code = static_cast<int>(ExitCode::kUsage);
  }
  _exit(the_end.exit_code);
}

// DDS waits for ever to leave a network that is lost. Everything else is done by now.
void EndWithin(unsigned seconds) {
  std::signal(SIGALRM, [](int) { EndNow(); });
  alarm(seconds);
}

// What a controller needs to execute this program again.
struct Reexec {
  std::vector<std::string> words;
  std::vector<std::string> environment;  // as it was before this process changed it

  Reexec(const std::string& root, int progress)
      : words{"musher", "up", root, "--resume", std::to_string(progress)} {
    for (char** variable = environ; *variable != nullptr; ++variable) {
      environment.emplace_back(*variable);
    }
  }
  void Prepare(pid_t launcher, int root_lock) {
    words.back() += "," + std::to_string(launcher) + "," + std::to_string(root_lock);
    the_end.program = OwnProgram();
    // A package manager may have replaced the file, or may be about to.
    std::error_code error;
    if (!std::filesystem::exists(the_end.program, error)) {
      the_end.program = "/proc/self/exe";
    }
    for (std::string& word : words) the_end.argv.push_back(word.data());
    for (std::string& variable : environment) the_end.environment.push_back(variable.data());
    the_end.argv.push_back(nullptr);
    the_end.environment.push_back(nullptr);
  }
};

// What to start: a state config, or the slot of an upgrade root that is due.
struct Target {
  MachineConfig config;
  std::optional<SlotRun> run;
  RootLock lock{};  // of the run's root
};

// `lock`: of the root, if this process holds it.
std::optional<Target> ChooseTarget(const UpOptions& options, RootLock lock, Console& console) {
  if (std::filesystem::is_directory(options.file)) {
    auto chosen = ChooseSlot(options.file, options.takeover, options.resume.has_value(),
                             std::move(lock), console);
    if (!chosen) return std::nullopt;
    return Target{std::move(chosen->config), std::move(chosen->run), std::move(chosen->lock)};
  }
  const bool is_word = options.file.find_first_of("./") == std::string::npos;
  if (is_word && !std::filesystem::exists(options.file)) {
    console.Fail({kCodeParametersInvalid,
                  fmt::format("there is no file '{0}'; `musher up robot.toml` starts a machine, "
                              "`musher restart {0}` an actuator of a machine that runs",
                              options.file)});
    return std::nullopt;
  }
  auto config = LoadConfig(options.file, console);
  if (!config) return std::nullopt;
  return Target{std::move(*config), std::nullopt, {}};
}

// Whether --restarted means a restart after a crash. systemd uses the same command for the first
// start and for restarts; with RuntimeDirectoryPreserve=restart the unit's folder is new for the
// first start and kept until the unit is stopped.
bool StartedAgain(const UpOptions& options) {
  if (!options.restarted) return false;
  const char* folders = std::getenv("RUNTIME_DIRECTORY");  // NOLINT(concurrency-mt-unsafe)
  if (folders == nullptr || *folders == '\0') return true;
  const std::string folder = std::string(folders).substr(0, std::string(folders).find(':'));
  const UniqueFd first(
      open((folder + "/started").c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  return !first.valid() && errno == EEXIST;
}

constexpr std::chrono::days kSoon(30);

// Checks the credentials of the controller and of the actuators that it starts. When they expire,
// running processes lose each other too: a warning comes 30 days before.
Result<> TakeKeys(const MachineConfig& config, Console& console) {
  const transport::keys::KeyFolder folder(config.keys);
  for (const std::string& identity : KeyedIdentities(config)) {
    const auto until =
        transport::keys::Check(folder, identity, transport::keys::KeyUse::kByAnyProcess);
    if (!until) return until.error();
    if (until.value() < std::chrono::system_clock::now() + kSoon) {
      console.PrintError(folder.Certificate(identity) + " expires on " + FormatUtc(until.value()) +
                         "; " + identity + " loses its connection then; `musher keys add " +
                         identity + " --force` creates a new one");
    }
  }
  return Ok();
}

}  // namespace

namespace {

// Leads the machine in this process, which has neither threads nor DDS yet.
[[noreturn]] void Lead(const UpOptions& options, Target& target, UniqueFd progress,
                       pid_t launcher) {
  fcntl(progress.get(), F_SETFD, FD_CLOEXEC);  // an inherited one does not have it
  // Kept for the program that is executed after this one; the machine's processes do not inherit
  // it.
  const UniqueFd kept(fcntl(progress.get(), F_DUPFD_CLOEXEC, 0));
  target.lock.NameThisProcess();
  Reexec reexec(target.run ? target.run->root : "", kept.get());
  {
    ControllerProcess process(
        target.config, target.run, target.lock, std::move(progress), launcher,
        {options.takeover, options.adopt, options.resume || StartedAgain(options),
         options.resume || options.restarted, options.standby});
    the_end.exit_code = process.Run();
    if (process.StartsAgain()) {
      // Another start that took the lock while the program is loaded would change the choice.
      reexec.Prepare(process.launcher(), target.lock.KeepForExec());
      fcntl(kept.get(), F_SETFD, 0);  // here: it is executed from a signal where DDS does not end
    } else {
      target.lock = {};  // the machine is stopped, while this process leaves the domain
    }
    EndWithin(kLeaveTime);
  }
  if (the_end.argv.empty()) std::exit(the_end.exit_code);  // NOLINT(concurrency-mt-unsafe)
  EndNow();
}

std::vector<std::string> OwnAddresses() {
  std::vector<std::string> own = {HostName()};
  for (const transport::NetworkInterface& one : transport::ReadInterfaces()) {
    own.insert(own.end(), one.addresses.begin(), one.addresses.end());
  }
  return own;
}

Result<> CheckTarget(Target& target, const UpOptions& options, const GlobalOptions& global,
                     Console& console) {
  MachineConfig& config = target.config;
  config.file = std::filesystem::absolute(config.file);  // for actuators that run elsewhere
  if (config.failover) TakeOwnHosts(config, OwnAddresses());
  transport::DdsOptions dds;
  dds.profile = config.transport;
  const auto profile = transport::Profile(dds);
  if (!profile) return profile.error();
  config.transport = profile.value();  // decisions about silent actuators depend on it, too
  if (global.name_space_given && global.name_space != config.name_space) {
    return Error{kCodeParametersInvalid,
                 "--namespace differs from the config: actuators use the namespace of " +
                     options.file + ", '" + config.name_space + "'"};
  }
  if (options.standby && !config.failover) {
    return Error{kCodeParametersInvalid,
                 "--standby needs failover_ms in [controller] of " + options.file +
                     ": after this time without a controller the standby leads"};
  }
  if (options.standby && target.run) {
    return Error{kCodeParametersInvalid,
                 "--standby takes a state config, not an upgrade root: a version on trial boot "
                 "would wait for a start that does not come"};
  }
  if (options.standby && options.takeover) {
    return Error{kCodeParametersInvalid,
                 "--standby waits for a controller that fails, and --takeover replaces one that "
                 "works: give one of them"};
  }
  // A controller that is executed again leads its machine with the group or without.
  const auto group = options.resume ? std::vector<Diagnostic>() : CheckLogGroup(config);
  if (!group.empty()) return Error{kCodeParametersInvalid, FormatDiagnostic(group.front())};
  // A supervisor's start goes on without rules that cannot be read, and says so: they only report.
  const bool by_person = !options.resume && !options.restarted;
  const auto rules = by_person ? RulesOf(config).diagnostics : std::vector<Diagnostic>();
  if (!rules.empty()) return Error{kCodeParametersInvalid, FormatDiagnostic(rules.front())};
  return TakeKeys(config, console);
}

ExitCode Up(const UpOptions& options, const GlobalOptions& global, Console& console) {
  // If the reader of the output exits, as in `| head -2`, this process and the controller continue.
  // The processes that the controller starts get the default action of all signals.
  std::signal(SIGPIPE, SIG_IGN);
  RootLock lock;
  if (options.resume && options.resume->root_lock >= 0) {
    const std::string root = std::filesystem::canonical(options.file);
    if (auto kept = lock.Resume(root, options.resume->root_lock); !kept) {
      console.PrintError(kept.error().message);
    }
  }
  auto target = ChooseTarget(options, std::move(lock), console);
  if (!target) return ExitCode::kUsage;
  auto good = CheckTarget(*target, options, global, console);
  if (!good && target->run && target->run->DecidesTrial() && EndTrialBoot(*target->run, good)) {
    const std::string reason =
        "version " + target->run->version + " abandoned: " + good.error().message;
    console.PrintError(reason);
    target = ChooseTarget(options, std::move(target->lock), console);
    if (!target) return ExitCode::kUsage;
    if (target->run) target->run->reason = reason;
    good = CheckTarget(*target, options, global, console);
  }
  if (!good) return console.Fail(good.error());
  if (options.resume)
    Lead(options, *target, UniqueFd(options.resume->progress), options.resume->launcher);
  const MachineConfig& config = target->config;
  if (!console.mode().json) console.Print(config.name + ": " + ConfigSummary(config));

  UniqueFd signals = TakeEndSignals();  // before the fork, so that none is missed
  auto [ours, theirs] = MakeProgressPair();
  const pid_t launcher = getpid();
  const pid_t controller = fork();
  if (controller < 0) return console.Fail(SystemError("fork"));
  if (controller == 0) {
    signals = {};
    ours = {};
    Lead(options, *target, std::move(theirs), options.detach ? 0 : launcher);
  }
  theirs = {};
  target->lock = {};  // it is the controller's
  return UpLauncher(console, config, controller, std::move(ours), std::move(signals),
                    options.detach, options.restarted)
      .Run();
}

}  // namespace

void AddUp(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("up", "Start a machine, stay in the foreground; Ctrl-C takes it down", Up,
                  "musher up robot.toml --detach");
  grammar
      .Offer(app.add_option("FILE", options.file,
                            "State config (TOML), or an upgrade root made by\n"
                            "`musher ota init`"),
             Names::kConfigs)
      ->required()
      ->type_name("");
  app.add_flag("-d,--detach", options.detach,
               "Return once start-up is complete; the machine stays up");
  app.add_flag("--takeover", options.takeover,
               "Replace the controller that leads this machine; its\n"
               "actuators keep running");
  app.add_flag("--adopt", options.adopt,
               "Take control of actuators that already run with another\n"
               "config; without it they block the start");
  app.add_flag("--standby", options.standby,
               "Lead nothing until the controller of another host has\n"
               "failed: see [controller] failover_ms");
  app.add_flag("--restarted", options.restarted,
               "For supervisors such as systemd: if the last controller\n"
               "exited during TearDown, complete that and stay down;\n"
               "after an emergency stop wait for a person's request");
  // For internal use: a controller that restarts executes this program with it.
  app.add_option_function<std::vector<int>>(
         "--resume",
         [&resume = options.resume](const std::vector<int>& values) {
           resume =
               UpOptions::Resume{values.at(0), values.at(1), values.size() > 2 ? values.at(2) : -1};
         })
      ->expected(2, 3)
      ->delimiter(',')
      ->group("");
}

}  // namespace musher::cli
