// musher-wedding send: publishes inputs of a guest, a detector or a remote control, without ROS.

#include <CLI/CLI.hpp>
#include <functional>
#include <iostream>
#include <variant>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/wedding/tool/tool.hpp"
#include "musher/modules/wedding/topic_names.hpp"
#include "musher/transport/directed_publisher.hpp"

namespace musher::wedding::tool {
namespace {

using program::ExitCode;
using program::ToolLink;

constexpr const char* kFooter = R"(
Examples:
  musher-wedding send target 0.5 0.4 --for 5   a face in the middle, 5 s long
  musher-wedding send gesture heart            requests a photo
  musher-wedding send too-close true
  musher-wedding send command photo            stop, idle, photo, tracking, reset
  musher-wedding send voice stop               as if it had been spoken

Exit codes: 0 published; 1 no show, or /clock stands still (reason on stderr);
2 usage; 130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

constexpr Duration kLongestStandstill = std::chrono::seconds(5);  // of a clock, in real time

struct Input {
  const char* topic = nullptr;
  std::variant<msg::String, msg::Bool, msg::PointStamped> message;
};

int Fail(ExitCode exit, const std::string& message) {
  std::cerr << "musher-wedding: " << message << std::endl;
  return static_cast<int>(exit);
}

// Until `done` holds, however slow the clock runs; false: it stands still, or Ctrl-C was pressed.
bool RunWhileClockGoes(ToolLink& link, const std::function<bool()>& done) {
  while (!done()) {
    const Time before = link.clock().Now();
    const auto moved = [&] { return done() || link.clock().Now() != before; };
    if (!link.RunUntil(moved, kLongestStandstill)) return false;
  }
  return true;
}

template <msg::Message M>
int Publish(ToolLink& link, const std::string& topic, const M& message, Duration time) {
  const auto publisher = transport::MakeDirectedPublisher<M>(
      link.node(), link.Name(topic), transport::PublisherOf<msg::String>(link.Name(topic::kState)));
  if (!publisher) return Fail(ExitCode::kUsage, publisher.error().message);
  if (!link.Find([&] { return publisher.value()->Ready(); })) {
    if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
    return Fail(ExitCode::kNotDone, "no show subscribes to " + topic + "; is it running?");
  }
  Result<> sent = publisher.value()->Publish(message);
  if (time > Duration(0)) {
    if (!link.AwaitClock()) return Fail(ExitCode::kNotDone, "no publisher of /clock");
    const Time end = link.clock().Now() + time;
    const auto again = link.clock().Every(Milliseconds(100), [&] {
      if (sent) sent = publisher.value()->Publish(message);
    });
    const auto over = [&] { return !sent.ok() || link.clock().Now() >= end; };
    const bool stood = !RunWhileClockGoes(link, over);
    if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
    if (stood)
      return Fail(ExitCode::kNotDone, "/clock has stood still for 5 s; does the world run?");
  }
  if (sent) sent = publisher.value()->Flush(link.discovery());
  if (!sent) return Fail(ExitCode::kNotDone, sent.error().message);
  return static_cast<int>(ExitCode::kDone);
}

class Grammar {
 public:
  Grammar() {
    program::SetUpCommandLineTool(app_, options_, "Clock of --for; topic: /clock", kFooter);
    app_.add_option("--for", seconds_, "Repeat it 10 times a second for this time")
        ->check(program::Between(0, 3600))
        ->type_name("SECONDS");
    AddTarget();
    AddWord("gesture", topic::kGesture, "none, heart, v or ok");
    AddWord("command", topic::kCommand, "stop, idle, photo, tracking, reset, search, interview");
    AddWord("voice", topic::kVoiceCommand, "none, photo, interview or stop");
    CLI::App* close = app_.add_subcommand("too-close", "Whether a guest is too close");
    close->add_option("BOOL", too_close_, "true or false")->required()->type_name("");
    close->callback([this] { input_ = {topic::kTooClose, msg::Bool{too_close_}}; });
  }

  int Run(int argc, const char* const* argv) {
    if (const auto end = program::Parse(app_, argc, argv, options_)) {
      return program::Print(*end, "musher-wedding");
    }
    const auto link = ToolLink::Open(options_);
    if (!link) return Fail(ExitCode::kUsage, link.error().message);
    const auto time = FromSeconds(seconds_);
    const int exit = std::visit(
        [&](const auto& message) { return Publish(*link.value(), input_.topic, message, time); },
        input_.message);
    if (options_.json) std::cout << (exit == 0 ? "{\"sent\": true}" : "{\"sent\": false}") << "\n";
    return exit;
  }

 private:
  void AddTarget() {
    CLI::App* command = app_.add_subcommand("target", "A face, where it is in the picture");
    command->add_option("X", point_.x, "0 left, 1 right")->required()->type_name("");
    command->add_option("Y", point_.y, "0 up, 1 down")->required()->type_name("");
    command->add_option("Z", point_.z, "How far, m; default 1.5")->type_name("");
    command->callback([this] {
      input_ = {topic::kTarget, msg::PointStamped{{{}, "camera"}, point_}};
    });
  }
  void AddWord(const char* name, const char* topic, const char* words) {
    CLI::App* command = app_.add_subcommand(name, std::string(words));
    command->add_option("WORD", word_, words)->required()->type_name("");
    command->callback([this, topic] { input_ = {topic, msg::String{word_}}; });
  }

  CLI::App app_{"Publishes inputs of the wedding robot's show.", "musher-wedding send"};
  program::ToolOptions options_;
  double seconds_ = 0;
  msg::Point point_{0.5, 0.5, 1.5};
  bool too_close_ = false;
  std::string word_;
  Input input_;
};

}  // namespace

int PublishInput(int argc, const char* const* argv) {
  return Grammar().Run(argc, argv);
}

}  // namespace musher::wedding::tool
