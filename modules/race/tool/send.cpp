// musher-race send START: publishes a command of a running race, without ROS.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string_view>
#include <vector>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/race/tool/tool.hpp"
#include "musher/modules/race/topic_names.hpp"
#include "musher/transport/directed_publisher.hpp"

namespace musher::race::tool {
namespace {

using program::ExitCode;
using program::ToolLink;

constexpr const char* kFooter = R"(
Examples:
  musher-race send command START           begins the race
  musher-race send START                   the same
  musher-race send START:IN_QRB            to this state, by its name or number
  musher-race send SET_QR_A:A-2            the text of a board; SET_QR_B:B-1, SET_ARROW:left
  musher-race send RESET                   to START, with all results forgotten

Exit codes: 0 published; 1 no race (reason on stderr); 2 usage; 130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

int Fail(ExitCode exit, const std::string& message) {
  std::cerr << "musher-race: " << message << std::endl;
  return static_cast<int>(exit);
}

int Publish(ToolLink& link, const std::string& text) {
  const std::string topic = link.Name(topic::kCommand);
  const auto publisher = transport::MakeDirectedPublisher<msg::String>(
      link.node(), topic, transport::PublisherOf<msg::String>(link.Name(topic::kInfo)));
  if (!publisher) return Fail(ExitCode::kUsage, publisher.error().message);
  if (!link.Find([&] { return publisher.value()->Ready(); })) {
    if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
    return Fail(ExitCode::kNotDone, "no race subscribes to " + topic + "; is it running?");
  }
  Result<> sent = publisher.value()->Publish({text});
  if (sent) sent = publisher.value()->Flush(link.discovery());
  if (!sent) return Fail(ExitCode::kNotDone, sent.error().message);
  return static_cast<int>(ExitCode::kDone);
}

}  // namespace

int PublishCommand(int argc, const char* const* argv) {
  CLI::App app("Publishes a command of a running race.", "musher-race send");
  program::ToolOptions options;
  program::SetUpCommandLineTool(app, options, "Not used by this tool", kFooter);
  std::string text;
  CLI::App* command = app.add_subcommand("command", "The command's text");
  command->add_option("TEXT", text, "START, STOP, RESET, START:<state>, SET_QR_A:A-1, …")
      ->required();
  // `send START` is `send command START`.
  std::vector<const char*> words(argv, argv + argc);
  const auto has = [&](std::string_view word) {
    return std::ranges::find(words, word) != words.end();
  };
  const bool is_text = argc > 1 && !has("command") && !has("-h") && !has("--help");
  if (is_text) words.insert(words.begin() + 1, "command");
  if (const auto end = program::Parse(app, static_cast<int>(words.size()), words.data(), options)) {
    return program::Print(*end, "musher-race");
  }
  const auto link = ToolLink::Open(options);
  if (!link) return Fail(ExitCode::kUsage, link.error().message);
  const int exit = Publish(*link.value(), text);
  if (options.json) std::cout << (exit == 0 ? "{\"sent\": true}" : "{\"sent\": false}") << "\n";
  return exit;
}

}  // namespace musher::race::tool
