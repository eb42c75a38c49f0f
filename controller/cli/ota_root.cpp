#include "musher/controller/cli/ota_root.hpp"

#include <fmt/format.h>
#include <sys/inotify.h>
#include <sys/syscall.h>

#include <array>
#include <cstdlib>
#include <filesystem>

#include "musher/controller/cli/slot_run.hpp"
#include "musher/controller/ota/fault.hpp"
#include "musher/controller/ota/posix_disk.hpp"
#include "musher/lifecycle/config_toml.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/transport/host.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kAnswerTimeout = std::chrono::seconds(5);
constexpr Duration kSwitchTimeout = std::chrono::minutes(5);  // lying down takes its time
constexpr Duration kGrace =
    std::chrono::seconds(60);  // beside the trial boot's own: down, and up again

// "/robot/slots/a/robot.toml" → "/robot"; empty: not of a root.
std::string RootOf(const std::string& config_file) {
  for (fs::path folder = fs::path(config_file).parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    std::error_code error;
    if (folder.filename() == "slots" && fs::exists(folder.parent_path() / ota::kRootFile, error)) {
      return folder.parent_path();
    }
  }
  return "";
}

GlobalOptions ForMachine(const MachineConfig& config, GlobalOptions global) {
  if (!global.name_space_given) global.name_space = config.name_space;
  if (config.transport == TransportProfile::kLan) setenv("MUSHER_TRANSPORT", "lan", /*replace=*/0);
  return global;
}

}  // namespace

std::optional<std::string> UpgradeFault(const MachineConfig& config) {
  if (config.HasState(kOta)) return std::nullopt;
  return config.file +
         ": the machine has no state OTA, in which a robot is upgraded: a robot that "
         "runs this config takes no further upgrade; list OTA in `states` of [controller]";
}

Result<std::string> FindRoot(const std::string& option, const GlobalOptions& global) {
  const char* variable = std::getenv("MUSHER_OTA_ROOT");  // NOLINT(concurrency-mt-unsafe)
  std::string root = option;
  if (root.empty() && variable != nullptr) root = variable;
  if (root.empty()) {
    const std::string which = "which root? --root FOLDER or $MUSHER_OTA_ROOT says it; ";
    const auto link = Link::Open(global);
    if (!link) return link.error();
    if (auto r = link.value()->FollowStatus({}); !r) return r.error();
    if (const auto failure = link.value()->AwaitStatus()) {
      return Error{failure->error.code, which + failure->error.message};
    }
    root = RootOf(link.value()->status()->config_file);
    if (root.empty()) {
      return Error{kCodeStateInvalid, which + "the running machine was started from the file " +
                                          link.value()->status()->config_file};
    }
  }
  std::error_code error;
  const fs::path path = fs::canonical(root, error);
  if (error) return Error{kCodeParametersInvalid, root + ": " + error.message()};
  return path.string();
}

std::variant<std::unique_ptr<RootMachine>, Failure> RootMachine::Find(const ota::Root& root,
                                                                      const GlobalOptions& global) {
  const int pid = ota::HolderOf(root.RunLock());
  if (pid == 0) return nullptr;
  const auto state = root.State();
  if (!state) return Failure{ExitCode::kUsage, state.error()};
  const bool tries = state.value().on_trial_boot && state.value().started;
  const ota::Slot slot = tries ? ota::Other(state.value().confirmed) : state.value().confirmed;
  const ConfigReading reading = ReadConfigFile(root.ConfigFile(slot));
  const GlobalOptions options = reading.config ? ForMachine(*reading.config, global) : global;
  std::unique_ptr<RootMachine> machine(new RootMachine(root, options, pid));
  if (auto failure = machine->Connect()) return *failure;
  return machine;
}

std::optional<Failure> RootMachine::Connect() {
  auto link = Link::Open(global_);
  if (!link) return Failure{ExitCode::kUsage, link.error()};
  link_ = std::move(link).value();
  if (auto r = link_->FollowStatus({}); !r) return Failure{ExitCode::kUsage, r.error()};
  if (auto failure = link_->AwaitStatus()) return failure;
  const msg::MachineStatus& status = *link_->status();
  if (RootOf(status.config_file) != root_.path()) {
    return Failure{ExitCode::kNotDone,
                   {kCodeStateInvalid,
                    fmt::format("process {} leads the machine of {}, but what answers in namespace "
                                "'{}' was started from {}",
                                pid_, root_.path(), global_.name_space, status.config_file)}};
  }
  slot_ = status.config_file.starts_with(root_.SlotFolder(ota::Slot::kB) + "/") ? ota::Slot::kB
                                                                                : ota::Slot::kA;
  return std::nullopt;
}

Result<> RootMachine::AskPolicy(bool enter) {
  const auto answer =
      link_->Ask<msg::RequestPolicy>("request_policy", {"ota", "", 0, enter}, kSwitchTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  const auto& response = std::get<msg::RequestPolicy::Response>(answer);
  // Who is there without some of its actuators is there: a robot with a broken one has to be
  // upgraded, too.
  const bool there = (response.state == kOta) == enter;
  const bool refused = response.code == kCodeUnSupport || !there;
  if (response.code != kCodeOk && refused) return Error{response.code, response.reason};
  return Ok();
}

Result<> RootMachine::Switch(const std::string& state) {
  const auto answer = link_->Ask<msg::SetState>("set_state", {state, ""}, kSwitchTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  const auto& response = std::get<msg::SetState::Response>(answer);
  if (response.state == state) return Ok();
  return Error{response.code, "the machine stays in " + response.state + ": " + response.reason};
}

Result<> RootMachine::EnterOta() {
  // By its own word: the topic may be a moment behind.
  const auto answer = link_->Ask<msg::GetStatus>("get_status", {}, kAnswerTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  const msg::MachineStatus& status = std::get<msg::GetStatus::Response>(answer).status;
  // One that did not come up is in nobody's use, and may need nothing more than this upgrade.
  if (status.phase == "failed") return Ok();
  before_ = status.state;
  asked_for_ota_ = true;
  auto entered = AskPolicy(true);
  // A robot without [policy] has no rules about it.
  if (!entered && entered.error().code == kCodeUnSupport) entered = Switch(std::string(kOta));
  if (entered) return Ok();
  return Error{entered.error().code, "the machine does not go to OTA: " + entered.error().message};
}

Result<> RootMachine::LeaveOta() {
  if (!asked_for_ota_) return Ok();
  if (Interrupted()) {  // it has ended what this connection waits for
    if (auto failure = Connect()) return failure->error;
  }
  if (Switch(before_)) return Ok();
  auto left = AskPolicy(false);
  if (!left && left.error().code == kCodeUnSupport) left = Switch(std::string(kActive));
  return left;
}

Result<> RootMachine::StartAgain() {
  const auto process = transport::OpenPidfd(pid_);
  if (!process) return process.error();
  if (ota::HolderOf(root_.RunLock()) != pid_) {
    return Error{kCodeStateInvalid, "the machine's controller has ended meanwhile"};
  }
  // The lock counts, not what is in its file.
  if (!transport::HoldsLockOn(pid_, root_.RunLock())) {
    return Error{kCodePermissionDenied,
                 root_.RunLock() + " is locked, but not by process " + std::to_string(pid_) +
                     ", which it names, or that cannot be seen; no process is signalled"};
  }
  const long sent =
      syscall(SYS_pidfd_send_signal, process.value().get(), kStartAgainSignal, nullptr, 0);
  if (sent == 0) return Ok();
  return transport::SystemError("can't reach the controller, process " + std::to_string(pid_));
}

std::optional<Result<>> RootMachine::TrialBootEnd() const {
  const auto state = root_.LoadState();
  if (!state || state->on_trial_boot) return std::nullopt;
  if (state->last && state->last->kept) return Result<>(Ok());
  const std::string why = state->last ? state->last->reason : "it is not known why";
  return Result<>(Refusal(ota::Fault::kGoneBack, why));
}

Result<> RootMachine::AwaitTrialBoot() {
  const auto process = transport::OpenPidfd(pid_);
  if (!process) return process.error();
  bool ended = false;
  const auto watch = link_->loop().WhenReadable(process.value().get(), [&ended] { ended = true; });
  const transport::UniqueFd changes(inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (inotify_add_watch(changes.get(), root_.path().c_str(), IN_MOVED_TO) < 0) {
    return transport::SystemError("can't watch " + root_.path());
  }
  const auto changed = link_->loop().WhenReadable(changes.get(), [&changes] {
    std::array<char, 4096> events{};
    while (read(changes.get(), events.data(), events.size()) > 0) {
    }
  });
  std::optional<Result<>> end;
  link_->RunUntil([&] { return ended || (end = TrialBootEnd()).has_value(); },
                  root_.config().trial + kGrace);
  if (!end) end = TrialBootEnd();
  if (end) {
    if (!ended) AwaitMachine();
    return *end;
  }
  const std::string later = "; `musher ota status` shows how it ends";
  if (ended) {
    return Error{kCodeFailed, "the controller has ended during the trial; the next `musher up " +
                                  root_.path() + "` goes back"};
  }
  if (link_->interrupted()) return Error{kCodeFailed, "interrupted, the trial goes on" + later};
  return Error{kCodeTimeout, "the trial has not ended in time" + later};
}

// Until the machine of the version that was decided for is up, or cannot be.
void RootMachine::AwaitMachine() {
  const auto state = root_.LoadState();
  if (!state) return;
  const std::string folder = root_.SlotFolder(state->confirmed) + "/";
  link_->RunUntil(
      [&] {
        const auto& status = link_->status();
        return status && status->config_file.starts_with(folder) &&
               (status->phase == "running" || status->phase == "failed");
      },
      kGrace);
}

bool RootMachine::Interrupted() {
  link_->loop().RunUntil([] { return false; }, link_->loop().Now());
  interrupted_ |= link_->interrupted();
  return interrupted_;
}

}  // namespace musher::cli
