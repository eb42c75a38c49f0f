// musher up FILE: starts a machine. The controller gets a process of its own, forked before there
// is a thread or a socket of DDS; this one stays in the foreground and shows what happens.

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/config_file.hpp"
#include "musher/controller/cli/controller_process.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/controller/cli/signals.hpp"
#include "musher/controller/cli/up_front.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/host.hpp"
#include "musher/transport/keys/check.hpp"

namespace musher::cli {
namespace {

constexpr unsigned kLeaveTime = 2;  // seconds, for leaving the domain

volatile std::sig_atomic_t exit_code_in_time = 0;

// DDS waits for ever to leave a network that has gone. By now all is said and done.
void EndWithin(unsigned seconds, int exit_code) {
  exit_code_in_time = exit_code;
  std::signal(SIGALRM, [](int) { _exit(exit_code_in_time); });
  alarm(seconds);
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

ExitCode Up(const UpOptions& options, const GlobalOptions& global, Console& console) {
  auto config = LoadConfig(options.file, console);
  if (!config) return ExitCode::kUsage;
  config->file = std::filesystem::absolute(config->file);  // for actuators that run elsewhere
  transport::DdsOptions dds;
  dds.profile = config->transport;
  const auto profile = transport::Profile(dds);
  if (!profile) return console.Fail({ExitCode::kUsage, profile.error()});
  config->transport = profile.value();  // what is made of silence goes by it, too
  if (global.name_space_given && global.name_space != config->name_space) {
    return console.Fail(
        {ExitCode::kUsage,
         {kCodeParametersInvalid,
          "the namespace of a machine is in its config, since its actuators read it "
          "there: " +
              options.file + " says '" + config->name_space + "'"}});
  }
  if (auto good = CheckKeys(*config, console); !good)
    return console.Fail({ExitCode::kUsage, good.error()});
  if (!console.mode().json) console.Print(config->name + ": " + ConfigSummary(*config));

  transport::UniqueFd signals = TakeEndSignals();  // before: none may come in between
  auto [ours, theirs] = MakeProgressPair();
  const pid_t front = getpid();
  const pid_t controller = fork();
  if (controller < 0) return console.Fail({ExitCode::kUsage, transport::SystemError("fork")});
  if (controller == 0) {
    signals = {};
    ours = {};
    int exit_code = 0;
    {
      ControllerProcess process(*config, std::move(theirs), options.detach ? 0 : front,
                                options.takeover);
      exit_code = process.Run();
      EndWithin(kLeaveTime, exit_code);
    }
    std::exit(exit_code);  // NOLINT(concurrency-mt-unsafe)
  }
  theirs = {};
  return UpFront(console, config->name, controller, std::move(ours), std::move(signals),
                 options.detach)
      .Run();
}

}  // namespace musher::cli
