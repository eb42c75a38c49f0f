#pragma once
// Records a machine's journal as the topic <namespace>/musher/journal, which does not exist on the
// network: queries the controller once a second for new entries. Without a controller it records
// nothing, and goes on when there is one.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/record/sink.hpp"

namespace musher::view {

// Which entries of an answer are new. Entries of the same nanosecond may be in two answers. Pure.
class JournalCursor {
 public:
  explicit JournalCursor(std::int64_t since_ns) : since_ns_(since_ns) {}

  // For the next request: entries after this.
  std::int64_t since_ns() const { return since_ns_; }
  // The indices of the new ones.
  std::vector<std::size_t> Take(const std::vector<msg::HistoryEntry>& entries);

 private:
  using Id = std::tuple<std::int64_t, std::uint64_t, std::uint64_t, std::string>;

  std::int64_t since_ns_;
  std::set<Id> seen_;  // of the last nanosecond
};

class JournalRecorder {
 public:
  using OnEvent = std::function<void(const std::string& event)>;

  static Result<std::unique_ptr<JournalRecorder>> Make(transport::Node& node,
                                                       const std::string& name_space, Sink& sink,
                                                       std::int64_t since_ns, OnEvent on_event);

  std::uint64_t entries() const { return count_; }
  std::uint64_t lost() const { return lost_; }

 private:
  JournalRecorder(std::string name_space, Sink& sink, std::int64_t since_ns, OnEvent on_event);

  void Query();
  void OnAnswer(const msg::GetHistory::Response& answer);

  std::string name_space_;
  Sink& sink_;
  JournalCursor cursor_;
  OnEvent on_event_;
  std::optional<std::size_t> channel_;
  std::uint64_t count_ = 0;
  std::uint64_t lost_ = 0;
  bool querying_ = false;
  transport::LoopHandlePtr timer_;
  std::unique_ptr<transport::Client<msg::GetHistory>> client_;
};

}  // namespace musher::view
