#include "musher/view/record/mcap_source.hpp"

#include <utility>

#include "musher/view/record/qos_text.hpp"
#include "musher/view/record/recording_file.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::view {
namespace {

std::string Metadata(const mcap::ScannedChannel& channel, const char* key) {
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? "" : found->second;
}

}  // namespace

Result<std::unique_ptr<McapSource>> McapSource::Open(const std::string& path, TopicChoice choice,
                                                     Duration start, bool machine) {
  auto scan = mcap::Scan::Open(path);
  if (!scan) return scan.error();
  std::unique_ptr<McapSource> source(new McapSource(std::move(scan).value(), std::move(choice)));
  source->Choose(machine);
  source->Order(start);
  return source;
}

void McapSource::Choose(bool machine) {
  for (const auto& [id, channel] : scan_->channels()) {
    if (!choice_.Takes(channel.topic)) continue;
    const auto schema = scan_->schemas().find(channel.schema);
    const std::string type = schema == scan_->schemas().end() ? Metadata(channel, kTypeOfUnknown)
                                                              : DdsType(schema->second.name);
    if (type.empty() || channel.encoding != "cdr") {
      untyped_.insert(channel.topic);
    } else if (!machine && IsOfMachine(channel.topic, RosType(type))) {
      of_machine_.insert(channel.topic);
    } else {
      played_[id] = channels_.size();
      channels_.push_back({channel.topic, type, QosFrom(Metadata(channel, kOfferedQos))});
    }
  }
}

void McapSource::Order(Duration start) {
  const auto& messages = scan_->messages();
  if (messages.empty()) return;
  const std::int64_t from_ns = messages.front().log_ns + start.count();
  std::map<std::size_t, std::size_t> latched;  // the last message before the start, by channel
  for (std::size_t i = 0; i < messages.size(); ++i) {
    const auto played = played_.find(messages[i].channel);
    if (played == played_.end()) continue;
    if (messages[i].log_ns >= from_ns) {
      plan_.push_back({i, messages[i].log_ns});
    } else if (channels_[played->second].qos.durability ==
               transport::Qos::Durability::kTransientLocal) {
      latched[played->second] = i;
    }
  }
  std::vector<Planned> before;
  before.reserve(latched.size());
  for (const auto& [channel, index] : latched) before.push_back({index, from_ns});
  plan_.insert(plan_.begin(), before.begin(), before.end());
}

Result<std::optional<PlayedMessage>> McapSource::Next() {
  if (next_ == plan_.size()) return std::optional<PlayedMessage>();
  const Planned& planned = plan_[next_++];
  const mcap::ScannedMessage& message = scan_->messages()[planned.index];
  auto data = scan_->Read(message);
  if (!data) return data.error();
  return std::optional<PlayedMessage>(
      PlayedMessage{played_.at(message.channel), planned.log_ns, std::move(data).value()});
}

Result<> McapSource::Rewind() {
  next_ = 0;
  return Ok();
}

}  // namespace musher::view
