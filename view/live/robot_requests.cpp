#include "musher/view/live/robot_requests.hpp"

#include <algorithm>
#include <utility>

#include "musher/controller/storage/machines_here.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/live/machine_feed.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view {
namespace {

constexpr Duration kStopPeriod = Milliseconds(50);
constexpr Duration kStopKept = std::chrono::minutes(1);  // as by `musher estop`

void RespondJson(const http::Respond& respond, std::string json) {
  http::Response response;
  response.body = std::make_shared<const std::string>(std::move(json));
  respond(std::move(response));
}

void RespondCode(const http::Respond& respond, std::int32_t code, const std::string& reason) {
  RespondJson(respond, R"({"code":)" + std::to_string(code) + R"(,"reason":)" +
                           http::JsonText(reason) + "}");
}

// "musher_msgs::srv::dds_::GetPlan_" gives "musher_msgs::srv::dds_::GetPlan_Response_".
template <msg::Service S>
std::string ResponseType() {
  return std::string(S::kTypeName) + "Response_";
}

// Which actuators do not stand, as a sentence; empty: all do.
std::string NotStopped(const EstopReport& report) {
  std::string sentence;
  for (const EstopReport::Actuator& actuator : report.actuators) {
    if (actuator.stopped) continue;
    sentence += (sentence.empty() ? "not stopped: " : ", ") + actuator.name;
    if (!actuator.trouble.empty()) sentence += " (" + actuator.trouble + ")";
  }
  if (!report.unknown.empty()) sentence += (sentence.empty() ? "" : "; ") + report.unknown;
  return sentence;
}

}  // namespace

RobotRequests::RobotRequests(transport::Node& node, Options options, Leader leader)
    : node_(node), options_(std::move(options)), leader_(std::move(leader)) {}

template <msg::Service S>
void RobotRequests::Answer(const http::Respond& respond, const typename S::Response& response) {
  auto text = json_.ToJson(ResponseType<S>(), transport::internal::EncodeEnvelope({}, response));
  if (!text) return respond(http::ErrorResponse(500, text.error().code, text.error().message));
  RespondJson(respond, std::move(text).value());
}

LeaderWatch::Options RobotRequests::LeaderOptions() {
  LeaderWatch::Options leader{options_.name_space, options_.host, WatchByPidfd(node_.loop())};
  leader.machine = leader_().machine();
  return leader;
}

bool RobotRequests::HasController(const http::Respond& respond) {
  if (status()) return true;
  respond(http::ErrorResponse(503, kCodeNetError, "no controller leads the machine"));
  return false;
}

bool RobotRequests::HasActuator(const std::string& actuator, const http::Respond& respond) {
  if (!HasController(respond)) return false;
  const auto& actuators = status()->actuators;
  const bool known = std::any_of(actuators.begin(), actuators.end(),
                                 [&](const auto& each) { return each.name == actuator; });
  if (known) return true;
  respond(http::ErrorResponse(404, kCodeParametersInvalid,
                              "the machine has no actuator '" + actuator + "'"));
  return false;
}

template <msg::Service S>
void RobotRequests::Call(const std::string& service, const typename S::Request& request,
                         Duration timeout, const http::Respond& respond) {
  if (!HasController(respond)) return;
  typename S::Request meant = request;
  meant.machine = leader_().machine().name;
  meant.machine_id = leader_().machine().id;
  std::shared_ptr<void>& kept = clients_[service];
  if (!kept) {
    auto made =
        transport::MakeClient<S>(node_, transport::MachineService(options_.name_space, service));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    kept = std::shared_ptr<transport::Client<S>>(std::move(made).value());
  }
  static_cast<transport::Client<S>*>(kept.get())
      ->Call(
          meant, timeout,
          [this, respond](const Result<typename S::Response>& answer) {
            if (answer) return Answer<S>(respond, answer.value());
            respond(
                http::ErrorResponse(504, answer.error().code,
                                    "the controller has not answered: " + answer.error().message));
          },
          leader_().participant());
}

void RobotRequests::Plan(const std::string& target, const std::string& actuator,
                         const http::Respond& respond) {
  Call<msg::GetPlan>("get_plan", {target, actuator}, kAnswerTime, respond);
}

void RobotRequests::Set(const std::string& by, const std::string& target,
                        const std::string& actuator, const http::Respond& respond) {
  if (!HasController(respond)) return;
  std::erase_if(switches_, [](const Switch& each) { return each.ended; });
  SwitchClient::Options options;
  options.leader = LeaderOptions();
  options.by = by + " on the page";
  options.timeout = kSwitchTime;
  options.find = kAnswerTime;
  Switch& one = switches_.emplace_back();
  auto client = SwitchClient::Make(
      node_, options, target, actuator, [](const std::string&) {},
      [this, &one, respond](const SwitchEnd& end) {
        one.ended = true;
        if (end.kind != SwitchEnd::Kind::kUnknown) {
          return Answer<msg::SetState>(respond, end.result);
        }
        respond(http::ErrorResponse(504, end.result.code, end.result.reason));
      });
  if (!client) {
    switches_.pop_back();
    return respond(http::ErrorResponse(500, client.error().code, client.error().message));
  }
  one.client = std::move(client).value();
}

void RobotRequests::Restart(const std::string& by, const std::string& actuator,
                            const http::Respond& respond) {
  if (!HasActuator(actuator, respond)) return;
  std::erase_if(restarts_, [](const Restarting& each) { return each.ended; });
  Restarting& one = restarts_.emplace_back();
  auto call = LeaderCall<msg::RestartActuator>::Make(
      node_, LeaderOptions(), "restart_actuator", {actuator, by}, kRestartTime,
      [this, &one, respond](const Result<msg::RestartActuator::Response>& answer) {
        one.ended = true;
        if (answer) return Answer<msg::RestartActuator>(respond, answer.value());
        respond(http::ErrorResponse(504, answer.error().code, answer.error().message));
      });
  if (!call) {
    restarts_.pop_back();
    return respond(http::ErrorResponse(500, call.error().code, call.error().message));
  }
  one.call = std::move(call).value();
}

void RobotRequests::Release(const std::string& by, const http::Respond& respond) {
  Call<msg::ReleaseEmergencyStop>("release_emergency_stop", {by}, kAnswerTime, respond);
}

void RobotRequests::Stop(const std::string& by, const std::string& reason,
                         const http::Respond& respond) {
  // The machine that the page shows; before one was found, every machine that receives it.
  msg::EmergencyStop stop = NewEmergencyStop(by, reason);
  stop.machine = leader_().machine().name;
  stop.machine_id = leader_().machine().id;
  auto latch = StopLatch::Begin(node_, options_.name_space, stop, options_.with_keys);
  if (!latch) {
    return respond(http::ErrorResponse(
        500, latch.error().code, "the emergency stop could not be sent: " + latch.error().message));
  }
  const Time now = node_.loop().Now();
  StopScope scope = options_.stops;  // read after the stop is published
  scope.machines = MachinesHere(scope.domain_id, scope.name_space);
  stops_.push_back(
      {std::move(latch).value(), respond, now + kStopTime, now + kStopKept, std::move(scope)});
  if (!stop_timer_) stop_timer_ = node_.loop().Every(kStopPeriod, [this] { LookAtStops(); });
}

void RobotRequests::OnStatus() {
  LookAtStops();
}

void RobotRequests::LookAtStops() {
  const Time now = node_.loop().Now();
  for (Stopping& stop : stops_) {
    if (!stop.respond) continue;
    const EstopReport report = stop.latch->Report(ViewFromHere(stop.scope, status()));
    const bool found = report.found();
    const bool over = now >= stop.answer_by;
    if (!over && !(found && stop.latch->IsOver(report))) continue;
    const http::Respond respond = std::exchange(stop.respond, nullptr);
    const std::string missing = NotStopped(report);
    if (!found) {
      respond(http::ErrorResponse(503, kCodeNetError,
                                  "neither a controller nor an actuator was there to stop"));
    } else if (!missing.empty()) {
      RespondCode(respond, kCodeFailed, missing);
    } else {
      RespondCode(respond, kCodeOk, "");
    }
  }
  std::erase_if(stops_, [now](const Stopping& stop) { return now >= stop.drop_at; });
  if (stops_.empty()) stop_timer_.reset();
}

void RobotRequests::History(std::uint32_t limit, const http::Respond& respond) {
  if (!HasController(respond)) return;
  std::shared_ptr<void>& kept = clients_["get_history"];
  if (!kept) {
    auto made = transport::MakeClient<msg::GetHistory>(
        node_, transport::MachineService(options_.name_space, "get_history"));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    kept = std::shared_ptr<transport::Client<msg::GetHistory>>(std::move(made).value());
  }
  static_cast<transport::Client<msg::GetHistory>*>(kept.get())
      ->Call(
          {0, limit, leader_().machine().name, leader_().machine().id}, kAnswerTime,
          [respond](const Result<msg::GetHistory::Response>& answer) {
            if (!answer) {
              return respond(http::ErrorResponse(504, answer.error().code, answer.error().message));
            }
            const msg::GetHistory::Response& history = answer.value();
            std::string text = R"({"error":)" + http::JsonText(history.error) + R"(,"entries":[)";
            for (std::size_t i = 0; i < history.entries.size(); ++i) {
              const bool named = i < history.events.size();
              text += (i > 0 ? "," : "") +
                      EntryJson(history.entries[i], named ? history.events[i] : "");
            }
            RespondJson(respond, text + "]}");
          },
          leader_().participant());
}

template <msg::Service S>
void RobotRequests::CallApplication(
    std::map<std::string, std::unique_ptr<transport::Client<S>>>& clients,
    const std::string& actuator, const std::string& service, const typename S::Request& request,
    const http::Respond& respond) {
  if (!HasActuator(actuator, respond)) return;
  auto& client = clients[actuator];
  if (!client) {
    auto made = transport::MakeClient<S>(
        node_, transport::ResolveName(options_.name_space, actuator + "/" + service));
    if (!made) return respond(http::ErrorResponse(500, made.error().code, made.error().message));
    client = std::move(made).value();
  }
  client->Call(request, kAnswerTime,
               [this, actuator, service, respond](const Result<typename S::Response>& answer) {
                 if (answer) return Answer<S>(respond, answer.value());
                 respond(http::ErrorResponse(
                     404, answer.error().code,
                     actuator + " does not answer " + service + ": " + answer.error().message));
               });
}

void RobotRequests::Behavior(const std::string& actuator, const std::string& format,
                             const http::Respond& respond) {
  CallApplication<msg::GetBehavior>(behaviors_, actuator, "get_behavior", {format, 50}, respond);
}

void RobotRequests::Tree(const std::string& actuator, const http::Respond& respond) {
  CallApplication<msg::GetTree>(trees_, actuator, "get_tree", {}, respond);
}

}  // namespace musher::view
