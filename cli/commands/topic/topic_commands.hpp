#pragma once
// The commands of the family `musher topic`, and what several of them have.

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/topics.hpp"
#include "musher/view/topics/topic_reader.hpp"

namespace musher::cli {

void AddTopicEcho(Grammar& grammar, CLI::App& family);
void AddTopicHz(Grammar& grammar, CLI::App& family);

// The first sample of a topic is awaited so long, without --timeout.
inline constexpr Duration kFirstSampleWithin = std::chrono::seconds(5);

// TOPIC, with the names of the domain for completion.
void AddTopicName(Grammar& grammar, CLI::App& app, std::string& topic);
// "/dog1/scan" of "scan" in the namespace dog1.
std::string TopicNamed(const std::string& topic, const GlobalOptions& global);

// The samples of a topic, of every type that its writers have.
class TopicStream {
 public:
  using OnSample = std::function<void(const std::string& dds_type, std::span<const std::byte>)>;

  // `latched`: also the samples from before. `on_sample` runs from the first RunUntil() of the link
  // on; all of them must outlive it.
  static Result<std::unique_ptr<TopicStream>> Begin(Link& link, std::string topic, bool latched,
                                                    OnSample on_sample);

  // Runs the loop until the first sample is received, at most `timeout` after the topic is
  // discovered. A Failure: no topic of this name, or no sample.
  std::optional<Failure> AwaitFirst(Duration timeout);
  // Why it cannot be subscribed to; empty: it can.
  const std::string& trouble() const { return trouble_; }
  const Topics& topics() const { return *topics_; }

 private:
  TopicStream(Link& link, std::string topic, bool latched, OnSample on_sample)
      : link_(link),
        topic_(std::move(topic)),
        latched_(latched),
        on_sample_(std::move(on_sample)) {}
  void OnFound(const transport::DiscoveredEndpoint& endpoint);
  Failure Silence(Duration timeout) const;

  Link& link_;
  const std::string topic_;
  const bool latched_;
  const OnSample on_sample_;
  bool received_ = false;
  std::string trouble_;
  std::map<std::string, std::unique_ptr<view::TopicReader>> readers_;  // by type
  std::unique_ptr<Topics> topics_;
};

}  // namespace musher::cli
