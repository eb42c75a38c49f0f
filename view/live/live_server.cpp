#include "musher/view/live/live_server.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/log.hpp"
#include "musher/base/version.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/storage/machines_here.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/transport/network.hpp"
#include "musher/view/http/access.hpp"
#include "musher/view/http/assets.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/http/session_file.hpp"
#include "musher/view/json/json.hpp"
#include "musher/view/live/log_text.hpp"
#include "musher/view/live/outside_url.hpp"
#include "musher/view/live/request_age.hpp"
#include "musher/view/live/request_fields.hpp"
#include "musher/view/page/files.hpp"

namespace musher::view {
namespace {

constexpr const char* kSubprotocol = "musher.view.v1";
constexpr Duration kTopicsDelay = Milliseconds(100);        // what is discovered comes together
constexpr Duration kKeepPeriod = std::chrono::minutes(10);  // of the times of the last requests
constexpr unsigned kPolicyViolation = 1008;

SharedText Share(const OrderedJson& json) {
  return std::make_shared<const std::string>(Dumped(json));
}

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
std::string TextIn(const Json& body, const char* name) {
  const auto found = body.find(name);
  return found != body.end() && found->is_string() ? found->get<std::string>() : "";
}

// The texts of a field of a JSON object; none where it is missing.
std::vector<std::string> TextsIn(const Json& body, const char* name) {
  std::vector<std::string> texts;
  const auto found = body.find(name);
  if (found == body.end() || !found->is_array()) return texts;
  for (const Json& one : *found) texts.push_back(one.is_string() ? one.get<std::string>() : "");
  return texts;
}

bool IsFlat(const Json& value) {
  return value.is_primitive() ||
         (value.is_array() && std::all_of(value.begin(), value.end(),
                                          [](const Json& one) { return one.is_primitive(); }));
}

// Of a skill. A value that is nested a million times would overflow the stack of what prints it.
bool HasFlatParameters(const Json& body) {
  const auto parameters = body.find("parameters");
  return parameters == body.end() || !parameters->is_object() ||
         std::all_of(parameters->begin(), parameters->end(), IsFlat);
}

// {"action":…,"actuator":…,"skill":…,"parameters":{"x_m":"1.5"}}
SkillRequests::Request SkillIn(const Json& body) {
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

// Whether it may raise or move the robot. A stop, a pause and a cancellation are never too late.
bool MayMove(const std::string& path, const Json& body,
             const std::optional<msg::MachineStatus>& status) {
  if (path == "/api/set") {
    return !status || !OnlyLowers(*status, TextIn(body, "target"), TextIn(body, "actuator"));
  }
  if (path == "/api/pause_skill") return body.value("pause", Json()) == false;
  return path == "/api/release" || path == "/api/restart" || path == "/api/skill";
}

// Whether a request that moves is too late. One without a time, of a script, is obeyed.
Result<> CheckAgeIn(const Json& body) {
  const auto seen = body.find("seen_uptime_ms");
  if (seen == body.end()) return Ok();
  if (!seen->is_number_integer()) {
    return Error{kCodeParametersInvalid,
                 "seen_uptime_ms is not the number that the server has sent"};
  }
  return CheckAge(seen->get<std::int64_t>(), ToMilliseconds(SinceBoot()));
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

http::Response WithSession(http::Response response, const std::string& cookie,
                           const std::string& session) {
  response.headers.emplace_back("Set-Cookie",
                                cookie + "=" + session + "; HttpOnly; SameSite=Strict; Path=/");
  return response;
}

// Empty: no session is kept.
SessionSaver::Write WriterOf(const std::string& file) {
  if (file.empty()) return nullptr;
  return [file](const std::vector<http::KeptSession>& sessions, std::int64_t wall_ms) {
    return http::WriteSessions(file, sessions, wall_ms);
  };
}

http::Response Redirect(const std::string& path) {
  http::Response response;
  response.status = 303;
  response.headers.emplace_back("Location", path);
  return response;
}

}  // namespace

LiveServer::LiveServer(transport::Node& node, Options options)
    : node_(node),
      options_(std::move(options)),
      login_(http::KernelRandom, options_.token),
      docs_(options_.docs),
      cameras_(node, table_),
      watched_(node, table_,
               [this](const std::string& topic, const WatchedTopics::Latest& latest) {
                 for (Page& page : pages_) {
                   if (page.watched.contains(topic)) Send(page, latest.key, latest.message);
                 }
               }),
      search_(node.loop(),
              [domain = options_.domain_id, name_space = options_.name_space] {
                return MachinesHere(domain, name_space);
              }),
      skills_(node, options_.name_space, options_.with_keys),
      meant_(node, options_.name_space, options_.with_keys),
      saver_(node.loop(), WriterOf(options_.sessions)) {}

Result<std::unique_ptr<LiveServer>> LiveServer::Make(transport::Node& node, Options options) {
  std::unique_ptr<LiveServer> server(new LiveServer(node, std::move(options)));
  if (auto opened = server->Open(); !opened) return opened.error();
  return server;
}

Result<> LiveServer::RestoreSessions() {
  if (options_.sessions.empty()) return Ok();
  const auto kept = http::ReadSessions(options_.sessions, WallMilliseconds());
  if (!kept) return kept.error();
  login_.Restore(kept.value(), node_.loop().Now());
  keep_timer_ = node_.loop().Every(kKeepPeriod, [this] {
    if (login_.sessions() > 0) KeepSessions();
  });
  return Ok();
}

Result<> LiveServer::WatchMachine() {
  const std::string host = HostId();
  MachineFeed::Events events;
  events.on_message = [this](const std::string& key, const SharedText& message) {
    SendAll(key, message);
  };
  events.on_entries = [this](const std::vector<SharedText>& entries) {
    for (Page& page : pages_) {
      for (const SharedText& entry : entries) page.queue.PutEntry(entry);
      SendWaiting(page);
    }
  };
  events.on_status = [this] { requests_->OnStatus(); };
  RobotRequests::Options requests{options_.name_space, host, options_.with_keys};
  requests.stops = {options_.name_space, options_.domain_id, options_.lan};
  requests.places = PlacesHere;
  requests.machine = options_.machine;
  requests.find = [this](auto on_found) { search_.Begin(std::move(on_found)); };
  requests_ = std::make_unique<RobotRequests>(
      node_, std::move(requests), [this]() -> const LeaderWatch& { return feed_->leader(); });
  auto feed =
      MachineFeed::Make(node_, {options_.name_space, host, options_.machine}, std::move(events));
  if (!feed) return feed.error();
  feed_ = std::move(feed).value();
  MetricsWatch::Options metrics;
  metrics.name_space = options_.name_space;
  metrics.with_keys = options_.with_keys;
  metrics.began_wall_ns = WallMilliseconds() * 1'000'000;
  metrics.host = host;
  metrics.machine = [this] { return feed_->leader().machine(); };
  metrics_ = std::make_unique<MetricsWatch>(node_, std::move(metrics));
  return Ok();
}

Result<> LiveServer::Open() {
  if (auto restored = RestoreSessions(); !restored) return restored;
  if (auto watched = WatchMachine(); !watched) return watched;
  foxglove_ = std::make_unique<foxglove::FoxgloveServer>(
      node_, table_,
      foxglove::FoxgloveServer::Options{
          "Musher" + (options_.name_space.empty() ? std::string() : " /" + options_.name_space),
          options_.name_space, FoxgloveGuards()});
  auto watch = transport::WatchTopics(
      node_,
      [this](const transport::DiscoveredEndpoint& endpoint) {
        const bool service = foxglove_->OnFound(endpoint);
        if (table_.OnFound(endpoint) || service) OnTopicsChanged();
      },
      [this](transport::EndpointId id) {
        const bool service = foxglove_->OnLost(id);
        if (table_.OnLost(id) || service) OnTopicsChanged();
      });
  if (!watch) return watch.error();
  topic_watch_ = std::move(watch).value();
  every_second_ = node_.loop().Every(std::chrono::seconds(1), [this] {
    SendAll("time", Share({{"op", "time"},
                           {"time_ms", WallMilliseconds()},
                           {"uptime_ms", ToMilliseconds(SinceBoot())}}));
  });
  http::Options http = options_.http;
  http.subprotocols = {kSubprotocol, foxglove::kSubprotocol};
  auto server = http::Server::Make(
      node_.loop(), http,
      [this](const http::Request& request, const http::Respond& respond) {
        OnRequest(request, respond);
      },
      [this](const std::shared_ptr<http::WebSocket>& socket) { return OnWebSocket(socket); });
  if (!server) return server.error();
  http_ = std::move(server).value();
  return Ok();
}

http::LoginLink LiveServer::NewLink(const std::string& name) {
  const http::LoginCode code = login_.NewCode(name, node_.loop().Now());
  return {"/login?code=" + code.code, code.pin,
          OutsideUrl(options_.http.bind, transport::ReadInterfaces(), port())};
}

void LiveServer::KeepSessions(SessionSaver::Then then) {
  saver_.Save(login_.Kept(node_.loop().Now()), WallMilliseconds(), std::move(then));
}

foxglove::FoxgloveServer::Guards LiveServer::FoxgloveGuards() {
  using Foxglove = foxglove::FoxgloveServer;
  Foxglove::Guards guards;
  guards.leader = [this]() -> std::optional<Foxglove::Leader> {
    const LeaderWatch& watch = feed_->leader();
    if (!watch.leader()) return std::nullopt;
    return Foxglove::Leader{watch.machine(), watch.participant()};
  };
  guards.why_not_meant = [this] { return requests_->WhyNotMeant(); };
  guards.why_not_published = [this](const std::string& topic) -> std::optional<Error> {
    Foxglove::Participants readers;
    for (const transport::DiscoveredEndpoint& endpoint : table_.EndpointsOf(topic)) {
      if (!endpoint.writer) readers.push_back(endpoint.participant);
    }
    const MachineIdentity& followed = feed_->leader().machine();
    const auto other = meant_.OtherThan(followed, readers);
    if (!other) return std::nullopt;
    return Error{kCodeTargetBusy, MachineText(*other) + " receives it, and " +
                                      MachineText(followed) +
                                      " is followed; give each machine a namespace"};
  };
  guards.check_servers = [this](const std::string& actuator, MeantServers::Servers servers,
                                std::function<void(std::optional<Error>)> then) {
    meant_.Check(actuator, std::move(servers), feed_->leader().machine(), std::move(then));
  };
  guards.uptime_ms = [] { return ToMilliseconds(SinceBoot()); };
  guards.why_late = [](std::int64_t seen_ms) -> std::optional<Error> {
    const auto fresh = CheckAge(seen_ms, ToMilliseconds(SinceBoot()));
    if (fresh) return std::nullopt;
    return Error{fresh.error().code,
                 fresh.error().message + "; on a slow link close the panels that show pictures"};
  };
  guards.only_lowers = [this](const std::string& state, const std::string& actuator) {
    const auto& status = feed_->status();
    return state == kTearDown || state == kError ||
           (status && OnlyLowers(*status, state, actuator));
  };
  guards.counts = [this](transport::ParticipantId server, const Foxglove::Participants& servers) {
    return meant_.IsMeant(server, servers, feed_->leader().machine());
  };
  return guards;
}

http::WebSocketHandlers LiveServer::OnFoxglove(const std::shared_ptr<http::WebSocket>& socket) {
  // A page of another server of this host may connect, and the browser adds the cookie by itself.
  const bool is_own_page =
      http::CheckOrigin(socket->request().headers, http::OriginRule::kSamePage, {}, {}).ok();
  // Each time that it acts: a session ends, and acting begins its 12 hours again. The client keeps
  // the socket, and with it the request, for as long as this function.
  const auto may_act = [this, has_token = HasToken(socket->request()), is_own_page,
                        &request = socket->request()] {
    return has_token || (is_own_page && !PersonOf(request).empty());
  };
  if (!may_act() && !MayLook(socket->request())) {
    socket->Close(kPolicyViolation, "looking from another host needs a login: ?token=TOKEN");
    return {};
  }
  std::erase_if(acting_, [](const auto& each) { return each.expired(); });
  if (may_act()) acting_.push_back(socket);
  http::WebSocketHandlers handlers = foxglove_->OnWebSocket(socket, may_act);
  handlers.on_closed = [this, closed = std::move(handlers.on_closed)] {
    closed();
    CountClients();
  };
  CountClients();
  return handlers;
}

void LiveServer::CountClients() {
  metrics_->metrics().OnClients(pages_.size(), foxglove_->clients());
}

http::WebSocketHandlers LiveServer::OnWebSocket(const std::shared_ptr<http::WebSocket>& socket) {
  if (socket->subprotocol() == foxglove::kSubprotocol) return OnFoxglove(socket);
  if (socket->request().path != "/live") {
    socket->Close(kPolicyViolation, "there is no WebSocket at " + socket->request().path);
    return {};
  }
  if (!MayLook(socket->request())) {
    socket->Close(kPolicyViolation, "looking from another host needs a login");
    return {};
  }
  Page& page = pages_.emplace_back();
  page.socket = socket;
  http::WebSocketHandlers handlers;
  handlers.on_message = [this, &page](const std::string& text, bool) { OnPageMessage(page, text); };
  handlers.on_drained = [this, &page] { SendWaiting(page); };
  handlers.on_closed = [this, &page] { OnPageClosed(page); };
  Greet(page);
  CountClients();
  feed_->SetOpenPages(pages_.size());
  return handlers;
}

void LiveServer::Greet(Page& page) {
  const std::string person = PersonOf(page.socket->request());
  page.socket->Send(Share({{"op", "hello"},
                           {"version", Version()},
                           {"namespace", options_.name_space},
                           {"may_act", !person.empty()},
                           {"may_stop", !person.empty() || !options_.stop_needs_login},
                           {"who", person},
                           {"time_ms", WallMilliseconds()},
                           {"uptime_ms", ToMilliseconds(SinceBoot())}}),
                    false);
  page.socket->Send(TopicsMessage(), false);
  page.socket->Send(feed_->History(), false);
  for (const auto& [key, message] : feed_->Latest()) page.socket->Send(message, false);
}

void LiveServer::OnPageMessage(Page& page, const std::string& text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object() || message.value("op", Json()) != "watch" ||
      !message.contains("topics") || !message["topics"].is_array()) {
    return page.socket->Close(kPolicyViolation,
                              R"(a page sends {"op":"watch","topics":[...]}, nothing else)");
  }
  page.watched.clear();
  for (const Json& topic : message["topics"]) {
    if (topic.is_string() && page.watched.size() < kMostWatched) {
      page.watched.insert(topic.get<std::string>());
    }
  }
  WatchForAll();
  for (const std::string& topic : page.watched) {
    for (const auto& [key, latest] : watched_.Last(topic)) Send(page, key, latest);
  }
}

void LiveServer::OnPageClosed(Page& page) {
  pages_.remove_if([&page](const Page& each) { return &each == &page; });
  WatchForAll();
  CountClients();
  feed_->SetOpenPages(pages_.size());
}

void LiveServer::WatchForAll() {
  std::set<std::string> topics;
  for (const Page& page : pages_) topics.insert(page.watched.begin(), page.watched.end());
  watched_.Watch(topics);
}

void LiveServer::Send(Page& page, const std::string& key, const SharedText& message) {
  page.queue.Put(key, message);
  SendWaiting(page);
}

void LiveServer::SendAll(const std::string& key, const SharedText& message) {
  for (Page& page : pages_) Send(page, key, message);
}

void LiveServer::SendWaiting(Page& page) {
  if (page.queue.empty() || page.socket->queued_bytes() > 0) return;
  const bool history_lost = page.queue.history_lost();
  for (SharedText& message : page.queue.TakeAll()) page.socket->Send(std::move(message), false);
  if (history_lost) page.socket->Send(feed_->History(), false);
}

void LiveServer::OnTopicsChanged() {
  if (topics_timer_) return;
  topics_timer_ = node_.loop().At(node_.loop().Now() + kTopicsDelay, [this] {
    topics_timer_.reset();
    watched_.OnTopicsChanged();
    foxglove_->OnTopicsChanged();
    foxglove_->OnServicesChanged();
    if (!pages_.empty()) SendAll("topics", TopicsMessage());
  });
}

SharedText LiveServer::TopicsMessage() const {
  OrderedJson topics = OrderedJson::array();
  for (const ListedTopic& topic : table_.List()) {
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"publishers", topic.publishers},
                      {"subscribers", topic.subscribers}});
  }
  return Share({{"op", "topics"}, {"topics", std::move(topics)}});
}

// --- the requests of a page: files, API, login ---

// Browsers send the cookies of all servers of a host to each of them, whatever its port.
std::string LiveServer::Cookie() const {
  return "musher_view_" + std::to_string(port());
}

std::string LiveServer::PersonOf(const http::Request& request) {
  const auto cookie = request.cookies.find(Cookie());
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
  if (path == "/live") {
    auto response =
        http::ErrorResponse(426, kCodeUnSupport,
                            "/live is a WebSocket; a proxy has to pass the headers Upgrade and "
                            "Connection on");
    response.headers.emplace_back("Upgrade", "websocket");
    return respond(std::move(response));
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
  Json body = Json::parse(request.body, nullptr, false);
  // A stop needs nothing of it: `curl -X POST robot:8765/api/estop` stops the robot.
  if (!body.is_object() && request.path == "/api/estop") body = Json::object();
  if (!body.is_object()) {
    return respond(
        http::ErrorResponse(400, kCodeParametersInvalid, "the body has to be a JSON object"));
  }
  const std::string target = TextIn(body, "target");
  const std::string actuator = TextIn(body, "actuator");
  const bool plan = request.path == "/api/plan";
  std::string person = PersonOf(request);
  if (person.empty() && request.path == "/api/estop" && !options_.stop_needs_login) {
    person = "a person without a login (" + request.peer + ")";
  }
  if (person.empty() && !plan) {
    return respond(http::ErrorResponse(
        403, kNeedsLogin,
        "acting needs a login; `musher view --link` prints a link and a PIN for one"));
  }
  if (const auto known = CheckFields(request.path, body); !known) {
    return respond(http::ErrorResponse(400, known.error().code, known.error().message));
  }
  if (plan) return requests_->Plan(target, actuator, respond);
  if (MayMove(request.path, body, feed_->status())) {
    if (const auto fresh = CheckAgeIn(body); !fresh) {
      const Error& why = fresh.error();
      const unsigned status = why.code == kCodeParametersInvalid ? 400 : 409;
      return respond(http::ErrorResponse(status, why.code, why.message));
    }
  }
  const RobotRequests::Caller caller{person, {TextIn(body, "machine"), TextIn(body, "machine_id")}};
  if (request.path == "/api/set") return requests_->Set(caller, target, actuator, respond);
  if (request.path == "/api/estop") {
    return requests_->Stop(caller, TextIn(body, "reason"), respond);
  }
  if (request.path == "/api/release") {
    return requests_->Release(caller, TextsIn(body, "stop_ids"), respond);
  }
  if (request.path == "/api/restart") return requests_->Restart(caller, actuator, respond);
  if (request.path == "/api/skill") {
    if (!HasFlatParameters(body)) {
      return respond(http::ErrorResponse(400, kCodeParametersInvalid,
                                         "a parameter is a text, a number, or a list of them"));
    }
    if (requests_->IsMeant(caller, respond)) skills_.Run(caller.shown, SkillIn(body), respond);
    return;
  }
  if (request.path == "/api/cancel_skill") {
    if (!body.contains("goal_id")) {
      return skills_.CancelRun(caller.shown, person, actuator, TextIn(body, "skill"), respond);
    }
    return skills_.Cancel(TextIn(body, "action"), TextIn(body, "goal_id"), respond);
  }
  if (request.path == "/api/pause_skill") {
    const std::string skill = TextIn(body, "skill");
    if (body.value("pause", Json()) != false) {
      return skills_.Pause(caller.shown, actuator, skill, respond);
    }
    if (requests_->IsMeant(caller, respond)) skills_.Resume(caller.shown, actuator, skill, respond);
    return;
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
  respond(WithSession(Redirect("/"), Cookie(), session.value()));
}

// POST {"pin":"482103"}, which a person types on the page.
void LiveServer::OnPin(const http::Request& request, const http::Respond& respond) {
  const Json body = Json::parse(request.body, nullptr, false);
  if (request.method != "POST" || !body.is_object()) {
    return respond(
        http::ErrorResponse(400, kCodeParametersInvalid, R"(POST {"pin":"..."} opens a session)"));
  }
  const auto session = login_.RedeemPin(TextIn(body, "pin"), request.peer, node_.loop().Now());
  if (!session) return respond(RefusalResponse(session.error()));
  KeepSessions();
  respond(WithSession(JsonResponse("{}"), Cookie(), session.value()));
}

// Ends the session of the cookie; all sessions with {"all":true} and a login, or with the token.
// Pages of ended sessions look on without the login, where they may.
void LiveServer::OnLogout(const http::Request& request, const http::Respond& respond) {
  const Json body = Json::parse(request.body, nullptr, false);
  if (request.method != "POST" || !body.is_object()) {
    return respond(http::ErrorResponse(400, kCodeParametersInvalid,
                                       R"(POST {} ends the session, {"all":true} all of them)"));
  }
  const bool all = body.contains("token") || body.value("all", Json()) == true;
  if (body.contains("token")) {
    const auto permitted =
        login_.MayMakeLinks(TextIn(body, "token"), request.peer, node_.loop().Now());
    if (!permitted) return respond(RefusalResponse(permitted.error()));
    login_.EndAll();
  } else if (all) {
    if (PersonOf(request).empty()) {
      return respond(http::ErrorResponse(403, kNeedsLogin, "to end all logins needs a login"));
    }
    login_.EndAll();
  } else if (const auto cookie = request.cookies.find(Cookie()); cookie != request.cookies.end()) {
    login_.End(cookie->second);
  }
  CloseEndedSessions(all);
  const std::pair<std::string, std::string> no_cookie{
      "Set-Cookie", Cookie() + "=; Max-Age=0; HttpOnly; SameSite=Strict; Path=/"};
  // A server that is killed before it is on disk knows the session again.
  KeepSessions([respond, no_cookie](const Result<>& kept) {
    http::Response response =
        kept ? JsonResponse("{}")
             : http::ErrorResponse(500, kept.error().code,
                                   "the login has ended, and that is not on disk yet, so a restart "
                                   "of musher-view may bring it back: " +
                                       kept.error().message);
    response.headers.push_back(no_cookie);
    respond(std::move(response));
  });
}

// The connections that they have opened.
void LiveServer::CloseEndedSessions(bool all) {
  const auto has_ended = [this](const http::WebSocket& socket) {
    const auto cookie = socket.request().cookies.find(Cookie());
    return cookie != socket.request().cookies.end() &&
           !login_.Lives(cookie->second, node_.loop().Now());
  };
  std::vector<std::shared_ptr<http::WebSocket>> ended;
  for (const Page& page : pages_) {
    if (has_ended(*page.socket)) ended.push_back(page.socket);
  }
  for (const auto& acting : acting_) {
    auto socket = acting.lock();
    if (socket && (all || has_ended(*socket))) ended.push_back(std::move(socket));
  }
  for (const auto& socket : ended) socket->Close(kNormalClosure, "the login has ended");
}

// For `musher view --link`, which has read the token file.
void LiveServer::OnLink(const http::Request& request, const http::Respond& respond) {
  const Json body = Json::parse(request.body, nullptr, false);
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
