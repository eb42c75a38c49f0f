#include "musher/controller/controller_services.hpp"

#include <utility>

#include "musher/controller/journal_reader.hpp"
#include "musher/controller/wire.hpp"
#include "musher/lifecycle/plan.hpp"
#include "musher/transport/lifecycle_wire.hpp"

namespace musher {
namespace {

// Longer than any name in a valid config; a request with a longer one is refused unread.
constexpr std::size_t kLongestName = 256;
constexpr std::uint32_t kMostEntries = 1000;
constexpr Duration kFlushTimeout = std::chrono::seconds(1);

template <class S>
typename S::Response AnswerTo(const Result<>& result) {
  if (result) return {};
  return {result.error().code, result.error().message};
}

std::optional<Error> JudgeLengths(const msg::SetState::Request& request) {
  if (request.target.size() <= kLongestName && request.actuator.size() <= kLongestName) {
    return std::nullopt;
  }
  return Error{kCodeParametersInvalid,
               "a name of more than " + std::to_string(kLongestName) + " bytes is not one of ours"};
}

// With all that had happened when it was asked for, if the disk is well.
msg::GetHistory::Response History(Journal& journal, std::int64_t since_wall_ns,
                                  std::uint32_t limit) {
  static_cast<void>(journal.Flush(kFlushTimeout));
  msg::GetHistory::Response response;
  const auto reading =
      ReadJournal(journal.path(), since_wall_ns, limit == 0 ? kMostEntries : limit);
  if (!reading) {
    response.error = reading.error().message;
    return response;
  }
  response.error = reading.value().damage;
  for (const JournalEntry& entry : reading.value().entries) {
    response.entries.push_back(ToMessage(entry));
  }
  return response;
}

}  // namespace

ControllerServices::ControllerServices(transport::Node& node, ControllerShell& shell,
                                       Journal* journal)
    : node_(node), shell_(shell), journal_(journal) {}

Result<std::unique_ptr<ControllerServices>> ControllerServices::Make(transport::Node& node,
                                                                     ControllerShell& shell,
                                                                     Journal* journal) {
  std::unique_ptr<ControllerServices> services(new ControllerServices(node, shell, journal));
  if (auto opened = services->Open(); !opened) return opened.error();
  return services;
}

Result<> ControllerServices::Open() {
  const std::string& name_space = shell_.config().name_space;
  const auto open = [&]<class S>(std::unique_ptr<transport::Server<S>>& server, const char* name,
                                 typename transport::Server<S>::Handler handler) -> Result<> {
    auto made = transport::MakeServer<S>(node_, transport::MachineService(name_space, name),
                                         std::move(handler));
    if (!made) return made.error();
    server = std::move(made).value();
    return Ok();
  };
  if (auto r = open(set_state_, "set_state",
                    [this](const auto& request, auto reply) { OnSetState(request, reply); });
      !r) {
    return r;
  }
  if (auto r = open(restart_actuator_, "restart_actuator",
                    [this](const auto& request, auto reply) {
                      shell_.Restart(request.actuator, [reply](const Result<>& result) {
                        reply(AnswerTo<msg::RestartActuator>(result));
                      });
                    });
      !r) {
    return r;
  }
  if (auto r = open(release_emergency_stop_, "release_emergency_stop",
                    [this](const auto& request, auto reply) {
                      shell_.ReleaseEmergencyStop(
                          request.by.substr(0, kLongestName), [reply](const Result<>& result) {
                            reply(AnswerTo<msg::ReleaseEmergencyStop>(result));
                          });
                    });
      !r) {
    return r;
  }
  if (auto r = open(request_policy_, "request_policy",
                    [this](const auto& request, auto reply) { OnRequestPolicy(request, reply); });
      !r) {
    return r;
  }
  if (auto r = open(get_status_, "get_status",
                    [this](const auto&, auto reply) { reply({shell_.Status()}); });
      !r) {
    return r;
  }
  if (auto r = open(get_capabilities_, "get_capabilities",
                    [this](const auto&, auto reply) { reply(shell_.Capabilities()); });
      !r) {
    return r;
  }
  if (auto r = open(get_plan_, "get_plan",
                    [this](const auto& request, auto reply) { reply(OnGetPlan(request)); });
      !r) {
    return r;
  }
  return open(get_history_, "get_history",
              [this](const auto& request, auto reply) { OnGetHistory(request, std::move(reply)); });
}

void ControllerServices::OnSetState(const msg::SetState::Request& request,
                                    const transport::Server<msg::SetState>::Reply& reply) {
  if (const auto error = JudgeLengths(request)) {
    SwitchResult refusal;
    refusal.outcome = SwitchOutcome::kRefused;
    refusal.code = error->code;
    refusal.reason = error->message;
    refusal.state = shell_.machine().state;
    return reply(ToMessage(refusal));
  }
  std::optional<std::string> actuator;
  if (!request.actuator.empty()) actuator = request.actuator;
  shell_.SetState(request.target, actuator,
                  [reply](const SwitchResult& result) { reply(ToMessage(result)); });
}

void ControllerServices::OnRequestPolicy(
    const msg::RequestPolicy::Request& request,
    const transport::Server<msg::RequestPolicy>::Reply& reply) {
  const auto answer = [this, reply](const Result<>& result) {
    const Error end = result ? Error{kCodeOk, ""} : result.error();
    reply({end.code, end.message, shell_.machine().state});
  };
  const auto what = RequestOf(request.request);
  // A direct switch has a service of its own, which tells more.
  if (!what || *what == PolicyRequest::kSwitch || request.state.size() > kLongestName) {
    return answer(Error{kCodeParametersInvalid,
                        "unknown request '" + request.request.substr(0, kLongestName) + "'"});
  }
  shell_.AskPolicy({0, *what, request.state, request.seconds, request.enable}, answer);
}

msg::GetPlan::Response ControllerServices::OnGetPlan(const msg::GetPlan::Request& request) const {
  const MachineConfig& config = shell_.config();
  const auto only = config.IndexOf(request.actuator);
  auto error = JudgeLengths(request);
  if (!error && !request.actuator.empty() && !only) {
    error = Error{kCodeParametersInvalid, "unknown actuator '" + request.actuator + "'"};
  }
  if (!error) return ToMessage(config, MakePlan(config, shell_.machine(), request.target, only));
  msg::GetPlan::Response response;
  response.code = error->code;
  response.reason = error->message;
  response.state = shell_.machine().state;
  return response;
}

void ControllerServices::OnGetHistory(const msg::GetHistory::Request& request, HistoryReply reply) {
  msg::GetHistory::Response refusal;
  if (journal_ == nullptr)
    refusal.error = "this controller has no journal: its folder is not usable";
  if (reading_history_) refusal.error = "somebody else is being told the history; ask again";
  if (!refusal.error.empty()) return reply(refusal);
  reading_history_ = true;
  history_reader_ = std::jthread([this, request, reply = std::move(reply),
                                  alive = std::weak_ptr<bool>(alive_), &loop = node_.loop()] {
    auto response = History(*journal_, request.since_wall_ns, request.limit);
    loop.Post([this, alive, reply, response = std::move(response)] {
      if (alive.expired()) return;
      reading_history_ = false;
      reply(response);
    });
  });
}

}  // namespace musher
