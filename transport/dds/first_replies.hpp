#pragma once
// Sees to it that the first reply to a ROS 2 client arrives soon.
//
// A reader that has just been matched does not know where the writer's samples begin until it has
// asked (Cyclone: 10 ms after the match). When a reply comes before that, the reader asks for it
// the moment it sees it; that is before Cyclone counts the reply as sent, so it is not repeated,
// and the reader asks again with the writer's next heartbeat, up to 800 ms later. So:
//
//   reader matched --within 500 ms--> a reply is held for 12 ms, then sent
//                                     and followed after 110 ms by a copy for no client (id 0),
//                                     which brings a heartbeat if the reply was missed all the same
//
// Clients of Musher repeat their request after 10 ms and need none of it; kOwnTag marks their
// readers. Threads: loop thread only.

#include <deque>
#include <functional>
#include <string_view>

#include "musher/lifecycle/result.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::transport::dds {

// In the USER_DATA of the readers of our own clients.
inline constexpr std::string_view kOwnTag = "musher=1;";

class FirstReplies {
 public:
  using Send = std::function<Result<>(msg::Bytes)>;

  FirstReplies(EventLoop& loop, Send send) : loop_(loop), send_(std::move(send)) {}

  // A reader that is not ours was matched.
  void OnNewReader();
  // Sends the reply, or holds it; replies keep their order. A held one that cannot be sent is lost.
  Result<> Write(msg::Bytes reply);
  // Sends what is held now.
  void Release();

 private:
  void FollowUp(const msg::Bytes& reply);

  EventLoop& loop_;
  const Send send_;
  Time new_until_{};  // so long the last reader that came is new
  std::deque<msg::Bytes> held_;
  LoopHandlePtr release_;
  LoopHandlePtr follow_up_;
};

}  // namespace musher::transport::dds
