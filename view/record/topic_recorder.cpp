#include "musher/view/record/topic_recorder.hpp"

#include <vector>

#include "musher/view/record/qos_text.hpp"

namespace musher::view {
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
  auto& topic = topics_[{writer.topic, writer.type}];
  if (!topic) {
    topic = std::make_unique<Topic>();
    topic->name = name;
    topic->type = writer.type;
    topic->reader = std::make_unique<TopicReader>(
        node_, writer.topic, writer.type,
        [this, &of = *topic](std::span<const std::byte> bytes, const transport::SampleInfo&) {
          OnSample(of, bytes);
        });
  }
  const auto found = topic->reader->OnFound(writer.id, writer.qos);
  if (!found && !std::exchange(topic->said, true)) {
    on_trouble_(topic->name + " is not recorded: " + found.error().message);
  }
}

void TopicRecorder::OnLost(transport::EndpointId id) {
  for (auto& [key, topic] : topics_) topic->reader->OnLost(id);
}

void TopicRecorder::Stop() {
  for (auto& [key, topic] : topics_) topic->reader->Stop();
}

void TopicRecorder::OnSample(Topic& topic, std::span<const std::byte> bytes) {
  if (!topic.declared) {
    topic.declared = true;
    topic.channel = sink_.AddChannel(
        {topic.name, topic.type, QosText(topic.reader->Offered()),
         topic.reader->qos().durability == transport::Qos::Durability::kTransientLocal});
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
