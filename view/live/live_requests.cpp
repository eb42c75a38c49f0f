// The requests of a page: files, API, login.

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/view/http/assets.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/live/live_server.hpp"
#include "musher/view/live/log_text.hpp"
#include "musher/view/page/files.hpp"

namespace musher::view {
namespace {

using RequestJson = nlohmann::json;

constexpr const char* kCookie = "musher_view";
constexpr unsigned kNormalClosure = 1000;
constexpr std::uint32_t kMostHistory = 10'000;
constexpr std::int32_t kNeedsLogin = kCodePermissionDenied;

std::string Parameter(const http::Request& request, const std::string& name) {
  const auto found = request.query.find(name);
  return found == request.query.end() ? "" : found->second;
}

std::int64_t NumberIn(const http::Request& request, const std::string& name,
                      std::int64_t otherwise) {
  const std::string text = Parameter(request, name);
  std::int64_t number = otherwise;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() ? number : otherwise;
}

// The text of a field of a JSON object; "" where it is missing.
std::string TextIn(const RequestJson& body, const char* name) {
  const auto found = body.find(name);
  return found != body.end() && found->is_string() ? found->get<std::string>() : "";
}

// {"action":…,"actuator":…,"skill":…,"parameters":{"x_m":"1.5"}}
SkillRequests::Request SkillIn(const RequestJson& body) {
  SkillRequests::Request request{
      TextIn(body, "action"), TextIn(body, "actuator"), TextIn(body, "skill"), {}};
  const auto parameters = body.find("parameters");
  if (parameters == body.end() || !parameters->is_object()) return request;
  for (const auto& [key, value] : parameters->items()) {
    request.parameters.push_back(
        {key, value.is_string() ? value.get<std::string>() : value.dump()});
  }
  return request;
}

http::Response JsonResponse(std::string json) {
  http::Response response;
  response.body = std::make_shared<const std::string>(std::move(json));
  return response;
}

// Of a code, PIN or token.
http::Response RefusalResponse(const Error& error) {
  return http::ErrorResponse(error.code == kCodeTargetBusy ? 429 : 403, error.code, error.message);
}

http::Response WithSession(http::Response response, const std::string& session) {
  response.headers.emplace_back(
      "Set-Cookie", std::string(kCookie) + "=" + session + "; HttpOnly; SameSite=Strict; Path=/");
  return response;
}

http::Response Redirect(const std::string& path) {
  http::Response response;
  response.status = 303;
  response.headers.emplace_back("Location", path);
  return response;
}

}  // namespace

std::string LiveServer::PersonOf(const http::Request& request) {
  const auto cookie = request.cookies.find(kCookie);
  if (cookie == request.cookies.end()) return "";
  return login_.Find(cookie->second, node_.loop().Now()).value_or("");
}

bool LiveServer::HasToken(const http::Request& request) {
  const std::string token = Parameter(request, "token");
  return !token.empty() && login_.MayMakeLinks(token, request.peer, node_.loop().Now()).ok();
}

bool LiveServer::MayLook(const http::Request& request) {
  return request.local || !PersonOf(request).empty();
}

void LiveServer::OnRequest(const http::Request& request, const http::Respond& respond) {
  if (request.path == "/login") return OnLogin(request, respond);
  if (request.path == "/api/link") return OnLink(request, respond);
  if (request.path == "/api/login") return OnPin(request, respond);
  if (request.path == "/api/logout") return OnLogout(request, respond);
  // The page's files tell nothing of the robot, and show how to log in.
  if (request.method == "GET") {
    if (auto file = http::AssetResponse(PageFiles(), request)) return respond(*std::move(file));
    if (auto file = docs_.Respond(request)) return respond(*std::move(file));
  }
  // A person who sees a robot do harm has no time to log in.
  const bool stop = request.method == "POST" && request.path == "/api/estop";
  if (stop && !options_.stop_needs_login) return OnPost(request, respond);
  if (!MayLook(request)) {
    return respond(http::ErrorResponse(
        401, kNeedsLogin, "looking from another host needs a login: musher view --link"));
  }
  return request.method == "GET" ? OnGet(request, respond) : OnPost(request, respond);
}

void LiveServer::OnGet(const http::Request& request, const http::Respond& respond) {
  const std::string& path = request.path;
  if (path == "/api/history") {
    const auto limit = std::clamp<std::int64_t>(NumberIn(request, "limit", 1000), 1, kMostHistory);
    return requests_->History(static_cast<std::uint32_t>(limit), respond);
  }
  if (path == "/api/behavior") {
    return requests_->Behavior(Parameter(request, "name"), Parameter(request, "format"), respond);
  }
  if (path == "/api/tree") return requests_->Tree(Parameter(request, "name"), respond);
  if (path == "/api/log") return OnLog(request, respond);
  if (path == "/api/topics") {
    http::Response response;
    response.body = TopicsMessage();
    return respond(std::move(response));
  }
  if (path == "/camera") {
    const auto width = std::clamp<std::int64_t>(NumberIn(request, "width", 0), 0, 4096);
    return cameras_.Get(Parameter(request, "topic"), NumberIn(request, "after_ms", 0),
                        static_cast<int>(width), respond);
  }
  if (path == "/metrics") {
    const auto accept = request.headers.find("accept");
    const MetricsFormat format = FormatFor(accept == request.headers.end() ? "" : accept->second);
    return metrics_->Scrape(format, [format, respond](const Result<std::string>& text) {
      if (!text) {
        return respond(http::ErrorResponse(503, text.error().code, text.error().message));
      }
      http::Response response;
      response.content_type = ContentTypeOf(format);
      response.body = std::make_shared<const std::string>(text.value());
      respond(std::move(response));
    });
  }
  respond(http::ErrorResponse(404, kCodeParametersInvalid, "there is nothing at " + path));
}

void LiveServer::OnPost(const http::Request& request, const http::Respond& respond) {
  const RequestJson body = RequestJson::parse(request.body, nullptr, false);
  if (!body.is_object()) {
    return respond(
        http::ErrorResponse(400, kCodeParametersInvalid, "the body has to be a JSON object"));
  }
  const std::string target = TextIn(body, "target");
  const std::string actuator = TextIn(body, "actuator");
  if (request.path == "/api/plan") return requests_->Plan(target, actuator, respond);
  std::string person = PersonOf(request);
  if (person.empty() && request.path == "/api/estop" && !options_.stop_needs_login) {
    person = "a person without a login (" + request.peer + ")";
  }
  if (person.empty()) {
    return respond(http::ErrorResponse(
        403, kNeedsLogin,
        "acting needs a login; `musher view --link` prints a link and a PIN for one"));
  }
  if (request.path == "/api/set") return requests_->Set(person, target, actuator, respond);
  if (request.path == "/api/estop") {
    return requests_->Stop(person, TextIn(body, "reason"), respond);
  }
  if (request.path == "/api/release") return requests_->Release(person, respond);
  if (request.path == "/api/restart") return requests_->Restart(person, actuator, respond);
  if (request.path == "/api/skill") return skills_.Run(SkillIn(body), respond);
  if (request.path == "/api/cancel_skill") {
    return skills_.Cancel(TextIn(body, "action"), TextIn(body, "goal_id"), respond);
  }
  respond(http::ErrorResponse(404, kCodeParametersInvalid, "there is nothing at " + request.path));
}

// Opens a session; the code is in the link only.
void LiveServer::OnLogin(const http::Request& request, const http::Respond& respond) {
  const auto session = login_.Redeem(Parameter(request, "code"), request.peer, node_.loop().Now());
  if (!session) {
    Error error = session.error();
    error.message += "; `musher view --link` prints another link";
    return respond(RefusalResponse(error));
  }
  KeepSessions();
  respond(WithSession(Redirect("/"), session.value()));
}

// POST {"pin":"482103"}, which a person types on the page.
void LiveServer::OnPin(const http::Request& request, const http::Respond& respond) {
  const RequestJson body = RequestJson::parse(request.body, nullptr, false);
  if (request.method != "POST" || !body.is_object()) {
    return respond(
        http::ErrorResponse(400, kCodeParametersInvalid, R"(POST {"pin":"..."} opens a session)"));
  }
  const auto session = login_.RedeemPin(TextIn(body, "pin"), request.peer, node_.loop().Now());
  if (!session) return respond(RefusalResponse(session.error()));
  KeepSessions();
  respond(WithSession(JsonResponse("{}"), session.value()));
}

// Ends the session of the cookie; all sessions with {"all":true} and a login, or with the token.
// Pages of ended sessions look on without the login, where they may.
void LiveServer::OnLogout(const http::Request& request, const http::Respond& respond) {
  const RequestJson body = RequestJson::parse(request.body, nullptr, false);
  if (request.method != "POST" || !body.is_object()) {
    return respond(http::ErrorResponse(400, kCodeParametersInvalid,
                                       R"(POST {} ends the session, {"all":true} all of them)"));
  }
  if (body.contains("token")) {
    const auto permitted =
        login_.MayMakeLinks(TextIn(body, "token"), request.peer, node_.loop().Now());
    if (!permitted) return respond(RefusalResponse(permitted.error()));
    login_.EndAll();
  } else if (body.value("all", RequestJson()) == true) {
    if (PersonOf(request).empty()) {
      return respond(http::ErrorResponse(403, kNeedsLogin, "to end all logins needs a login"));
    }
    login_.EndAll();
  } else if (const auto cookie = request.cookies.find(kCookie); cookie != request.cookies.end()) {
    login_.End(cookie->second);
  }
  KeepSessions();
  CloseEndedSessions();
  http::Response response = JsonResponse("{}");
  response.headers.emplace_back(
      "Set-Cookie", std::string(kCookie) + "=; Max-Age=0; HttpOnly; SameSite=Strict; Path=/");
  respond(std::move(response));
}

// The connections that they have opened.
void LiveServer::CloseEndedSessions() {
  std::vector<std::shared_ptr<http::WebSocket>> sockets;
  for (const Page& page : pages_) sockets.push_back(page.socket);
  for (const auto& acting : acting_) {
    if (auto socket = acting.lock()) sockets.push_back(std::move(socket));
  }
  for (const auto& socket : sockets) {
    const auto cookie = socket->request().cookies.find(kCookie);
    const bool ended = cookie != socket->request().cookies.end() &&
                       !login_.Lives(cookie->second, node_.loop().Now());
    if (ended) socket->Close(kNormalClosure, "the login has ended");
  }
}

// For `musher view --link`, which has read the token file.
void LiveServer::OnLink(const http::Request& request, const http::Respond& respond) {
  const RequestJson body = RequestJson::parse(request.body, nullptr, false);
  if (request.method != "POST" || !body.is_object()) {
    return respond(http::ErrorResponse(400, kCodeParametersInvalid,
                                       R"(POST {"token":"...","name":"..."} gives a link)"));
  }
  const auto permitted =
      login_.MayMakeLinks(TextIn(body, "token"), request.peer, node_.loop().Now());
  if (!permitted) return respond(RefusalResponse(permitted.error()));
  const http::LoginLink link = NewLink(TextIn(body, "name"));
  respond(JsonResponse(R"({"path":)" + http::JsonText(link.path) + R"(,"pin":)" +
                       http::JsonText(link.pin) + R"(,"outside":)" + http::JsonText(link.outside) +
                       "}"));
}

Result<std::string> LiveServer::LogFileOf(const std::string& actuator) {
  const std::optional<msg::MachineStatus>& status = feed_->last_status();
  if (!status) return Error{kCodeNetError, "no controller has led since this page is served"};
  const auto& actuators = status->actuators;
  const bool known = actuator == "controller" ||
                     std::any_of(actuators.begin(), actuators.end(),
                                 [&](const auto& each) { return each.name == actuator; });
  if (!known) {
    return Error{kCodeParametersInvalid, "the machine has no actuator '" + actuator + "'"};
  }
  std::string folder = options_.logs;
  std::string of_controller = folder + "/../controller.log";
  if (folder.empty()) {
    if (status->host != HostId()) {
      return Error{kCodeUnSupport, "the logs are on the host of the controller"};
    }
    const auto config = ReadValidConfig(status->config_file);
    if (!config) return config.error();
    folder = config.value().state_dir + "/logs";
    of_controller = config.value().log.empty() ? config.value().state_dir + "/controller.log"
                                               : config.value().log;
  }
  return actuator == "controller" ? of_controller : folder + "/" + actuator + ".log";
}

void LiveServer::OnLog(const http::Request& request, const http::Respond& respond) {
  const auto file = LogFileOf(Parameter(request, "actuator"));
  if (!file) return respond(http::ErrorResponse(404, file.error().code, file.error().message));
  const auto piece = ReadLog(file.value(), NumberIn(request, "from", -kMostLogBytes));
  if (!piece) return respond(http::ErrorResponse(404, piece.error().code, piece.error().message));
  http::Response response;
  response.body = std::make_shared<const std::string>(
      R"({"from":)" + std::to_string(piece.value().from) + R"(,"to":)" +
      std::to_string(piece.value().to) + R"(,"size":)" + std::to_string(piece.value().size) +
      R"(,"text":)" + http::JsonText(piece.value().text) + "}");
  respond(std::move(response));
}

}  // namespace musher::view
