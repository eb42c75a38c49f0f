#include "musher/cli/commands/ota/ota_root.hpp"

#include <fmt/format.h>
#include <sys/inotify.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "musher/base/break_watch.hpp"
#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/start/slot_run.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/posix_disk.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kAnswerTimeout = std::chrono::seconds(5);
constexpr Duration kSwitchTimeout = std::chrono::minutes(5);  // lying down takes long
constexpr Duration kGrace =
    std::chrono::seconds(60);  // added to the trial boot's limit: down and up

// "/robot/slots/a/robot.toml" → "/robot"; empty: not in a root.
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

SwitchNumber NumberOf(const msg::MachineStatus& status) {
  return {status.epoch, status.switch_number};
}

// Some actuators are in OTA, or on their way to it.
bool MovedToOta(const msg::MachineStatus& status) {
  return std::any_of(status.actuators.begin(), status.actuators.end(), [](const auto& actuator) {
    return actuator.state == kOta || actuator.target == kOta;
  });
}

}  // namespace

std::optional<std::string> UpgradeFault(const MachineConfig& config) {
  if (config.HasState(kOta)) return std::nullopt;
  return config.file +
         ": the machine has no state OTA, which upgrades need: a robot with this config could "
         "not be upgraded again; add OTA to `states` of [controller]";
}

Result<std::string> FindRoot(const std::string& option, const GlobalOptions& global) {
  const char* variable = std::getenv("MUSHER_OTA_ROOT");  // NOLINT(concurrency-mt-unsafe)
  std::string root = option;
  if (root.empty() && variable != nullptr) root = variable;
  if (root.empty()) {
    const std::string which = "no upgrade root given; use --root FOLDER or $MUSHER_OTA_ROOT; ";
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
                    fmt::format("process {} leads the machine of {}, but the machine in namespace "
                                "'{}' was started from {}",
                                pid_, root_.path(), global_.name_space, status.config_file)}};
  }
  slot_ = status.config_file.starts_with(root_.SlotFolder(ota::Slot::kB) + "/") ? ota::Slot::kB
                                                                                : ota::Slot::kA;
  return std::nullopt;
}

Result<> RootMachine::RequestPolicy(bool enter) {
  msg::RequestPolicy::Request request{"ota", "", 0, enter};
  request.by = UserAtHost();
  const auto answer =
      link_->CallLeader<msg::RequestPolicy>("request_policy", request, kSwitchTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  const auto& response = std::get<msg::RequestPolicy::Response>(answer);
  // done-degraded counts as done: a robot with a failed actuator must be upgradable, too.
  const bool reached = (response.state == kOta) == enter;
  const bool refused = response.code == kCodeUnSupport || !reached;
  if (response.code != kCodeOk && refused) return Error{response.code, response.reason};
  return Ok();
}

Result<> RootMachine::Switch(const std::string& state) {
  const auto answer =
      link_->CallLeader<msg::SetState>("set_state", {state, "", UserAtHost()}, kSwitchTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  const auto& response = std::get<msg::SetState::Response>(answer);
  if (response.state == state) return Ok();
  return Error{response.code, "the machine stays in " + response.state + ": " + response.reason};
}

// Calls the service: the topic may lag behind.
Result<msg::MachineStatus> RootMachine::Look() {
  auto answer = link_->Call<msg::GetStatus>("get_status", {}, kAnswerTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return failure->error;
  return std::move(std::get<msg::GetStatus::Response>(answer).status);
}

Result<> RootMachine::EnterOta() {
  const auto before = Look();
  if (!before) return before.error();
  // A machine that failed to start is not in use; this upgrade may fix it.
  if (before.value().phase == "failed") return Ok();
  before_ = before.value().state;
  auto entered = RequestPolicy(true);
  // A robot without [policy] has no rules for OTA: switch directly.
  if (!entered && entered.error().code == kCodeUnSupport) entered = Switch(std::string(kOta));
  const auto after = Look();
  // A request that was refused at once has moved nothing. What has become of one is not known if
  // the connection was interrupted meanwhile: LeaveOta() looks again.
  const bool began = !after || NumberOf(after.value()) != NumberOf(before.value());
  if (entered || began) ota_switch_ = after ? NumberOf(after.value()) : SwitchNumber();
  if (entered) return Ok();
  return Error{entered.error().code, "switch to OTA failed: " + entered.error().message};
}

Result<> RootMachine::LeaveOta() {
  if (!ota_switch_) return Ok();
  if (Interrupted()) {  // an interrupted connection no longer waits
    if (auto failure = Connect()) return failure->error;
  }
  const auto now = Look();
  if (!now) return now.error();
  // A machine that was switched by another command since then stays where it is: a robot that lies
  // must not stand up for a full disk. The switch to OTA may have failed half-way.
  const bool half_way = NumberOf(now.value()) == *ota_switch_ && MovedToOta(now.value());
  if (now.value().state != kOta && now.value().target != kOta && !half_way) return Ok();
  Result<> left = SwitchBack();
  if (left || Interrupted()) return left;
  // A controller that could not run refuses for a while what may be late. This was not.
  std::this_thread::sleep_for(BreakWatch::kArriveWithin);
  const auto then = Look();
  const bool moved = !then || NumberOf(then.value()) != NumberOf(now.value());
  return moved ? left : SwitchBack();
}

Result<> RootMachine::SwitchBack() {
  if (Switch(before_)) return Ok();
  auto left = RequestPolicy(false);
  if (!left && left.error().code == kCodeUnSupport) left = Switch(std::string(kActive));
  return left;
}

Result<> RootMachine::StartAgain() {
  if (Interrupted()) {  // an interrupted connection no longer waits
    if (auto failure = Connect()) return failure->error;
  }
  const auto now = Look();
  if (!now) {
    return Error{now.error().code, now.error().message +
                                       "; the machine stays in OTA, and the trial boot waits for "
                                       "`musher down` and the next start: musher up " +
                                       ShellWord(root_.path())};
  }
  if (now.value().phase != "failed" && now.value().state != kOta) {
    return Error{kCodeStateInvalid,
                 "the machine was switched to " + now.value().state +
                     " meanwhile and keeps running; the trial boot waits for `musher down` and the "
                     "next start: musher up " +
                     ShellWord(root_.path())};
  }
  const auto process = OpenPidfd(pid_);
  if (!process) return process.error();
  if (ota::HolderOf(root_.RunLock()) != pid_) {
    return Error{kCodeStateInvalid, "the machine's controller has exited meanwhile"};
  }
  // The pid in the lock file proves nothing; the lock does.
  if (!HoldsLockOn(pid_, root_.RunLock())) {
    return Error{kCodePermissionDenied,
                 root_.RunLock() + " names process " + std::to_string(pid_) +
                     ", which does not hold its lock or cannot be inspected; no process is "
                     "signalled"};
  }
  if (SendSignal(process.value().get(), kStartAgainSignal)) return Ok();
  return SystemError("can't signal the controller (pid " + std::to_string(pid_) + ")");
}

std::optional<Result<>> RootMachine::TrialBootEnd() const {
  const auto state = root_.LoadState();
  if (!state || state->on_trial_boot) return std::nullopt;
  if (state->last && state->last->kept) return Result<>(Ok());
  const std::string why = state->last ? state->last->reason : "the reason is unknown";
  return Result<>(FaultError(ota::Fault::kRolledBack, why));
}

Result<> RootMachine::AwaitTrialBoot() {
  const auto process = OpenPidfd(pid_);
  if (!process) return process.error();
  bool ended = false;
  const auto watch = link_->loop().WhenReadable(process.value().get(), [&ended] { ended = true; });
  const UniqueFd changes(inotify_init1(IN_CLOEXEC | IN_NONBLOCK));
  if (inotify_add_watch(changes.get(), root_.path().c_str(), IN_MOVED_TO) < 0) {
    return SystemError("can't watch " + root_.path());
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
  const std::string later = "; `musher ota status` shows its outcome";
  if (ended) return Error{kCodeFailed, ControllerExited()};
  if (link_->interrupted())
    return Error{kCodeFailed, "interrupted; the trial boot continues" + later};
  return Error{kCodeTimeout, "the trial boot has not ended in time" + later};
}

std::string RootMachine::ControllerExited() const {
  const auto state = root_.LoadState();
  if (state && state->on_trial_boot && !state->started) {
    return fmt::format(
        "the controller exited before the trial boot, which waits for `musher down` and the next "
        "start: musher up {}",
        ShellWord(root_.path()));
  }
  return fmt::format(
      "the controller exited during the trial boot; the next `musher up {}` rolls back",
      ShellWord(root_.path()));
}

// Waits until the machine of the confirmed version is up, or has failed to start.
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
