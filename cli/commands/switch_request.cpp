#include "musher/cli/commands/switch_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/cli/commands/switch_progress.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/running_actuators.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/controller/client/switch_client.hpp"
#include "musher/lifecycle/machine/stored.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

constexpr Duration kSwitchTimeout = std::chrono::seconds(60);
// For the controller's last writes to a slow disk and for leaving the network.
constexpr Duration kControllerEnd = std::chrono::seconds(7);
// Longer than a service manager takes to start another controller, including its listening time.
constexpr Duration kSuccessor = std::chrono::seconds(6);
constexpr Duration kSecuredSuccessor = std::chrono::seconds(12);
constexpr Duration kLastStatus = Milliseconds(200);  // of a controller that has exited
// A save takes less on a disk that works.
constexpr Duration kSavedWithin = Milliseconds(1000);
// Between two looks at the names that processes of this host hold, or at what is saved.
constexpr Duration kLookAgain = Milliseconds(20);

// A switch continues when the client stops waiting: adds to the message which switch that is.
Failure WithSwitch(Failure failure, Link& link, const std::string& target) {
  if (failure.exit != ExitCode::kNoAnswer && failure.exit != ExitCode::kInterrupted) return failure;
  const auto& status = link.StatusTowards(target);
  if (status && status->target == target) {
    failure.switch_number = CommandNumber(status->switch_number);
    failure.error.message +=
        fmt::format("; switch {} to {} continues, `musher status` shows its outcome",
                    status->switch_number, target);
  } else if (status) {
    failure.error.message +=
        fmt::format("; a requested switch continues, its number is above {}: see `musher history`",
                    status->switch_number);
  }
  return failure;
}

using ActuatorsByName = std::map<std::string, RunningActuators::Actuator>;

// Without a status it is known by the name that its process holds on this host.
bool IsSilent(const RunningActuators::Actuator& actuator) {
  return !actuator.has_status && !actuator.child;
}

// Reports running actuators of an earlier config, or ones that the TearDown did not reach. Returns
// whether there are any.
bool ReportLeftBehind(ActuatorsByName running, Console& console) {
  if (running.empty()) return false;
  ActuatorsByName silent = running;
  std::erase_if(silent, [](const auto& one) { return !IsSilent(one.second); });
  std::erase_if(running, [](const auto& one) { return IsSilent(one.second); });
  std::string left;
  if (!running.empty()) {
    left = RunningNames(running) + (running.size() == 1 ? " still runs" : " still run") +
           " in this namespace; ";
  }
  if (!silent.empty()) {
    left += RunningNames(silent) + (silent.size() == 1 ? " holds its name and sends no status; "
                                                       : " hold their names and send no status; ");
  }
  console.PrintError(left + "`musher down --without-controller` stops what is left");
  return true;
}

// The time limits of a switch, by its plan. They are shown only, so nothing waits for the plan.
class SwitchLimits {
 public:
  SwitchLimits(Link& link, const GlobalOptions& global) : link_(link), global_(global) {}

  void Request(const std::string& target, const std::string& actuator) {
    auto client = transport::MakeClient<msg::GetPlan>(
        link_.node(), transport::MachineService(global_.name_space, "get_plan"));
    if (!client) return;
    plans_ = std::move(client).value();
    const MachineIdentity& machine = link_.machine();
    plans_->Call({target, actuator, machine.name, machine.id}, kSwitchTimeout, [this](auto reply) {
      if (!reply) return;
      for (const msg::PlanStep& step : reply.value().steps) steps_[step.name] = step;
    });
  }
  std::optional<Duration> Of(const std::string& actuator, const std::string& state) const {
    const auto step = steps_.find(actuator);
    if (step == steps_.end() || step->second.to != state || step->second.deadline_ms <= 0) {
      return std::nullopt;
    }
    return Milliseconds(step->second.deadline_ms);
  }

 private:
  Link& link_;
  const GlobalOptions& global_;
  std::map<std::string, msg::PlanStep> steps_;              // by actuator
  std::unique_ptr<transport::Client<msg::GetPlan>> plans_;  // last: its callback uses steps_
};

// A switch from its request to its printed outcome.
//
// The TearDown of the machine of this host is requested by the controller's socket: it waits for no
// discovery. Meanwhile the command joins the domain, for what it shows, and for a successor of a
// controller that exits before it has answered.
class SwitchCommand {
 public:
  SwitchCommand(std::string target, std::string actuator, const GlobalOptions& global,
                Console& console)
      : target_(std::move(target)),
        actuator_(std::move(actuator)),
        global_(global),
        console_(console),
        timeout_(global.timeout.value_or(kSwitchTimeout)),
        link_(Link::OpenForCalls(global, &console)),
        limits_(*link_, global),
        progress_(link_->loop(), console,
                  [this](const std::string& name, const std::string& state) {
                    return limits_.Of(name, state);
                  }) {}

  ExitCode Run() {
    if (const auto failure = RequestHere()) return console_.Fail(*failure);
    if (const auto failure = Follow(); failure && !here_) return console_.Fail(*failure);
    if (!here_) {
      if (auto requested = RequestByNetwork({}); !requested) {
        return console_.Fail(requested.error());
      }
    }
    const auto failure =
        link_->Await([this] { return end_ || failure_; },
                     [this] { return here_ || (client_ && client_->found()); }, timeout_);
    progress_.Hide();
    if (failure) return console_.Fail(WithSwitch(*failure, *link_, target_));
    if (failure_) return console_.Fail(*failure_);
    return Conclude();
  }

 private:
  bool TakesMachineDown() const { return target_ == kTearDown && actuator_.empty(); }

  // A stopped controller would obey only when it continues, after this command has given up.
  std::optional<Failure> RequestHere() {
    const pid_t holder = TakesMachineDown() ? link_->LeaderHere() : 0;
    if (holder == 0 || RunStateOf(holder) == ProcessRunState::kStopped) return std::nullopt;
    const auto status = link_->CallHere<msg::GetStatus>(
        "get_status", {}, std::min(timeout_, link_->discovery_of_one_here()),
        ExitCode::kNoController);
    if (!status) return std::nullopt;
    if (const auto* failure = std::get_if<Failure>(&*status)) {
      if (failure->exit == ExitCode::kInterrupted) return *failure;
      return std::nullopt;  // by the network, which says more of a controller that is silent
    }
    here_ = std::get<msg::GetStatus::Response>(*status).status;
    call_ = link_->BeginCallHere<msg::SetState>(
        "set_state", {target_, actuator_, UserAtHost(), here_->machine, here_->machine_id},
        [this](auto reply) { OnReplyHere(reply); });
    if (!call_) here_.reset();
    if (call_) link_->Choose({here_->machine, here_->machine_id});
    return std::nullopt;
  }

  void OnReplyHere(const Result<msg::SetState::Response>& reply) {
    if (reply) {
      end_ = SwitchEnd{SwitchEnd::Kind::kAnswered, reply.value()};
      return;
    }
    const Error& error = reply.error();
    if (error.code == kCodeNetError) {
      // It has exited. Its last status, with the outcome, may arrive after that.
      last_status_ = link_->loop().At(link_->loop().Now() + kLastStatus, [this, error] {
        RequestAgain(error, link_->last_leader() ? link_->last_leader() : here_);
      });
    } else if (error.code == kCodeUnSupport) {
      RequestAgain(error, std::nullopt);  // the request was not taken
    } else {
      FailUnknown(error);
    }
  }

  void RequestAgain(const Error& error, std::optional<msg::MachineStatus> exited) {
    const auto joined = link_->Join();
    const auto requested = joined ? RequestByNetwork(std::move(exited)) : joined;
    if (!requested) FailUnknown(error);
  }

  void FailUnknown(const Error& error) {
    failure_ = Failure{ExitCode::kUnknownEnd,
                       {error.code, "the controller: " + error.message +
                                        "; `musher up` with the same config takes control of what "
                                        "still runs"}};
  }

  // What is shown of the switch, and which actuators run.
  std::optional<Failure> Follow() {
    auto followed = link_->Join();
    if (!followed) return NotFollowed(followed.error());
    joined_ = link_->loop().Now();
    if (auto open = link_->ChooseMachine(Link::Purpose::kAct)) return open;
    followed = link_->FollowStatus([this](const auto& status) { progress_.Show(status); });
    if (!followed) return NotFollowed(followed.error());
    if (progress_.on()) limits_.Request(target_, actuator_);
    auto running =
        RunningActuators::Begin(link_->node(), global_.name_space, !global_.keys.empty());
    if (!running) return NotFollowed(running.error());
    running_ = std::move(running).value();
    running_->OnlyOf(link_->machine());
    return std::nullopt;
  }
  Failure NotFollowed(const Error& error) {
    not_followed_ = error.message;
    return {ExitCode::kUsage, error};
  }

  // `exited`: the controller that was called by its socket, and has exited before its reply.
  Result<> RequestByNetwork(std::optional<msg::MachineStatus> exited) {
    SwitchClient::Options options;
    options.leader = {global_.name_space, HostId(), WatchByPidfd(link_->loop())};
    options.leader.machine = link_->machine();
    options.by = UserAtHost();
    options.timeout = timeout_ + Link::kAfterAwait;  // Await() has the better error message
    options.successor = global_.keys.empty() ? kSuccessor : kSecuredSuccessor;
    options.exited = std::move(exited);
    auto client = SwitchClient::Make(
        link_->node(), options, target_, actuator_,
        [this](const std::string& news) { console_.PrintError(news); },
        [this](const SwitchEnd& known) { end_ = known; });
    if (!client) return client.error();
    client_ = std::move(client).value();
    return Ok();
  }

  ExitCode Conclude() {
    const msg::SetState::Response& result = end_->result;
    if (end_->kind == SwitchEnd::Kind::kUnknown) {
      return console_.Fail({ExitCode::kUnknownEnd,
                            {result.code, result.reason},
                            CommandNumber(result.switch_number)});
    }
    // The controller exits with its machine. Once this command returns, the next one may start.
    // Its status may be lost before the process exits, so the last known one identifies it.
    const auto leader = link_->last_leader() ? link_->last_leader() : here_;
    const bool down = TakesMachineDown() && result.state == kTearDown;
    const bool leads_on = down && leader && !link_->AwaitEndOf(*leader, kControllerEnd);
    if (leads_on) {
      console_.PrintError(
          fmt::format("the controller (pid {}) has not exited yet; the machine cannot be "
                      "started again until then",
                      leader->pid));
    }
    console_.Print(console_.mode().json ? SwitchJson(result)
                                        : SwitchText(result, console_.mode().colour));
    if (!actuator_.empty() && result.outcome != "refused") NameUnsaved();
    // With --machine what runs on this host may be of another machine.
    const bool of_this_host = global_.machine.empty() || (leader && leader->host == HostId());
    const bool left = down && IsAnyLeftBehind(of_this_host);
    if (leads_on && link_->interrupted()) return ExitCode::kInterrupted;
    if (result.outcome == "done") return left || leads_on ? ExitCode::kNotDone : ExitCode::kDone;
    console_.PrintError(SwitchError(result));
    return ExitCodeOfRefusal(result.outcome == "refused" ? result.code : kCodeFailed);
  }

  // The controller begins to save before it replies.
  void NameUnsaved() {
    std::string unsaved = UnsavedNow();
    const Time end = link_->loop().Now() + kSavedWithin;
    const auto has_failed = [&unsaved] { return unsaved.find(": ") != std::string::npos; };
    while (!unsaved.empty() && !has_failed() && link_->loop().Now() < end) {
      link_->RunUntil([] { return false; }, kLookAgain);
      if (link_->interrupted()) break;
      unsaved = UnsavedNow();
    }
    if (unsaved.empty()) return;
    console_.PrintError(
        fmt::format("not on disk: {}; a controller that is started again does not know what was "
                    "set, and may start {} or raise it",
                    unsaved, actuator_));
  }

  // What of the actuators the controller has not saved; empty: it has saved all.
  std::string UnsavedNow() {
    std::optional<msg::MachineStatus> status = link_->last_leader();
    const auto here =
        link_->CallHere<msg::GetStatus>("get_status", {}, kSavedWithin, ExitCode::kNoController);
    if (here && std::holds_alternative<msg::GetStatus::Response>(*here)) {
      status = std::get<msg::GetStatus::Response>(*here).status;
    }
    if (!status) return "";
    const auto unsaved = std::ranges::find_if(status->not_on_disk, [](const std::string& what) {
      return what.starts_with(StoredName(Stored::kActuators));
    });
    return unsaved == status->not_on_disk.end() ? "" : *unsaved;
  }

  // The machine may have been down before every actuator was discovered: those of this host hold
  // their names, others need the time of a discovery, twice that over a slow link.
  bool IsAnyLeftBehind(bool of_this_host) {
    if (!running_) {
      console_.PrintError("whether more actuators run in this namespace is not known: " +
                          not_followed_);
      return false;
    }
    const auto tick = link_->loop().Every(kLookAgain, [] {});
    const auto profile = transport::Profile({});
    if (!profile || profile.value() == TransportProfile::kLan) {
      const Time end = joined_ + link_->discovery();
      link_->RunUntil([] { return false; }, end - link_->loop().Now());
      link_->RunUntil([this] { return !running_->IsAnyAwaited(); },
                      end + link_->discovery() - link_->loop().Now());
    }
    link_->RunUntil(
        [this] {
          return std::ranges::all_of(running_->Now(),
                                     [](const auto& one) { return one.second.has_status; });
        },
        of_this_host ? link_->discovery() : Duration{});
    ActuatorsByName running = running_->Now();
    if (!of_this_host) {
      std::erase_if(running, [](const auto& one) { return !one.second.has_status; });
    }
    return ReportLeftBehind(std::move(running), console_);
  }

  const std::string target_;
  const std::string actuator_;
  const GlobalOptions& global_;
  Console& console_;
  const Duration timeout_;
  const std::unique_ptr<Link> link_;
  SwitchLimits limits_;
  SwitchProgress progress_;
  std::unique_ptr<RunningActuators> running_;
  std::string not_followed_;                // why `running_` is null
  Time joined_{};                           // the domain
  std::optional<msg::MachineStatus> here_;  // of the controller that is called by its socket
  std::optional<SwitchEnd> end_;
  std::optional<Failure> failure_;
  std::unique_ptr<SwitchClient> client_;
  transport::LoopHandlePtr last_status_;
  std::unique_ptr<transport::HostCall> call_;  // last: its callback uses all of the above
};

}  // namespace

ExitCode RequestSwitch(const std::string& target, const std::string& actuator,
                       const GlobalOptions& global, Console& console) {
  return SwitchCommand(target, actuator, global, console).Run();
}

}  // namespace musher::cli
