#pragma once
// The server of the page: its files, the WebSocket /live, the API, cameras, logs and metrics of one
// machine (docs/view.md).
//
// Every client on this host may look; one on another host only with a login. Only a person with a
// login may act: a one-time link opens it. A request that acts carries the person's name and
// address, and the machine that the page shows.
//
//   /live         the WebSocket of a page (subprotocol musher.view.v1)
//   GET /api/...  history, behavior, tree, log, topics; POST: plan
//   POST /api/... with a login: set, estop, release, restart, skill, its pause and cancel, logout
//   /camera       a picture
//   /metrics      for Prometheus
//   /login        opens a session with the code of a link; POST /api/login with a PIN
//   POST /api/link, /api/logout: with the token of `musher view`, a link, or the end of all
//
//   any path      Foxglove's protocol, for a WebSocket of its subprotocol, and ?token=TOKEN to act
//
// Threads: loop thread only.

#include <list>
#include <memory>
#include <string>

#include "musher/view/foxglove/foxglove_server.hpp"
#include "musher/view/http/login.hpp"
#include "musher/view/http/server.hpp"
#include "musher/view/live/camera_view.hpp"
#include "musher/view/live/docs.hpp"
#include "musher/view/live/host_search.hpp"
#include "musher/view/live/machine_feed.hpp"
#include "musher/view/live/meant_servers.hpp"
#include "musher/view/live/robot_requests.hpp"
#include "musher/view/live/session_saver.hpp"
#include "musher/view/live/skill_requests.hpp"
#include "musher/view/live/watched_topics.hpp"
#include "musher/view/metrics/metrics_watch.hpp"

namespace musher::view {

class LiveServer {
 public:
  static constexpr std::size_t kMostWatched = 64;  // topics of a page

  struct Options {
    http::Options http;
    std::string name_space;
    std::string machine;     // see MachineFeed::Options
    bool with_keys = false;  // the machine has [security]
    int domain_id = 0;       // of the node
    bool lan = false;        // the machine may have actuators on other hosts
    std::string token;       // of ReadOrMakeToken()
    std::string sessions;    // file that keeps them over a restart; empty: none
    bool stop_needs_login = false;
    std::string logs;  // folder of the actuators' logs; empty: as the machine's config says
    std::function<std::string()> docs;  // see Docs; empty: none
  };

  // Fails if DDS or the address cannot be used. The node must outlive it.
  static Result<std::unique_ptr<LiveServer>> Make(transport::Node& node, Options options);

  std::uint16_t port() const { return http_->port(); }
  // With which the person of that name may log in, once.
  http::LoginLink NewLink(const std::string& name);

 private:
  struct Page {
    std::shared_ptr<http::WebSocket> socket;
    PageQueue queue;
    std::set<std::string> watched;
  };

  LiveServer(transport::Node& node, Options options);
  Result<> Open();
  Result<> RestoreSessions();
  // Makes what needs to know the machine of the page: its feed, the requests to it, its metrics.
  Result<> WatchMachine();

  // The person who has sent the request; empty: a session without login.
  std::string PersonOf(const http::Request& request);
  bool MayLook(const http::Request& request);
  // Whether the request has the token: for programs that keep no cookies.
  bool HasToken(const http::Request& request);
  std::string Cookie() const;

  void OnRequest(const http::Request& request, const http::Respond& respond);
  void OnGet(const http::Request& request, const http::Respond& respond);
  void OnPost(const http::Request& request, const http::Respond& respond);
  void OnLogin(const http::Request& request, const http::Respond& respond);
  void OnPin(const http::Request& request, const http::Respond& respond);
  void OnLogout(const http::Request& request, const http::Respond& respond);
  void OnLink(const http::Request& request, const http::Respond& respond);
  void OnLog(const http::Request& request, const http::Respond& respond);
  // `all`: also of what acts by the token.
  void CloseEndedSessions(bool all);
  // `then`: see SessionSaver.
  void KeepSessions(SessionSaver::Then then = nullptr);
  http::WebSocketHandlers OnWebSocket(const std::shared_ptr<http::WebSocket>& socket);
  http::WebSocketHandlers OnFoxglove(const std::shared_ptr<http::WebSocket>& socket);
  foxglove::FoxgloveServer::Guards FoxgloveGuards();

  void Greet(Page& page);
  void OnPageMessage(Page& page, const std::string& text);
  void OnPageClosed(Page& page);
  void Send(Page& page, const std::string& key, const SharedText& message);
  void SendAll(const std::string& key, const SharedText& message);
  void SendWaiting(Page& page);
  void WatchForAll();
  void OnTopicsChanged();
  void CountClients();
  SharedText TopicsMessage() const;
  Result<std::string> LogFileOf(const std::string& actuator);

  transport::Node& node_;
  const Options options_;
  http::Login login_;
  Docs docs_;
  TopicTable table_;
  CameraView cameras_;
  WatchedTopics watched_;
  HostSearch search_;
  std::unique_ptr<RobotRequests> requests_;
  SkillRequests skills_;
  MeantServers meant_;  // for Foxglove
  std::unique_ptr<MetricsWatch> metrics_;
  std::unique_ptr<MachineFeed> feed_;
  std::unique_ptr<foxglove::FoxgloveServer> foxglove_;
  std::unique_ptr<transport::TopicWatch> topic_watch_;
  std::list<Page> pages_;
  std::vector<std::weak_ptr<http::WebSocket>> acting_;  // of Foxglove, by a login
  transport::LoopHandlePtr topics_timer_;               // while a change is not sent
  transport::LoopHandlePtr every_second_;
  transport::LoopHandlePtr keep_timer_;
  SessionSaver saver_;
  std::unique_ptr<http::Server> http_;  // last: its functions use all of the above
};

}  // namespace musher::view
