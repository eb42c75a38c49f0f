// musher topic hz: the rate of a topic's samples.

#include <CLI/CLI.hpp>
#include <algorithm>

#include "musher/cli/commands/topic/topic_commands.hpp"
#include "musher/cli/render/topic.hpp"

namespace musher::cli {
namespace {

constexpr Duration kRateInterval = std::chrono::seconds(1);

struct TopicHzOptions {
  std::string topic;
  unsigned window = 1000;
  double for_s = 0;  // 0: a report each second, until Ctrl-C
};

ExitCode TopicHz(const TopicHzOptions& options, const GlobalOptions& global, Console& console) {
  const auto opened = Link::Open(global);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  const std::string topic = TopicNamed(options.topic, global);
  SampleRate rate(options.window);
  const auto stream = TopicStream::Begin(
      link, topic, false,
      [&](const std::string&, std::span<const std::byte>) { rate.Add(link.loop().Now()); });
  if (!stream) return console.Fail(stream.error());
  link.EndWithReader();
  const auto failure = stream.value()->AwaitFirst(global.timeout.value_or(kFirstSampleWithin));
  if (failure) return console.Fail(*failure);
  const auto print = [&] {
    console.Print(console.mode().json ? RateJson(topic, rate) : RateText(rate));
  };
  if (options.for_s > 0) {
    link.RunUntil([] { return false; }, std::chrono::duration_cast<Duration>(
                                            std::chrono::duration<double>(options.for_s)));
    print();
    return ExitCode::kDone;
  }
  while (!link.interrupted() && console.HasReader()) {
    const std::size_t before = rate.all();
    link.RunUntil([&] { return !console.HasReader(); }, kRateInterval);
    if (link.interrupted()) break;
    if (rate.all() == before && !console.mode().json) {
      console.Print("no new sample");
    } else {
      print();
    }
  }
  return ExitCode::kDone;
}

}  // namespace

void AddTopicHz(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("hz", "Measure the rate of a topic, each second until Ctrl-C", TopicHz, &family);
  AddTopicName(grammar, app, options.topic);
  app.add_option("--window", options.window, "Of the last N samples; default 1000")
      ->check(CLI::Range(2U, 1'000'000U).description(""))
      ->type_name("N");
  app.add_option("--for", options.for_s, "Measure so long, print one result and end")
      ->check(Between(0.1, 1e6, "seconds"))
      ->type_name("SECONDS");
}

}  // namespace musher::cli
