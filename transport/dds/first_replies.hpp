#pragma once
// Makes the first reply to a ROS 2 client arrive early.
//
// A newly matched reader lacks the writer's first sequence number until it has requested it
// (Cyclone: 10 ms after the match). If a reply arrives before that, the reader requests a
// repetition at once; that is before Cyclone counts the reply as sent, so it is not repeated, and
// the reader requests it again with the writer's next heartbeat, up to 800 ms later. So:
//
//   reader matched --within 500 ms--> a reply to its participant is held for 12 ms, then sent
//                                     and followed after 110 ms by a copy for no client (id 0),
//                                     which brings a heartbeat if the reply was missed all the same
//
// Replies to other participants are not delayed: a client that comes must not slow the others. The
// new reader may miss such a reply, which was not for it, and then has a gap before the reply to
// its own request; the copy ends that gap, too.
//
// Clients of Musher repeat their request after 10 ms and do not need this: their readers have
// kOwnTag. Threads: loop thread only.

#include <deque>
#include <functional>
#include <map>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/cdr.hpp"
#include "musher/transport/endpoint.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::transport::dds {

// In the USER_DATA of the readers of Musher's clients.
inline constexpr std::string_view kOwnTag = "musher=1;";

class FirstReplies {
 public:
  using Send = std::function<Result<>(msg::Bytes)>;

  FirstReplies(EventLoop& loop, Send send) : loop_(loop), send_(std::move(send)) {}

  // A reader that is not of Musher was matched.
  void OnNewReader(ParticipantId participant);
  // Sends the reply to `participant`, or holds it. Replies to one participant keep their order. A
  // held reply that cannot be sent is lost.
  Result<> Write(msg::Bytes reply, ParticipantId participant);
  // Sends what is held now.
  void Release();
  // Runs `work` when nothing is held: at once or after Release(). It may drop this.
  void AfterHeld(std::function<void()> work);

 private:
  struct Held {
    ParticipantId participant;
    msg::Bytes reply;
  };

  bool IsNew(ParticipantId participant);
  bool Holds(ParticipantId participant) const;
  void FollowUp(const msg::Bytes& reply);

  EventLoop& loop_;
  const Send send_;
  std::map<ParticipantId, Time> new_until_;  // until then its last matched reader is new
  std::deque<Held> held_;
  LoopHandlePtr release_;
  LoopHandlePtr follow_up_;
  std::vector<std::function<void()>> then_;  // once nothing is held
  LoopHandlePtr run_then_;
};

}  // namespace musher::transport::dds
