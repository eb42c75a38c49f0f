#include "musher/view/topics/topic_reader.hpp"

#include <utility>

#include "musher/view/topics/reader_qos.hpp"

namespace musher::view {

TopicReader::TopicReader(transport::Node& node, std::string topic, std::string type,
                         OnSample on_sample)
    : node_(node),
      topic_(std::move(topic)),
      type_(std::move(type)),
      on_sample_(std::move(on_sample)) {}

std::vector<transport::Qos> TopicReader::Offered() const {
  std::vector<transport::Qos> all;
  all.reserve(writers_.size());
  for (const auto& [id, qos] : writers_) all.push_back(qos);
  return all;
}

Result<> TopicReader::OnFound(transport::EndpointId writer, const transport::Qos& offered) {
  writers_[writer] = offered;
  if (!reader_) return Subscribe(QosMatchingAll(Offered()));
  // Its writers so far matched a stricter reader; their latched samples were received.
  const transport::Qos qos = QosMatchingAll(Offered(), qos_);
  return qos == qos_ ? Ok() : Subscribe(qos);
}

Result<> TopicReader::Subscribe(const transport::Qos& qos) {
  reader_.reset();
  qos_ = qos;
  transport::ReaderCallbacks callbacks;
  callbacks.on_sample = on_sample_;
  auto reader = node_.MakeRawReader(topic_, type_, qos, std::move(callbacks));
  if (!reader) return reader.error();
  reader_ = std::move(reader).value();
  return Ok();
}

}  // namespace musher::view
