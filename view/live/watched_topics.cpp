#include "musher/view/live/watched_topics.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/view/http/reply.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view {

namespace {

// Of a skill's feedback; else empty.
std::string SkillOf(const std::string& dds_type, std::span<const std::byte> bytes) {
  if (dds_type != msg::SkillFeedback::kTypeName) return {};
  const auto feedback = msg::Decode<msg::SkillFeedback>(bytes);
  return feedback ? feedback->skill : "";
}

}  // namespace

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

// The place of the writer and its skill. A new one gets the place of a lost writer, else a new
// place, else the place that has been silent for the longest time.
WatchedTopics::Sample& WatchedTopics::SampleOf(Topic& topic, transport::EndpointId writer,
                                               const std::string& skill) {
  std::vector<Sample>& samples = topic.samples;
  const auto own = std::find_if(samples.begin(), samples.end(), [&](const Sample& each) {
    return each.writer == writer && each.skill == skill;
  });
  if (own != samples.end()) return *own;
  const auto lost =
      std::find_if(samples.begin(), samples.end(), [](const Sample& each) { return each.lost; });
  if (lost != samples.end()) {
    lost->writer = writer;
    lost->skill = skill;
    lost->lost = false;
    return *lost;
  }
  if (samples.size() < kMostSamples) {
    Sample& sample = samples.emplace_back();
    sample.writer = writer;
    sample.skill = skill;
    return sample;
  }
  Sample& oldest = *std::min_element(
      samples.begin(), samples.end(),
      [](const Sample& one, const Sample& other) { return one.order < other.order; });
  oldest.writer = writer;
  oldest.skill = skill;
  return oldest;
}

std::string WatchedTopics::KeyOf(const std::string& topic, std::size_t sample) {
  return "latest " + topic + " " + std::to_string(sample);
}

void WatchedTopics::Open(const std::string& name, Topic& topic) {
  topic.reader.reset();
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = [&topic](std::span<const std::byte> bytes,
                                 const transport::SampleInfo& info) {
    Sample& sample = SampleOf(topic, info.writer, SkillOf(topic.source->dds_type, bytes));
    sample.newest.assign(bytes.begin(), bytes.end());
    sample.order = ++topic.received;
    sample.received_ms = WallMilliseconds();
    sample.fresh = true;
  };
  callbacks.on_writer_lost = [&topic](transport::EndpointId writer) {
    for (Sample& sample : topic.samples) {
      if (sample.writer == writer) sample.lost = true;
    }
  };
  auto reader = node_.MakeRawReader("rt" + name, topic.source->dds_type, topic.source->qos,
                                    std::move(callbacks));
  if (reader) topic.reader = std::move(reader).value();
}

void WatchedTopics::PassOn() {
  for (auto& [name, topic] : topics_) {
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < topic.samples.size(); ++i) {
      if (std::exchange(topic.samples[i].fresh, false)) fresh.push_back(i);
    }
    std::sort(fresh.begin(), fresh.end(),
              [&samples = topic.samples](std::size_t one, std::size_t other) {
                return samples[one].order < samples[other].order;
              });
    for (const std::size_t i : fresh) {
      Sample& sample = topic.samples[i];
      const std::string& type = topic.source->dds_type;
      const auto text = json_.ToJson(type, sample.newest);
      if (!text) continue;  // the page says that nothing came
      sample.last = LatestMessage(name, type, sample.received_ms, text.value());
      on_latest_(name, {KeyOf(name, i), sample.last});
    }
  }
}

std::vector<WatchedTopics::Latest> WatchedTopics::Last(const std::string& topic) const {
  const auto found = topics_.find(topic);
  if (found == topics_.end()) return {};
  std::map<std::uint64_t, Latest> by_order;
  const std::vector<Sample>& samples = found->second.samples;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].last) by_order[samples[i].order] = {KeyOf(topic, i), samples[i].last};
  }
  std::vector<Latest> last;
  last.reserve(by_order.size());
  for (auto& [order, latest] : by_order) last.push_back(std::move(latest));
  return last;
}

}  // namespace musher::view
