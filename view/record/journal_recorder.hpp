#pragma once
// Records a machine's journal as the topic <namespace>/musher/journal, which does not exist on the
// network: queries the leading controller once a second for new entries. Without a controller it
// records nothing, and goes on when there is one.
//
// Several machines of a namespace are not mixed: it follows the one of this host, else the first
// one that it finds, and then none of another name.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "musher/controller/client/leader_watch.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/record/sink.hpp"
#include "musher/wire/journal_cursor.hpp"

namespace musher::view {

class JournalRecorder {
 public:
  struct Events {
    std::function<void(const std::string& event)> on_event;  // of an entry
    LeaderWatch::OnStatus on_status;                         // of the machine that it follows
  };

  // `host`: this one, see HostId(). Of what is in the journal already, entries after `since_ns` are
  // recorded.
  static Result<std::unique_ptr<JournalRecorder>> Make(transport::Node& node,
                                                       const std::string& name_space,
                                                       const std::string& host, Sink& sink,
                                                       std::int64_t since_ns, Events events);

  std::uint64_t entries() const { return count_; }
  std::uint64_t lost() const { return lost_; }

 private:
  JournalRecorder(std::string name_space, Sink& sink, std::int64_t since_ns, Events events);

  void Query();
  void OnAnswer(const msg::GetHistory::Response& answer);

  std::string name_space_;
  Sink& sink_;
  JournalCursor cursor_;
  Events events_;
  std::optional<std::size_t> channel_;
  std::uint64_t count_ = 0;
  std::uint64_t lost_ = 0;
  bool querying_ = false;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Client<msg::GetHistory>> client_;
  std::unique_ptr<LeaderWatch> leader_;
};

}  // namespace musher::view
