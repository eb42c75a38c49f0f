#include "musher/controller/shell/controller_services.hpp"

#include <utility>

#include "musher/controller/shell/switch_log.hpp"
#include "musher/controller/shell/wire.hpp"
#include "musher/lifecycle/refusal.hpp"
#include "musher/lifecycle/switch/plan.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

// Longer than any name in a valid config; a request with a longer one is refused unread.
constexpr std::size_t kLongestName = 256;
constexpr std::uint32_t kMostEntries = 1000;
// Clients query the outcome soon after the end of a controller; later entries are a fraction of
// these.
constexpr std::size_t kEntriesOfPredecessor = 5000;

template <class S>
typename S::Response AnswerTo(const Result<>& result) {
  if (result) return {};
  return {result.error().code, result.error().message};
}

std::optional<Error> CheckLengths(const std::string& target, const std::string& actuator) {
  if (target.size() <= kLongestName && actuator.size() <= kLongestName) {
    return std::nullopt;
  }
  return Refused<Refusal::kNameTooLong>(kLongestName);
}

// A client that names another machine has reached this controller because both serve one namespace.
template <class Request>
std::optional<Error> MeantForAnother(const ControllerShell& shell, const Request& request) {
  const MachineIdentity meant{request.machine.substr(0, kLongestName),
                              request.machine_id.substr(0, kLongestName)};
  const MachineIdentity ours = shell.machine_identity();
  if (SameMachine(ours, meant)) return std::nullopt;
  return Refused<Refusal::kRequestOfOtherMachine>(MachineText(meant), MachineText(ours));
}

msg::GetHistory::Response HistoryOf(const Result<JournalReading>& reading) {
  msg::GetHistory::Response response;
  if (!reading) {
    response.error = reading.error().message;
    return response;
  }
  response = ToMessage(reading.value().entries);
  response.error = reading.value().damage;
  return response;
}

}  // namespace

ControllerServices::ControllerServices(transport::Node& node, ControllerShell& shell,
                                       ReadHistory read_history,
                                       std::unique_ptr<transport::HostServer> here,
                                       const transport::RosNodes* ros_nodes)
    : node_(node),
      shell_(shell),
      read_history_(std::move(read_history)),
      here_(std::move(here)),
      ros_nodes_(ros_nodes) {}

Result<std::unique_ptr<ControllerServices>> ControllerServices::Make(
    transport::Node& node, ControllerShell& shell, ReadHistory read_history,
    std::unique_ptr<transport::HostServer> here, const transport::RosNodes* ros_nodes) {
  std::unique_ptr<ControllerServices> services(
      new ControllerServices(node, shell, std::move(read_history), std::move(here), ros_nodes));
  if (auto opened = services->Open(); !opened) return opened.error();
  return services;
}

template <class S>
Result<> ControllerServices::Serve(std::unique_ptr<transport::Server<S>>& server, const char* name,
                                   Handler<S> handler) {
  typename transport::Server<S>::HandlerOfCaller for_us =
      [this, handler](const auto& request, auto reply, transport::ParticipantId caller) {
        if constexpr (requires { request.machine_id; }) {
          // Its controller receives the request, too, and answers.
          if (shell_.IsOtherMachine({request.machine, request.machine_id})) return;
        }
        (this->*handler)(request, reply, caller);
      };
  if (here_) here_->template Offer<S>(name, for_us);
  auto made = transport::MakeServer<S>(
      node_, transport::MachineService(shell_.config().name_space, name), std::move(for_us));
  if (!made) return made.error();
  server = std::move(made).value();
  return Ok();
}

Result<> ControllerServices::Open() {
  using Self = ControllerServices;
  auto opened = Serve(set_state_, "set_state", &Self::OnSetState);
  if (opened) opened = Serve(restart_actuator_, "restart_actuator", &Self::OnRestart);
  if (opened) opened = Serve(release_emergency_stop_, "release_emergency_stop", &Self::OnRelease);
  if (opened) opened = Serve(request_policy_, "request_policy", &Self::OnRequestPolicy);
  if (opened) opened = Serve(get_status_, "get_status", &Self::OnGetStatus);
  if (opened) opened = Serve(get_capabilities_, "get_capabilities", &Self::OnGetCapabilities);
  if (opened) opened = Serve(get_plan_, "get_plan", &Self::OnGetPlan);
  if (opened) opened = Serve(get_switch_, "get_switch", &Self::OnGetSwitch);
  if (opened) opened = Serve(get_history_, "get_history", &Self::OnGetHistory);
  return opened;
}

std::string ControllerServices::RequesterOf(const std::string& by, const char* service,
                                            transport::ParticipantId caller) const {
  if (!by.empty()) return by.substr(0, kLongestName);
  if (ros_nodes_ == nullptr) return node_.RosNodeOf(caller);
  return ros_nodes_->CallersOf(transport::MachineService(shell_.config().name_space, service),
                               caller);
}

void ControllerServices::OnSetState(const msg::SetState::Request& request,
                                    const Reply<msg::SetState>& reply,
                                    transport::ParticipantId caller) {
  auto error = CheckLengths(request.target, request.actuator);
  if (!error) error = MeantForAnother(shell_, request);
  if (!error) {
    const auto only = shell_.config().IndexOf(request.actuator);
    error = shell_.MayBeLate(State(request.target), only);
    if (error) shell_.RecordLate(State(request.target), only, *error);
  }
  if (error) {
    return reply(ToMessage(
        RefusedSwitch(State(request.target).Shortened(), "", shell_.machine().state, *error)));
  }
  std::optional<std::string> actuator;
  if (!request.actuator.empty()) actuator = request.actuator;
  shell_.SetState(State(request.target), actuator,
                  [this, reply](const SwitchResult& result) {
                    shell_.PublishStatus();
                    reply(ToMessage(result));
                  },
                  {RequesterOf(request.by, "set_state", caller)});
}

void ControllerServices::OnRestart(const msg::RestartActuator::Request& request,
                                   const Reply<msg::RestartActuator>& reply,
                                   transport::ParticipantId caller) {
  auto error = MeantForAnother(shell_, request);
  if (!error) {
    error = shell_.MayBeLate();
    if (error) shell_.RecordLateRestart(request.actuator, *error);
  }
  if (error) return reply(AnswerTo<msg::RestartActuator>(*error));
  shell_.Restart(request.actuator, RequesterOf(request.by, "restart_actuator", caller),
                 [this, reply](const Result<>& result) {
                   shell_.PublishStatus();
                   reply(AnswerTo<msg::RestartActuator>(result));
                 });
}

void ControllerServices::OnRelease(const msg::ReleaseEmergencyStop::Request& request,
                                   const Reply<msg::ReleaseEmergencyStop>& reply,
                                   transport::ParticipantId caller) {
  auto error = MeantForAnother(shell_, request);
  if (!error) {
    error = shell_.MayBeLate();
    if (error) shell_.RecordLateRelease(*error);
  }
  if (error) return reply(AnswerTo<msg::ReleaseEmergencyStop>(*error));
  std::vector<StopId> seen;
  for (const std::string& id : request.seen_stops) seen.push_back(transport::ReadStopId(id));
  const auto done = [this, reply](const Result<>& result) {
    shell_.PublishStatus();
    reply(AnswerTo<msg::ReleaseEmergencyStop>(result));
  };
  shell_.ReleaseEmergencyStop(RequesterOf(request.by, "release_emergency_stop", caller), done,
                              std::move(seen));
}

void ControllerServices::OnRequestPolicy(const msg::RequestPolicy::Request& request,
                                         const Reply<msg::RequestPolicy>& reply,
                                         transport::ParticipantId caller) {
  const auto answer = [this, reply](const Result<>& result) {
    const Error end = result ? Error{kCodeOk, ""} : result.error();
    shell_.PublishStatus();
    reply({end.code, end.message, shell_.machine().state});
  };
  if (const auto error = MeantForAnother(shell_, request)) return answer(*error);
  const auto what = RequestOf(request.request);
  // A direct switch has a service of its own, whose reply has more detail.
  if (!what || *what == PolicyRequest::kSwitch || request.state.size() > kLongestName) {
    return answer(Refused<Refusal::kUnknownRequest>(request.request.substr(0, kLongestName)));
  }
  // Without a stay that it ends, a keep of no time is a switch.
  const bool ends_stay = request.seconds == 0 && shell_.machine().policy.keep.has_value();
  const bool leads_out = WakesUp(*what, request.enable) || *what == PolicyRequest::kOta ||
                         (*what == PolicyRequest::kKeep && !ends_stay);
  const event::PolicyRequested requested{0,
                                         *what,
                                         State(request.state),
                                         request.seconds,
                                         request.enable,
                                         RequesterOf(request.by, "request_policy", caller)};
  if (const auto late = shell_.MayBeLate(); late && leads_out) {
    shell_.RecordLate(requested, *late);
    return answer(*late);
  }
  shell_.SendPolicyRequest(requested, answer);
}

void ControllerServices::OnGetStatus(const msg::GetStatus::Request& /*request*/,
                                     const Reply<msg::GetStatus>& reply,
                                     transport::ParticipantId /*caller*/) {
  reply({shell_.Status()});
}

void ControllerServices::OnGetCapabilities(const msg::GetCapabilities::Request& /*request*/,
                                           const Reply<msg::GetCapabilities>& reply,
                                           transport::ParticipantId /*caller*/) {
  reply({shell_.Capabilities().capabilities});
}

void ControllerServices::OnGetPlan(const msg::GetPlan::Request& request,
                                   const Reply<msg::GetPlan>& reply,
                                   transport::ParticipantId /*caller*/) {
  const MachineConfig& config = shell_.config();
  const auto only = config.IndexOf(request.actuator);
  auto error = CheckLengths(request.target, request.actuator);
  if (!error) error = MeantForAnother(shell_, request);
  if (!error && !request.actuator.empty() && !only) {
    error = UnknownActuator(request.actuator, config);
  }
  if (!error) {
    const Plan plan = MakePlan(config, shell_.machine(), State(request.target), only);
    return reply(ToMessage(config, plan));
  }
  msg::GetPlan::Response response;
  response.target = State(request.target).Shortened();
  response.actuator = request.actuator.substr(0, kLongestName);
  response.code = error->code;
  response.reason = error->message;
  if (request.actuator.empty()) response.state = shell_.machine().state;
  reply(response);
}

// Own switches are in memory, switches of an earlier controller in the journal, if both use one.
void ControllerServices::OnGetSwitch(const msg::GetSwitch::Request& request,
                                     const Reply<msg::GetSwitch>& reply,
                                     transport::ParticipantId /*caller*/) {
  const Epoch own = shell_.machine().epoch;
  const Epoch epoch(request.epoch);
  const CommandNumber number(request.switch_number);
  msg::GetSwitch::Response known = FindSwitch(shell_.switches(), epoch, number);
  if (const auto error = MeantForAnother(shell_, request)) {
    msg::GetSwitch::Response refusal;
    refusal.reason = error->message;
    return reply(refusal);
  }
  if (known.found) {
    if (known.outcome.empty()) known.outcome = msg::GetSwitch::kUnderWay;
    return reply(known);
  }
  if (epoch >= own) {
    known.reason = "the controller of epoch " + ToString(own) + " has no such switch";
    known.state = shell_.machine().state;
    return reply(known);
  }
  if (!read_history_) return ReplyInterrupted(std::move(known), reply);
  read_history_(
      INT64_MIN, kEntriesOfPredecessor,
      [this, epoch, number, reply, alive = std::weak_ptr<bool>(alive_)](const auto& reading) {
        if (alive.expired()) return;
        const auto entries = reading ? reading.value().entries : std::vector<JournalEntry>();
        auto found = FindSwitch(entries, epoch, number);
        if (!found.outcome.empty()) return reply(found);
        ReplyInterrupted(std::move(found), reply);
      });
}

// Once this controller knows the machine's state: it continues from the actuators' states.
void ControllerServices::ReplyInterrupted(msg::GetSwitch::Response response,
                                          const Reply<msg::GetSwitch>& reply) {
  shell_.AwaitSetUp(
      [this, response, reply, alive = std::weak_ptr<bool>(alive_)](const Result<>&) mutable {
        if (alive.expired()) return;
        const std::string before = "the controller of epoch " + std::to_string(response.epoch);
        response.state = shell_.machine().state;
        response.code = kCodeNetError;
        const bool begun = response.found && response.switch_number != 0;
        response.outcome = begun ? msg::GetSwitch::kInterrupted : "";
        response.reason = (begun ? before + " ended during it"
                                 : "no such switch of " + before + " is recorded here") +
                          "; the controller of epoch " + ToString(shell_.machine().epoch) +
                          " continues with the machine in " + response.state;
        reply(response);
      });
}

void ControllerServices::OnGetHistory(const msg::GetHistory::Request& request,
                                      const Reply<msg::GetHistory>& reply,
                                      transport::ParticipantId /*caller*/) {
  if (const auto error = MeantForAnother(shell_, request)) return reply({error->message, {}});
  if (!read_history_) {
    return reply({"this controller has no journal: its folder is not usable", {}});
  }
  const std::size_t limit = request.limit == 0 ? kMostEntries : request.limit;
  read_history_(request.since_wall_ns, limit,
                [reply](const auto& reading) { reply(HistoryOf(reading)); });
}

}  // namespace musher
