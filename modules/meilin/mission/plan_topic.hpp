#pragma once
// A latched topic of plans, and whether a connection may have held a plan up: one of a sender that
// was lost and is there again arrives for the first time, however old it is. What a sender writes
// soon after it is back counts as held up, too. No clocks of two computers are compared: the first
// plan of a sender that was not known before counts as new.
//
// Threads: the loop's. Runs on any transport.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/node.hpp"

namespace musher::meilin {

// The senders of a topic. Pure.
class PlanSenders {
 public:
  static constexpr Duration kJustBack = std::chrono::seconds(5);

  // Those that are connected, at each change.
  void OnConnected(const std::vector<transport::ParticipantId>& connected, Time now) {
    for (auto& [id, sender] : senders_) {
      if (std::ranges::find(connected, id) == connected.end()) sender = {false, std::nullopt};
    }
    for (const transport::ParticipantId id : connected) {
      const auto [known, is_new] = senders_.try_emplace(id);
      if (!is_new && !known->second.connected) known->second = {true, now};
    }
  }
  // A plan may arrive before the change is known that has brought it.
  bool IsJustBack(transport::ParticipantId id, Time now) const {
    const auto sender = senders_.find(id);
    if (sender == senders_.end()) return false;
    const std::optional<Time>& back_at = sender->second.back_at;
    return !sender->second.connected || (back_at && now - *back_at < kJustBack);
  }

 private:
  struct Sender {
    bool connected = true;
    std::optional<Time> back_at;
  };
  std::map<transport::ParticipantId, Sender> senders_;
};

template <msg::Message M>
class PlanTopic {
 public:
  // `written_ns`: by the clock of the sender; 0: not known.
  using Handler = std::function<void(const M& plan, std::int64_t written_ns, bool held_up)>;

  PlanTopic(transport::Node& node, const std::string& topic, Handler handler)
      : loop_(node.loop()), handler_(std::move(handler)) {
    transport::SubscriptionEvents events;
    events.on_match_changed = [this] {
      senders_.OnConnected(subscription_->WriterParticipants(), loop_.Now());
    };
    auto made = transport::MakeSubscription<M>(
        node, topic,
        [this](const M& plan, const transport::SampleInfo& info) {
          handler_(plan, info.written_ns, senders_.IsJustBack(info.participant, loop_.Now()));
        },
        transport::kLatchedQos, std::move(events));
    if (made) subscription_ = std::move(made).value();
  }
  PlanTopic(const PlanTopic&) = delete;
  PlanTopic& operator=(const PlanTopic&) = delete;

 private:
  transport::EventLoop& loop_;
  const Handler handler_;
  PlanSenders senders_;
  std::unique_ptr<transport::Subscription> subscription_;  // last: its callbacks use the rest
};

}  // namespace musher::meilin
