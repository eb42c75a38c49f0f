#include "musher/cli/start/view_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/client/leader_watch.hpp"
#include "musher/controller/storage/private_folder.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

constexpr Duration kFirstPause = std::chrono::seconds(1);
constexpr Duration kLongestPause = std::chrono::seconds(60);
constexpr int kEndTimeoutMs = 1000;
constexpr int kUsage = 2;  // its exit code for a wrong option

}  // namespace

std::vector<std::string> ViewCommand(const MachineConfig& config) {
  const ViewConfig& view = *config.view;
  std::vector<std::string> command = {
      kViewProgram, "--port",   std::to_string(view.port),  "--bind",
      view.bind,    "--logs",   config.state_dir + "/logs", "--no-link",
      "--machine",  config.name};
  if (!config.name_space.empty()) {
    command.insert(command.end(), {"--namespace", config.name_space});
  }
  if (!view.token_file.empty()) command.insert(command.end(), {"--token-file", view.token_file});
  for (const std::string& one : config.interfaces) {
    command.insert(command.end(), {"--interface", one});
  }
  for (const std::string& host : view.hosts) command.insert(command.end(), {"--host", host});
  if (view.stop_needs_login) command.emplace_back("--stop-needs-login");
  return command;
}

std::map<std::string, std::string> ViewEnvironment(const MachineConfig& config) {
  std::map<std::string, std::string> environment;
  transport::DdsOptions dds;
  dds.profile = config.transport;
  if (const auto profile = transport::Profile(dds)) {
    const bool lan = profile.value() == TransportProfile::kLan;
    environment["MUSHER_TRANSPORT"] = lan ? "lan" : "local";
  }
  if (!config.keys.empty()) {
    environment["MUSHER_KEYS"] = config.keys;
    environment["MUSHER_IDENTITY"] = "operator";
  }
  return environment;
}

ViewProcess::ViewProcess(transport::EventLoop& loop, const MachineConfig& config,
                         OnTrouble on_trouble)
    : loop_(loop),
      command_(ViewCommand(config)),
      environment_(ViewEnvironment(config)),
      log_(config.state_dir + "/logs/" + kViewProgram + ".log"),
      on_trouble_(std::move(on_trouble)) {
  Start();
}

ViewProcess::~ViewProcess() {
  if (!program_) return;
  end_watch_.reset();
  const pid_t pid = program_->pid();
  kill(pid, SIGTERM);
  if (const auto process = OpenPidfd(pid)) {
    pollfd end{process.value().get(), POLLIN, 0};
    poll(&end, 1, kEndTimeoutMs);
  }
  kill(pid, SIGKILL);
  ReapChild(pid);
}

void ViewProcess::Start() {
  restart_.reset();
  UniqueFd output;
  if (!IsLink(std::filesystem::path(log_).parent_path())) {
    constexpr int kAppend = O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC;
    output = UniqueFd(open(log_.c_str(), kAppend, 0600));
  }
  if (!output.valid()) output = UniqueFd(open("/dev/null", O_WRONLY | O_CLOEXEC));
  ProgramSpec spec;
  spec.argv = command_;
  spec.output = output.get();
  spec.env = environment_;
  spec.after_fork = [](char* const*) { prctl(PR_SET_PDEATHSIG, SIGTERM); };
  auto program = ForkProgram(spec);
  if (!program) return StartLater("cannot be started: " + program.error().message);
  program_ = std::move(program).value();
  started_at_ = loop_.Now();
  end_watch_ = WatchByPidfd(loop_)(program_->pid(), [this] { OnEnd(); });
  if (!end_watch_) OnEnd();  // it has ended already
}

void ViewProcess::OnEnd() {
  const ForkedProgram program = *std::exchange(program_, std::nullopt);
  end_watch_.reset();
  const auto status = ReapEndedChild(program.pid());
  if (const auto failure = program.Failure(Duration{})) {
    return StartLater(failure->missing ? "is not installed; it is in the package musher-view"
                                       : failure->error.message);
  }
  if (status && !status->killed && status->number == kUsage) {
    return on_trouble_(std::string(kViewProgram) + " does not accept its options, and is not " +
                       "restarted; see " + log_);
  }
  if (loop_.Now() - started_at_ > kLongestPause) pause_ = kFirstPause;
  StartLater(status ? "ended: " + status->Text() : std::string("ended"));
}

void ViewProcess::StartLater(const std::string& why) {
  on_trouble_(std::string(kViewProgram) + " " + why + "; the page is served again in " +
              std::to_string(ToMilliseconds(pause_) / 1000) + " s; see " + log_);
  restart_ = loop_.At(loop_.Now() + pause_, [this] { Start(); });
  pause_ = std::min(2 * pause_, kLongestPause);
}

}  // namespace musher::cli
