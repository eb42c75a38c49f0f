#include "musher/view/record/topic_recorder.hpp"

#include <vector>

#include "musher/view/record/qos_text.hpp"

namespace musher::view {
namespace {

std::vector<transport::Qos> QosOf(const std::map<transport::EndpointId, transport::Qos>& writers) {
  std::vector<transport::Qos> all;
  all.reserve(writers.size());
  for (const auto& [id, qos] : writers) all.push_back(qos);
  return all;
}

}  // namespace

TopicRecorder::TopicRecorder(transport::Node& node, TopicChoice choice, Sink& sink,
                             WallClock wall_clock, OnTrouble on_trouble)
    : node_(node),
      choice_(std::move(choice)),
      sink_(sink),
      wall_clock_(std::move(wall_clock)),
      on_trouble_(std::move(on_trouble)) {}

void TopicRecorder::OnFound(const OfferedWriter& writer) {
  const std::string name = RosTopic(writer.topic);
  if (!choice_.Takes(name)) return;
  const Key key{writer.topic, writer.type};
  auto& topic = topics_[key];
  if (!topic) {
    topic = std::make_unique<Topic>();
    topic->name = name;
    topic->type = writer.type;
  }
  topic->writers[writer.id] = writer.qos;
  // While there are other writers the reader may only become less demanding: a stricter one would
  // be new for no gain.
  if (!topic->reader || QosMatchingAll(QosOf(topic->writers)) != topic->qos) {
    Subscribe(key, *topic);
  }
}

void TopicRecorder::OnLost(transport::EndpointId id) {
  // The reader stays: what it has received already is still delivered.
  for (auto& [key, topic] : topics_) topic->writers.erase(id);
}

void TopicRecorder::Stop() {
  for (auto& [key, topic] : topics_) topic->reader.reset();
}

void TopicRecorder::Subscribe(const Key& key, Topic& topic) {
  transport::Qos qos = QosMatchingAll(QosOf(topic.writers));
  if (topic.reader) {
    // Its writers so far matched a stricter reader; their latched samples are already recorded.
    if (topic.qos.reliability == transport::Qos::Reliability::kBestEffort) {
      qos.reliability = transport::Qos::Reliability::kBestEffort;
    }
    if (topic.qos.durability == transport::Qos::Durability::kVolatile) {
      qos.durability = transport::Qos::Durability::kVolatile;
    }
    if (topic.qos.partition == transport::kEveryPartition) {
      qos.partition = transport::kEveryPartition;
    }
    if (qos == topic.qos) return;
    topic.reader.reset();
  }
  topic.qos = qos;
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = [this, &topic](std::span<const std::byte> bytes,
                                       const transport::SampleInfo&) { OnSample(topic, bytes); };
  auto reader = node_.MakeRawReader(key.first, key.second, qos, std::move(callbacks));
  if (reader) {
    topic.reader = std::move(reader).value();
  } else if (!std::exchange(topic.said, true)) {
    on_trouble_(topic.name + " is not recorded: " + reader.error().message);
  }
}

void TopicRecorder::OnSample(Topic& topic, std::span<const std::byte> bytes) {
  if (!topic.declared) {
    topic.declared = true;
    topic.channel =
        sink_.AddChannel({topic.name, topic.type, QosText(QosOf(topic.writers)),
                          topic.qos.durability == transport::Qos::Durability::kTransientLocal});
  }
  if (sink_.Write(topic.channel, wall_clock_(), {bytes.begin(), bytes.end()})) {
    ++topic.counts.messages;
    topic.counts.bytes += bytes.size();
  } else {
    ++topic.counts.lost;
  }
}

std::map<std::string, RecordedCounts> TopicRecorder::Counts() const {
  std::map<std::string, RecordedCounts> all;
  for (const auto& [key, topic] : topics_) {
    RecordedCounts& counts = all[topic->name];
    counts.messages += topic->counts.messages;
    counts.bytes += topic->counts.bytes;
    counts.lost += topic->counts.lost;
  }
  return all;
}

}  // namespace musher::view
