#include "musher/transport/dds/first_replies.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace musher::transport::dds {

namespace {

constexpr Duration kNew = Milliseconds(500);
constexpr Duration kHold = Milliseconds(12);
constexpr Duration kFollowUpDelay =
    Milliseconds(110);  // ROS 2's readers repeat a request after 100 ms at least
// Fewer than a writer keeps, so that each can be repeated for the new reader.
constexpr std::size_t kMostHeld = 8;
constexpr std::size_t kLargestFollowUp = 4096;
constexpr std::size_t kClientIdBegin = 4;  // after the encapsulation header
constexpr std::size_t kClientIdEnd = 12;

}  // namespace

void FirstReplies::OnNewReader(ParticipantId participant) {
  new_until_[participant] = loop_.Now() + kNew;
}

// Forgets those that are new no more: any participant may come and go.
bool FirstReplies::IsNew(ParticipantId participant) {
  if (new_until_.empty()) return false;
  std::erase_if(new_until_, [now = loop_.Now()](const auto& one) { return now >= one.second; });
  return new_until_.contains(participant);
}

bool FirstReplies::Holds(ParticipantId participant) const {
  return std::ranges::any_of(held_,
                             [&](const Held& held) { return held.participant == participant; });
}

Result<> FirstReplies::Write(msg::Bytes reply, ParticipantId participant) {
  if (!IsNew(participant) && !Holds(participant)) {
    if (!new_until_.empty() && !follow_up_) FollowUp(reply);
    return send_(std::move(reply));
  }
  held_.push_back({participant, std::move(reply)});
  if (held_.size() >= kMostHeld) {
    Release();
    return Ok();
  }
  if (!release_) release_ = loop_.At(loop_.Now() + kHold, [this] { Release(); });
  return Ok();
}

void FirstReplies::Release() {
  if (!held_.empty()) FollowUp(held_.back().reply);
  while (!held_.empty()) {
    const Result<> sent = send_(std::move(held_.front().reply));
    static_cast<void>(sent);  // the client times out
    held_.pop_front();
  }
  release_ = nullptr;
  if (then_.empty()) return;
  run_then_ = loop_.At(loop_.Now(), [this] {
    for (const auto& work : std::exchange(then_, {})) work();
  });
}

void FirstReplies::AfterHeld(std::function<void()> work) {
  if (held_.empty() && then_.empty()) return work();
  then_.push_back(std::move(work));
}

void FirstReplies::FollowUp(const msg::Bytes& reply) {
  if (reply.size() < kClientIdEnd || reply.size() > kLargestFollowUp) return;
  msg::Bytes copy = reply;
  std::fill(copy.begin() + kClientIdBegin, copy.begin() + kClientIdEnd, std::byte{0});
  follow_up_ = loop_.At(loop_.Now() + kFollowUpDelay, [this, copy = std::move(copy)] {
    const Result<> sent = send_(copy);  // if it fails, the next heartbeat comes later
    static_cast<void>(sent);
    follow_up_ = nullptr;
  });
}

}  // namespace musher::transport::dds
