// musher topic echo: prints the samples of a topic.

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "musher/cli/commands/topic/topic_commands.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/render/topic.hpp"
#include "musher/messages/definitions.hpp"
#include "musher/view/json/message_json.hpp"
#include "musher/view/topics/type_names.hpp"

namespace musher::cli {
namespace {

struct TopicEchoOptions {
  std::string topic;
  unsigned samples = 0;  // 0: until Ctrl-C
  bool full_length = false;
};

// Prints samples until there are enough.
class SamplePrinter {
 public:
  SamplePrinter(std::string topic, const TopicEchoOptions& options, Console& console)
      : topic_(std::move(topic)), options_(options), console_(console) {}

  void Print(const std::string& type, std::span<const std::byte> bytes) {
    if (done()) return;
    const auto text = json_.ToJson(type, bytes);
    if (!text) {
      if (failure_.empty()) console_.PrintError(Reason(type, text.error()));
      failure_ = text.error().message;
      return;
    }
    ++printed_;
    console_.Print(console_.mode().json ? SampleJson(topic_, type, WallNow(), text.value())
                                        : SampleText(text.value(), options_.full_length) + "---");
  }
  // Enough were printed, or the samples cannot be shown.
  bool done() const {
    return (options_.samples != 0 && printed_ == options_.samples) ||
           (printed_ == 0 && !failure_.empty());
  }
  bool failed() const { return printed_ == 0 && !failure_.empty(); }

 private:
  std::string Reason(const std::string& type, const Error& error) const {
    if (msg::FindDefinition(type) != nullptr) return topic_ + ": " + error.message;
    const std::string ros = view::RosType(type);
    return fmt::format(
        "{} has the type {}, which Musher does not know; `musher topic hz` and `musher record` "
        "need no definition",
        topic_, ros.empty() ? type : ros);
  }

  const std::string topic_;
  const TopicEchoOptions& options_;
  Console& console_;
  view::MessageJson json_;
  unsigned printed_ = 0;
  std::string failure_;
};

ExitCode TopicEcho(const TopicEchoOptions& options, const GlobalOptions& global, Console& console) {
  const auto opened = Link::Open(global);
  if (!opened) return console.Fail(opened.error());
  Link& link = *opened.value();
  const std::string topic = TopicNamed(options.topic, global);
  SamplePrinter printer(topic, options, console);
  const auto stream = TopicStream::Begin(
      link, topic, true, [&](const std::string& type, std::span<const std::byte> bytes) {
        printer.Print(type, bytes);
      });
  if (!stream) return console.Fail(stream.error());
  link.EndWithReader();
  const auto failure = stream.value()->AwaitFirst(global.timeout.value_or(kFirstSampleWithin));
  if (failure) return console.Fail(*failure);
  while (!printer.done() && !link.interrupted() && console.HasReader()) {
    link.RunUntil([&] { return printer.done() || !console.HasReader(); }, std::chrono::hours(24));
  }
  return printer.failed() ? ExitCode::kNotDone : ExitCode::kDone;
}

}  // namespace

void AddTopicEcho(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("echo", "Print the samples of a topic, until Ctrl-C", TopicEcho, &family);
  AddTopicName(grammar, app, options.topic);
  app.add_option("-n,--samples", options.samples, "End after so many samples; default: none")
      ->check(CLI::Range(1U, 1'000'000'000U).description(""))
      ->type_name("N");
  app.add_flag("--full-length", options.full_length,
               "All elements of lists; default: the first 16");
}

}  // namespace musher::cli
