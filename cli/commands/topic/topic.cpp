// musher topic list, and musher topic info: the topics of the domain, ours and those of ROS 2.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "musher/base/words.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/topic/topic_commands.hpp"
#include "musher/cli/render/topic.hpp"
#include "musher/view/topics/reader_qos.hpp"
#include "musher/view/topics/topic_choice.hpp"

namespace musher::cli {
namespace {

struct TopicListOptions {};

struct TopicInfoOptions {
  std::string topic;
};

ExitCode TopicList(const TopicListOptions&, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto topics = Topics::Begin(*link.value());
  if (!topics) return console.Fail(topics.error());
  topics.value()->AwaitAll(global.timeout.value_or(link.value()->discovery()));
  if (link.value()->interrupted()) return ExitCode::kInterrupted;
  const std::vector<view::ListedTopic> list = topics.value()->table().List();
  if (list.empty()) return console.Fail(Topics::NoTopics());
  console.Print(console.mode().json ? TopicsJson(list) : TopicsText(list, console.mode().colour));
  return ExitCode::kDone;
}

ExitCode TopicInfo(const TopicInfoOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto topics = Topics::Begin(*link.value());
  if (!topics) return console.Fail(topics.error());
  const std::string topic = TopicNamed(options.topic, global);
  if (const auto failure = topics.value()->Await(topic)) return console.Fail(*failure);
  topics.value()->AwaitAll(link.value()->discovery());
  const auto endpoints = topics.value()->table().EndpointsOf(topic);
  const std::vector<Topics::Place> places = topics.value()->PlacesOf(endpoints);
  std::vector<TopicEnd> ends;
  ends.reserve(endpoints.size());
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    ends.push_back({endpoints[i], places[i].node, places[i].pid, places[i].host});
  }
  console.Print(console.mode().json ? TopicInfoJson(topic, ends)
                                    : TopicInfoText(topic, ends, console.mode().colour));
  return ExitCode::kDone;
}

}  // namespace

void AddTopicName(Grammar& grammar, CLI::App& app, std::string& topic) {
  grammar
      .Offer(app.add_option("TOPIC", topic,
                            "For example /scan; without a '/' at its begin\nbelow "
                            "the namespace"),
             Names::kTopics)
      ->required()
      ->type_name("");
}

std::string TopicNamed(const std::string& topic, const GlobalOptions& global) {
  return "/" + transport::ResolveName(global.name_space, topic);
}

Result<std::unique_ptr<TopicStream>> TopicStream::Begin(Link& link, std::string topic, bool latched,
                                                        OnSample on_sample) {
  std::unique_ptr<TopicStream> stream(
      new TopicStream(link, std::move(topic), latched, std::move(on_sample)));
  Topics::Events events;
  events.on_found = [self = stream.get()](const auto& endpoint) { self->OnFound(endpoint); };
  events.on_lost = [self = stream.get()](transport::EndpointId id) {
    for (auto& [type, reader] : self->readers_) reader->OnLost(id);
  };
  auto topics = Topics::Begin(link, std::move(events));
  if (!topics) return topics.error();
  stream->topics_ = std::move(topics).value();
  return stream;
}

void TopicStream::OnFound(const transport::DiscoveredEndpoint& endpoint) {
  if (!endpoint.writer || view::RosTopic(endpoint.topic) != topic_) return;
  auto& reader = readers_[endpoint.type];
  if (!reader) {
    reader = std::make_unique<view::TopicReader>(
        link_.node(), endpoint.topic, endpoint.type,
        [this, type = endpoint.type](std::span<const std::byte> bytes,
                                     const transport::SampleInfo&) {
          received_ = true;
          on_sample_(type, bytes);
        });
  }
  transport::Qos qos = view::QosOf(endpoint);
  if (!latched_) qos.durability = transport::Qos::Durability::kVolatile;
  const auto found = reader->OnFound(endpoint.id, qos);
  if (!found) trouble_ = topic_ + " cannot be subscribed to: " + found.error().message;
}

std::optional<Failure> TopicStream::AwaitFirst(Duration timeout) {
  if (auto failure = topics_->Await(topic_)) return failure;
  link_.RunUntil([this] { return received_ || !trouble_.empty(); }, timeout);
  if (received_) return std::nullopt;
  if (link_.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  return Silence(timeout);
}

Failure TopicStream::Silence(Duration timeout) const {
  if (!trouble_.empty()) return {ExitCode::kNotDone, {kCodePermissionDenied, trouble_}};
  std::size_t writers = 0;
  std::size_t readers = 0;
  for (const auto& end : topics_->table().EndpointsOf(topic_)) ++(end.writer ? writers : readers);
  const std::string why = writers == 0
                              ? "it has no writer, only " + Counted(readers, "reader")
                              : fmt::format("its {} silent; `musher topic info {}` shows {}",
                                            writers == 1 ? "writer is" : "writers are",
                                            ShellWord(topic_), writers == 1 ? "it" : "them");
  return {ExitCode::kNotDone,
          {kCodeTimeout, fmt::format("nothing was published on {} within {:g} s: {}", topic_,
                                     ToSeconds(timeout), why)}};
}

void AddTopic(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("topic", "List, show and measure topics, also ROS 2's",
                                       "musher topic echo /scan");
  grammar.Add("list", "List the topics with their writers, readers and types", TopicList, &family);
  auto [app, options] = grammar.Add(
      "info", "Show the writers and readers of a topic with their QoS", TopicInfo, &family);
  AddTopicName(grammar, app, options.topic);
  AddTopicEcho(grammar, family);
  AddTopicHz(grammar, family);
}

}  // namespace musher::cli
