#pragma once
// Receives the samples of one topic from all of its writers, whatever their QoS: its reader
// requests no more than each of them offers, and is made again when one offers less.
//
// Threads: loop thread only.

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "musher/transport/node.hpp"

namespace musher::view {

class TopicReader {
 public:
  using OnSample = std::function<void(std::span<const std::byte>, const transport::SampleInfo&)>;

  // `topic` and `type` of DDS; the node must outlive it.
  TopicReader(transport::Node& node, std::string topic, std::string type, OnSample on_sample);
  TopicReader(const TopicReader&) = delete;
  TopicReader& operator=(const TopicReader&) = delete;

  // A writer that discovery has found. Of its partition only whether it is empty is used. Fails if
  // the topic cannot be subscribed to.
  Result<> OnFound(transport::EndpointId writer, const transport::Qos& offered);
  // The reader stays: what it has received already is still delivered.
  void OnLost(transport::EndpointId writer) { writers_.erase(writer); }
  // Ends the subscription.
  void Stop() { reader_.reset(); }

  // Of the writers that were found and not lost.
  std::vector<transport::Qos> Offered() const;
  const transport::Qos& qos() const { return qos_; }  // of the reader

 private:
  Result<> Subscribe(const transport::Qos& qos);

  transport::Node& node_;
  const std::string topic_;
  const std::string type_;
  const OnSample on_sample_;
  std::map<transport::EndpointId, transport::Qos> writers_;
  transport::Qos qos_;
  std::unique_ptr<transport::RawReader> reader_;  // last: its callbacks use all of the above
};

}  // namespace musher::view
