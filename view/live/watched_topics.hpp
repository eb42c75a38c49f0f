#pragma once
// The topics that pages watch: subscribes while one does and a writer is there, and passes on the
// newest sample as JSON, at most ten times a second.
//
// Threads: loop thread only, callbacks too.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "musher/transport/node.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/live/page_queue.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::view {

class WatchedTopics {
 public:
  static constexpr Duration kPeriod = Milliseconds(100);

  using OnLatest = std::function<void(const std::string& topic, const SharedText& message)>;

  // The node and the table must outlive it.
  WatchedTopics(transport::Node& node, const TopicTable& table, OnLatest on_latest);

  // Watches these, and no others any more.
  void Watch(const std::set<std::string>& topics);
  // After a change of the table.
  void OnTopicsChanged();

  // The last message of a watched topic; null: none yet.
  SharedText Last(const std::string& topic) const;

 private:
  struct Topic {
    std::optional<TopicTable::Source> source;
    msg::Bytes newest;
    std::int64_t received_ms = 0;
    bool fresh = false;  // the newest is not passed on yet
    SharedText last;
    std::unique_ptr<transport::RawReader> reader;  // last: its callback uses all of the above
  };

  void Open(const std::string& name, Topic& topic);
  void PassOn();

  transport::Node& node_;
  const TopicTable& table_;
  const OnLatest on_latest_;
  MessageJson json_;
  std::map<std::string, Topic> topics_;
  transport::LoopHandlePtr timer_;  // while topics are watched
};

// {"op":"latest","topic":...,"type":...,"received_ms":...,"message":...}
SharedText LatestMessage(const std::string& topic, const std::string& dds_type,
                         std::int64_t received_ms, const std::string& message_json);

// Time of the system's clock, since 1970.
std::int64_t WallMilliseconds();

}  // namespace musher::view
