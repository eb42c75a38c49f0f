#pragma once
// Subscribes to every chosen topic of the domain as soon as it has a writer, with a QoS that
// matches all of its writers, and puts each sample into the sink as it was sent.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "musher/transport/node.hpp"
#include "musher/view/record/sink.hpp"
#include "musher/view/topics/topic_choice.hpp"
#include "musher/view/topics/topic_reader.hpp"

namespace musher::view {

// A writer that discovery has found.
struct OfferedWriter {
  transport::EndpointId id = 0;
  std::string topic;  // of DDS, as the type
  std::string type;
  transport::Qos qos;  // only whether its partition is empty is used
};

struct RecordedCounts {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::uint64_t lost = 0;  // the sink had no room
};

class TopicRecorder {
 public:
  using WallClock = std::function<std::int64_t()>;  // nanoseconds since 1970
  using OnTrouble = std::function<void(const std::string& sentence)>;

  // `on_trouble`: a topic that cannot be subscribed to, said once for each.
  TopicRecorder(transport::Node& node, TopicChoice choice, Sink& sink, WallClock wall_clock,
                OnTrouble on_trouble);

  void OnFound(const OfferedWriter& writer);
  void OnLost(transport::EndpointId id);
  // Ends all subscriptions; the counts stay.
  void Stop();

  const TopicChoice& choice() const { return choice_; }
  std::map<std::string, RecordedCounts> Counts() const;  // by ROS 2's topic
  std::size_t topics() const { return topics_.size(); }

 private:
  struct Topic {
    std::string name;  // ROS 2's
    std::string type;
    bool said = false;
    bool declared = false;
    std::size_t channel = 0;  // if declared
    RecordedCounts counts;
    std::unique_ptr<TopicReader> reader;  // last: it uses all of the above
  };
  using Key = std::pair<std::string, std::string>;  // DDS topic and type

  void OnSample(Topic& topic, std::span<const std::byte> bytes);

  transport::Node& node_;
  TopicChoice choice_;
  Sink& sink_;
  WallClock wall_clock_;
  OnTrouble on_trouble_;
  std::map<Key, std::unique_ptr<Topic>> topics_;  // they stay where they are: callbacks use them
};

}  // namespace musher::view
