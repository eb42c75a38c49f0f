// musher up FILE|ROOT: starts a machine. The controller gets a process of its own, forked before
// there is a thread or a socket of DDS; this one stays in the foreground and shows what happens.
//
// The controller of a root's machine may have to start again from another slot. It executes this
// program anew, in the same process and with --resume: so its front, systemd and whoever else knows
// it by its pid notice nothing, and nothing of the machine before is left in its memory.

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/config_file.hpp"
#include "musher/controller/cli/controller_process.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/signals.hpp"
#include "musher/controller/cli/slot_run.hpp"
#include "musher/controller/cli/up_launcher.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/host.hpp"
#include "musher/transport/keys/check.hpp"

namespace musher::cli {
namespace {

constexpr unsigned kLeaveTime = 2;  // seconds, for leaving the domain

// How a controller process ends when it has been left by DDS or its time for that is over.
struct End {
  int exit_code = 0;
  std::vector<char*> argv;  // of the program to execute instead; may be empty
  std::vector<char*> environment;
  std::string program;
};
End the_end;  // for a signal handler, which has no other way to it

// Async-signal-safe.
[[noreturn]] void EndNow() {
  if (!the_end.argv.empty()) {
    alarm(0);  // it would go on
    sigset_t alarms;
    sigemptyset(&alarms);
    sigaddset(&alarms, SIGALRM);
    sigprocmask(SIG_UNBLOCK, &alarms, nullptr);
    execve(the_end.program.c_str(), the_end.argv.data(), the_end.environment.data());
    the_end.exit_code = static_cast<int>(ExitCode::kUsage);
  }
  _exit(the_end.exit_code);
}

// DDS waits for ever to leave a network that has gone. By now all is said and done.
void EndWithin(unsigned seconds) {
  std::signal(SIGALRM, [](int) { EndNow(); });
  alarm(seconds);
}

// What a controller needs to start again.
struct Again {
  std::vector<std::string> words;
  std::vector<std::string> environment;  // as it was before this process changed it

  Again(const std::string& root, int progress)
      : words{"musher", "up", root, "--resume", std::to_string(progress)} {
    for (char** variable = environ; *variable != nullptr; ++variable) {
      environment.emplace_back(*variable);
    }
  }
  void Prepare(pid_t front) {
    words.back() += "," + std::to_string(front);
    std::error_code error;
    the_end.program = std::filesystem::read_symlink("/proc/self/exe", error);
    // A package may have replaced it meanwhile, or be just about to.
    if (error || !std::filesystem::exists(the_end.program, error)) {
      the_end.program = "/proc/self/exe";
    }
    for (std::string& word : words) the_end.argv.push_back(word.data());
    for (std::string& variable : environment) the_end.environment.push_back(variable.data());
    the_end.argv.push_back(nullptr);
    the_end.environment.push_back(nullptr);
  }
};

// What is to be started: a state config, or the slot of a root that is due.
struct Target {
  MachineConfig config;
  std::optional<SlotRun> run;
};

std::optional<Target> ChooseTarget(const UpOptions& options, Console& console) {
  if (std::filesystem::is_directory(options.file)) {
    auto chosen = ChooseSlot(options.file, options.takeover, console);
    if (!chosen) return std::nullopt;
    return Target{std::move(chosen->config), std::move(chosen->run)};
  }
  auto config = LoadConfig(options.file, console);
  if (!config) return std::nullopt;
  return Target{std::move(*config), std::nullopt};
}

// Whether a supervisor starts the machine again, as far as --restarted tells. systemd uses one
// command for the first start and for those after a crash; with RuntimeDirectoryPreserve=restart
// its folder is new for the first one, and stays until the unit is stopped.
bool StartedAgain(const UpOptions& options) {
  if (!options.restarted) return false;
  const char* folders = std::getenv("RUNTIME_DIRECTORY");  // NOLINT(concurrency-mt-unsafe)
  if (folders == nullptr || *folders == '\0') return true;
  const std::string folder = std::string(folders).substr(0, std::string(folders).find(':'));
  const transport::UniqueFd first(
      open((folder + "/started").c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  return !first.valid() && errno == EEXIST;
}

constexpr std::chrono::days kSoon(30);

// The controller's keys, and those of the actuators that it starts and that need them. When they
// expire the processes part, also those that run: that is told in time.
Result<> CheckKeys(const MachineConfig& config, Console& console) {
  if (config.keys.empty()) return Ok();
  std::vector<std::string> identities = {transport::kControllerIdentity};
  for (const ActuatorConfig& actuator : config.actuators) {
    const bool needs_keys = !actuator.command.empty() && actuator.protocol == Protocol::kMusher;
    if (needs_keys) identities.push_back(actuator.name);
  }
  const transport::keys::KeyFolder folder(config.keys);
  for (const std::string& identity : identities) {
    const auto until = transport::keys::Check(folder, identity);
    if (!until) return until.error();
    if (until.value() < std::chrono::system_clock::now() + kSoon) {
      console.Complain(folder.Certificate(identity) + " expires on " +
                       transport::keys::IsoTime(until.value()) +
                       ", and the machine falls apart then; `musher keys add " + identity +
                       " --force` makes a new one");
    }
  }
  return Ok();
}

}  // namespace

namespace {

// Leads the machine in this process, which has neither threads nor DDS yet.
[[noreturn]] void Lead(const UpOptions& options, Target& target, transport::UniqueFd progress,
                       pid_t front) {
  fcntl(progress.get(), F_SETFD, FD_CLOEXEC);  // the one that was handed on is not
  // Kept for the program that comes after this one; those that the machine is made of get none.
  const transport::UniqueFd kept(fcntl(progress.get(), F_DUPFD_CLOEXEC, 0));
  Again again(target.run ? target.run->root : "", kept.get());
  {
    ControllerProcess process(
        target.config, target.run, std::move(progress), front,
        {options.takeover, options.adopt, options.resume || StartedAgain(options)});
    the_end.exit_code = process.Run();
    if (process.StartsAgain()) again.Prepare(process.front());
    EndWithin(kLeaveTime);
  }
  if (the_end.argv.empty()) std::exit(the_end.exit_code);  // NOLINT(concurrency-mt-unsafe)
  fcntl(kept.get(), F_SETFD, 0);
  EndNow();
}

Result<> Judge(Target& target, const UpOptions& options, const GlobalOptions& global,
               Console& console) {
  MachineConfig& config = target.config;
  config.file = std::filesystem::absolute(config.file);  // for actuators that run elsewhere
  transport::DdsOptions dds;
  dds.profile = config.transport;
  const auto profile = transport::Profile(dds);
  if (!profile) return profile.error();
  config.transport = profile.value();  // what is made of silence goes by it, too
  if (global.name_space_given && global.name_space != config.name_space) {
    return Error{kCodeParametersInvalid,
                 "the namespace of a machine is in its config, since its actuators read it "
                 "there: " +
                     options.file + " says '" + config.name_space + "'"};
  }
  return CheckKeys(config, console);
}

}  // namespace

ExitCode Up(const UpOptions& options, const GlobalOptions& global, Console& console) {
  // A reader of the output that ends, as in `| head -2`, ends neither this process nor the
  // controller. What the controller starts has all signals at their defaults.
  std::signal(SIGPIPE, SIG_IGN);
  auto target = ChooseTarget(options, console);
  if (!target) return ExitCode::kUsage;
  auto good = Judge(*target, options, global, console);
  if (!good && target->run && target->run->on_trial_boot && EndTrialBoot(*target->run, good)) {
    const std::string told =
        "version " + target->run->version + " is left: " + good.error().message;
    console.Complain(told);
    target = ChooseTarget(options, console);
    if (!target) return ExitCode::kUsage;
    if (target->run) target->run->told = told;
    good = Judge(*target, options, global, console);
  }
  if (!good) return console.Fail(good.error());
  if (options.resume)
    Lead(options, *target, transport::UniqueFd(options.resume->progress), options.resume->front);
  const MachineConfig& config = target->config;
  if (!console.mode().json) console.Print(config.name + ": " + ConfigSummary(config));

  transport::UniqueFd signals = TakeEndSignals();  // before: none may come in between
  auto [ours, theirs] = MakeProgressPair();
  const pid_t front = getpid();
  const pid_t controller = fork();
  if (controller < 0) return console.Fail(transport::SystemError("fork"));
  if (controller == 0) {
    signals = {};
    ours = {};
    Lead(options, *target, std::move(theirs), options.detach ? 0 : front);
  }
  theirs = {};
  return UpLauncher(console, config.name, controller, std::move(ours), std::move(signals),
                    options.detach, options.restarted)
      .Run();
}

}  // namespace musher::cli
