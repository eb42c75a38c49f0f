#include "musher/view/foxglove/client.hpp"

#include <algorithm>
#include <charconv>

namespace musher::view::foxglove {

bool FoxgloveServer::Client::Wants(std::uint32_t channel) const {
  return std::any_of(subscriptions.begin(), subscriptions.end(),
                     [channel](const auto& each) { return each.second == channel; });
}

void FoxgloveServer::Client::OnPong(const std::string& uptime_ms) {
  std::int64_t answered = 0;
  const char* const end = uptime_ms.data() + uptime_ms.size();
  const auto read = std::from_chars(uptime_ms.data(), end, answered);
  if (read.ec == std::errc() && read.ptr == end) seen_ms = std::max(seen_ms, answered);
}

void FoxgloveServer::Client::SendSample(std::uint32_t channel, std::uint64_t wall_ns,
                                        std::span<const std::byte> bytes) {
  for (const auto& [subscription, of] : subscriptions) {
    if (of != channel) continue;
    auto message = std::make_shared<const std::string>(MessageData(subscription, wall_ns, bytes));
    if (waiting.empty() && socket->queued_bytes() <= kMostQueued) {
      socket->Send(std::move(message), true);
    } else {
      auto& newest = waiting[subscription];
      missed += newest ? 1 : 0;
      newest = std::move(message);
    }
  }
}

void FoxgloveServer::Client::SendWaiting() {
  for (auto& [subscription, message] : waiting) socket->Send(std::move(message), true);
  waiting.clear();
  if (missed == 0) return;
  Send(Status(StatusLevel::kWarning,
              "The connection is slower than the topics: " + std::to_string(missed) +
                  " messages were left out.",
              "slow"));
  missed = 0;
}

void FoxgloveServer::Client::Forget(const std::vector<std::uint32_t>& channels) {
  std::erase_if(subscriptions, [&](const auto& each) {
    const bool gone = std::find(channels.begin(), channels.end(), each.second) != channels.end();
    if (gone) waiting.erase(each.first);
    return gone;
  });
}

}  // namespace musher::view::foxglove
