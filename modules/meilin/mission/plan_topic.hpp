#pragma once
// A latched topic of plans, and whether a plan may have waited at its sender: what a sender has
// written without a connection arrives for the first time once it connects, however old it is, be
// it a sender that was not known before or one that was lost. What it writes soon after it has
// connected counts as such, too. No clocks of two computers are compared: where the sender runs on
// this computer, the time at which the plan was written decides; else a plan counts as new from
// kJustConnected after the connection on.
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

#include "musher/base/host.hpp"
#include "musher/transport/node.hpp"

namespace musher::meilin {

// The refusal of a plan whose sender has just connected; `musher-meilin send plan` knows it.
inline constexpr const char* kSenderHasJustConnected =
    "its sender has just connected, and the plan may have waited there for long: look at the "
    "robot, then send it once more from a sender that has been connected for 5 s";

// The senders of a topic. Pure.
class PlanSenders {
 public:
  static constexpr Duration kJustConnected = std::chrono::seconds(5);

  // Those that are connected, at each change. Others are forgotten, so there are never more than
  // the transport has itself: a sender that was lost counts as an unknown one.
  void OnConnected(const std::vector<transport::ParticipantId>& connected, Time now) {
    std::map<transport::ParticipantId, Time> present;
    for (const transport::ParticipantId id : connected) {
      const auto known = connected_since_.find(id);
      present[id] = known == connected_since_.end() ? now : known->second;
    }
    connected_since_ = std::move(present);
  }
  // A plan may arrive before the change is known that has brought it.
  bool HasJustConnected(transport::ParticipantId id, Time now) const {
    const auto known = connected_since_.find(id);
    return known == connected_since_.end() || now - known->second < kJustConnected;
  }
  std::size_t size() const { return connected_since_.size(); }

 private:
  std::map<transport::ParticipantId, Time> connected_since_;
};

// Why a plan of a sender that has just connected may be late; empty: it is not. `age`: since it was
// written, by the wall clock of this computer; nullopt: its sender runs elsewhere. The clock may
// have been set since then.
inline std::string WhyMayBeLate(std::optional<Duration> age) {
  if (!age || *age < -PlanSenders::kJustConnected) return kSenderHasJustConnected;
  if (*age <= PlanSenders::kJustConnected) return "";
  return "it was written " + std::to_string(ToMilliseconds(*age) / 1000) +
         " s before its sender has connected: look at the robot, then send it once more";
}

template <msg::Message M>
class PlanTopic {
 public:
  // `written_ns`: by the clock of the sender; 0: not known. `late`: why the plan may be late;
  // empty: it is not.
  using Handler =
      std::function<void(const M& plan, std::int64_t written_ns, const std::string& late)>;

  PlanTopic(transport::Node& node, const std::string& topic, Handler handler)
      : node_(node), handler_(std::move(handler)) {
    transport::SubscriptionEvents events;
    events.on_match_changed = [this] {
      senders_.OnConnected(subscription_->WriterParticipants(), node_.loop().Now());
    };
    auto made = transport::MakeSubscription<M>(
        node, topic,
        [this](const M& plan, const transport::SampleInfo& info) {
          handler_(plan, info.written_ns, WhyLate(info));
        },
        transport::kLatchedQos, std::move(events));
    if (made) subscription_ = std::move(made).value();
  }
  PlanTopic(const PlanTopic&) = delete;
  PlanTopic& operator=(const PlanTopic&) = delete;

 private:
  std::string WhyLate(const transport::SampleInfo& info) const {
    if (!senders_.HasJustConnected(info.participant, node_.loop().Now())) return "";
    if (info.written_ns == 0 || !RunsHere(info.participant)) return WhyMayBeLate(std::nullopt);
    const Duration now = std::chrono::system_clock::now().time_since_epoch();
    return WhyMayBeLate(now - Duration(info.written_ns));
  }
  // By the name of its computer. Reads all of discovery: only for a sender that has just connected.
  bool RunsHere(transport::ParticipantId id) const {
    if (id == node_.participant()) return true;
    const std::string here = HostName();
    return !here.empty() && std::ranges::any_of(node_.Peers(), [&](const auto& peer) {
      return peer.id == id && peer.host == here;
    });
  }

  transport::Node& node_;
  const Handler handler_;
  PlanSenders senders_;
  std::unique_ptr<transport::Subscription> subscription_;  // last: its callbacks use the rest
};

}  // namespace musher::meilin
