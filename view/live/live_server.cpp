#include "musher/view/live/live_server.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/log.hpp"
#include "musher/base/version.hpp"
#include "musher/transport/network.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/http/session_file.hpp"
#include "musher/view/live/outside_url.hpp"

namespace musher::view {
namespace {

using LiveJson = nlohmann::ordered_json;

constexpr const char* kSubprotocol = "musher.view.v1";
constexpr Duration kTopicsDelay = Milliseconds(100);        // what is discovered comes together
constexpr Duration kKeepPeriod = std::chrono::minutes(10);  // of the times of the last requests
constexpr unsigned kPolicyViolation = 1008;

SharedText Dumped(const LiveJson& json) {
  return std::make_shared<const std::string>(
      json.dump(-1, ' ', false, LiveJson::error_handler_t::replace));
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
      skills_(node, options_.name_space) {}

Result<std::unique_ptr<LiveServer>> LiveServer::Make(transport::Node& node, Options options) {
  std::unique_ptr<LiveServer> server(new LiveServer(node, std::move(options)));
  if (auto opened = server->Open(); !opened) return opened.error();
  return server;
}

Result<> LiveServer::Open() {
  const std::string host = HostId();
  if (!options_.sessions.empty()) {
    const auto kept = http::ReadSessions(options_.sessions, WallMilliseconds());
    if (!kept) return kept.error();
    login_.Restore(kept.value(), node_.loop().Now());
    keep_timer_ = node_.loop().Every(kKeepPeriod, [this] {
      if (login_.sessions() > 0) KeepSessions();
    });
  }
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
  requests_ = std::make_unique<RobotRequests>(
      node_, RobotRequests::Options{options_.name_space, host, options_.with_keys},
      [this]() -> const LeaderWatch& { return feed_->leader(); });
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
  foxglove_ = std::make_unique<foxglove::FoxgloveServer>(
      node_, table_,
      foxglove::FoxgloveServer::Options{
          "Musher" + (options_.name_space.empty() ? std::string() : " /" + options_.name_space),
          options_.name_space});
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
    SendAll("time", Dumped({{"op", "time"}, {"time_ms", WallMilliseconds()}}));
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

void LiveServer::KeepSessions() {
  if (options_.sessions.empty()) return;
  const auto kept =
      http::WriteSessions(options_.sessions, login_.Kept(node_.loop().Now()), WallMilliseconds());
  if (!kept && !std::exchange(keeping_failed_, true)) {
    WriteLog(LogLevel::kWarning, "musher-view",
             "logins end with this process: " + kept.error().message);
  }
}

http::WebSocketHandlers LiveServer::OnFoxglove(const std::shared_ptr<http::WebSocket>& socket) {
  const bool may_act = HasToken(socket->request()) || !PersonOf(socket->request()).empty();
  if (!may_act && !MayLook(socket->request())) {
    socket->Close(kPolicyViolation, "looking from another host needs a login: ?token=TOKEN");
    return {};
  }
  std::erase_if(acting_, [](const auto& each) { return each.expired(); });
  if (may_act) acting_.push_back(socket);
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
  page.socket->Send(Dumped({{"op", "hello"},
                            {"version", Version()},
                            {"namespace", options_.name_space},
                            {"may_act", !person.empty()},
                            {"may_stop", !person.empty() || !options_.stop_needs_login},
                            {"who", person},
                            {"time_ms", WallMilliseconds()}}),
                    false);
  page.socket->Send(TopicsMessage(), false);
  page.socket->Send(feed_->History(), false);
  for (const auto& [key, message] : feed_->Latest()) page.socket->Send(message, false);
}

void LiveServer::OnPageMessage(Page& page, const std::string& text) {
  const LiveJson message = LiveJson::parse(text, nullptr, false);
  if (!message.is_object() || message.value("op", LiveJson()) != "watch" ||
      !message.contains("topics") || !message["topics"].is_array()) {
    return page.socket->Close(kPolicyViolation,
                              R"(a page sends {"op":"watch","topics":[...]}, nothing else)");
  }
  page.watched.clear();
  for (const LiveJson& topic : message["topics"]) {
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
  LiveJson topics = LiveJson::array();
  for (const ListedTopic& topic : table_.List()) {
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"publishers", topic.publishers},
                      {"subscribers", topic.subscribers}});
  }
  return Dumped({{"op", "topics"}, {"topics", std::move(topics)}});
}

}  // namespace musher::view
