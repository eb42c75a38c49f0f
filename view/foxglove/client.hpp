#pragma once
// One connected client of the Foxglove server: what it subscribes to and publishes, and what waits
// for its connection. Loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/view/foxglove/foxglove_server.hpp"

namespace musher::view::foxglove {

struct FoxgloveServer::Client {
  // `seen`: uptime of this host.
  Client(std::uint64_t number, std::shared_ptr<http::WebSocket> connection,
         std::function<bool()> acts, std::int64_t seen)
      : id(number), socket(std::move(connection)), may_act(std::move(acts)), seen_ms(seen) {}

  void Send(std::string text) {
    socket->Send(std::make_shared<const std::string>(std::move(text)), false);
  }
  void SendBinary(std::string bytes) {
    socket->Send(std::make_shared<const std::string>(std::move(bytes)), true);
  }
  bool Wants(std::uint32_t channel) const;
  // It has answered the ping with that uptime.
  void OnPong(const std::string& uptime_ms);
  // A sample of a channel, once for each subscription to it; waits if the connection is too slow.
  void SendSample(std::uint32_t channel, std::uint64_t wall_ns, std::span<const std::byte> bytes);
  void SendWaiting();
  // These channels are gone.
  void Forget(const std::vector<std::uint32_t>& channels);

  struct Published {
    std::string topic;
    std::string type;  // on DDS
    std::unique_ptr<transport::RawWriter> writer;
    std::string refused;  // why its last message was not published, as the client has been sent it
  };

  const std::uint64_t id;
  const std::shared_ptr<http::WebSocket> socket;
  const std::function<bool()> may_act;  // now
  std::int64_t seen_ms;                 // uptime of this host in the last ping that was answered
  std::map<std::uint32_t, std::uint32_t> subscriptions;                 // the channel of each
  std::map<std::uint32_t, std::shared_ptr<const std::string>> waiting;  // by subscription
  std::uint64_t missed = 0;                      // messages, since the last report
  std::map<std::uint32_t, Published> published;  // by the client's channel
};

}  // namespace musher::view::foxglove
