#pragma once
// The topics that pages watch: subscribes while one does and a writer is there, and passes on the
// newest sample of each writer as JSON, at most ten times a second: the skills of four robots are
// four samples of one topic. Of `skill_feedback` that is the newest of each skill, since the skills
// of a robot run beside each other.
//
// Threads: loop thread only, callbacks too.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/transport/node.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/live/page_queue.hpp"
#include "musher/view/topics/topic_table.hpp"

namespace musher::view {

class WatchedTopics {
 public:
  static constexpr Duration kPeriod = Milliseconds(100);
  static constexpr std::size_t kMostSamples = 64;  // of a topic, which are kept

  // The newest message of one writer, or of one of its skills. Its key replaces what waits of the
  // same (PageQueue), and passes to the next writer once it is lost, so that there are no more than
  // kMostSamples.
  struct Latest {
    std::string key;
    SharedText message;
  };
  using OnLatest = std::function<void(const std::string& topic, const Latest& latest)>;

  // The node and the table must outlive it.
  WatchedTopics(transport::Node& node, const TopicTable& table, OnLatest on_latest);

  // Watches these, and no others any more.
  void Watch(const std::set<std::string>& topics);
  // After a change of the table.
  void OnTopicsChanged();

  // The last message of each writer of a watched topic, the newest last. Those of lost writers stay
  // until another one takes their place.
  std::vector<Latest> Last(const std::string& topic) const;

 private:
  struct Sample {
    transport::EndpointId writer;
    std::string skill;  // of its skill_feedback; else empty
    bool lost = false;  // the writer
    msg::Bytes newest;
    std::uint64_t order = 0;  // of the receipt
    std::int64_t received_ms = 0;
    bool fresh = false;  // the newest is not passed on yet
    SharedText last;
  };
  struct Topic {
    std::optional<TopicTable::Source> source;
    std::vector<Sample> samples;
    std::uint64_t received = 0;
    std::unique_ptr<transport::RawReader> reader;  // last: its callbacks use all of the above
  };

  static Sample& SampleOf(Topic& topic, transport::EndpointId writer, const std::string& skill);
  static std::string KeyOf(const std::string& topic, std::size_t sample);
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
