#include "musher/view/live/watched_topics.hpp"

#include <chrono>
#include <utility>

#include "musher/view/http/reply.hpp"
#include "musher/view/record/type_names.hpp"

namespace musher::view {

std::int64_t WallMilliseconds() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count();
}

SharedText LatestMessage(const std::string& topic, const std::string& dds_type,
                         std::int64_t received_ms, const std::string& message_json) {
  return std::make_shared<const std::string>(R"({"op":"latest","topic":)" + http::JsonText(topic) +
                                             R"(,"type":)" + http::JsonText(RosType(dds_type)) +
                                             R"(,"received_ms":)" + std::to_string(received_ms) +
                                             R"(,"message":)" + message_json + "}");
}

WatchedTopics::WatchedTopics(transport::Node& node, const TopicTable& table, OnLatest on_latest)
    : node_(node), table_(table), on_latest_(std::move(on_latest)) {}

void WatchedTopics::Watch(const std::set<std::string>& topics) {
  std::erase_if(topics_, [&topics](const auto& topic) { return !topics.contains(topic.first); });
  for (const std::string& name : topics) topics_.try_emplace(name);
  OnTopicsChanged();
  if (topics_.empty()) {
    timer_.reset();
  } else if (!timer_) {
    timer_ = node_.loop().Every(kPeriod, [this] { PassOn(); });
  }
}

void WatchedTopics::OnTopicsChanged() {
  for (auto& [name, topic] : topics_) {
    // A reader whose writers are gone stays: the same ones may return.
    const std::optional<TopicTable::Source> source = table_.SourceOf(name);
    if (source && source != topic.source) {
      topic.source = source;
      Open(name, topic);
    }
  }
}

void WatchedTopics::Open(const std::string& name, Topic& topic) {
  topic.reader.reset();
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = [&topic](std::span<const std::byte> bytes, const transport::SampleInfo&) {
    topic.newest.assign(bytes.begin(), bytes.end());
    topic.received_ms = WallMilliseconds();
    topic.fresh = true;
  };
  auto reader = node_.MakeRawReader("rt" + name, topic.source->dds_type, topic.source->qos,
                                    std::move(callbacks));
  if (reader) topic.reader = std::move(reader).value();
}

void WatchedTopics::PassOn() {
  for (auto& [name, topic] : topics_) {
    if (!std::exchange(topic.fresh, false)) continue;
    const std::string& type = topic.source->dds_type;
    const auto text = json_.ToJson(type, topic.newest);
    if (!text) continue;  // the page says that nothing came
    topic.last = LatestMessage(name, type, topic.received_ms, text.value());
    on_latest_(name, topic.last);
  }
}

SharedText WatchedTopics::Last(const std::string& topic) const {
  const auto found = topics_.find(topic);
  return found == topics_.end() ? nullptr : found->second.last;
}

}  // namespace musher::view
