#include "musher/modules/meilin/mission/send_tool.hpp"

#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/actuator/program/module_main.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"
#include "musher/modules/meilin/plan/plan_file.hpp"
#include "musher/transport/directed_publisher.hpp"

namespace musher::meilin {
namespace {

using program::ExitCode;
using program::ToolLink;

constexpr const char* kSendFooter = R"(
Examples:
  musher-meilin send plan config/meilin/plan_blue.toml
  musher-meilin send reset
  musher-meilin send state --json

Exit codes: 0 done; 1 refused, or no mission (reason on stderr); 2 usage; 130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

int FailSend(ExitCode exit, const std::string& message) {
  std::cerr << "musher-meilin: " << message << std::endl;
  return static_cast<int>(exit);
}

// What the mission publishes, as it comes.
struct Watch {
  explicit Watch(ToolLink& link) {
    Add(link, "meilin/state", state);
    Add(link, "meilin/last_error", last_error);
    Add(link, "meilin/plan_id", plan_id);
  }
  bool complete() const { return state && last_error && plan_id; }

  std::optional<std::string> state;
  std::optional<std::string> last_error;
  std::optional<std::string> plan_id;
  int states = 0;  // messages

 private:
  void Add(ToolLink& link, const std::string& topic, std::optional<std::string>& text) {
    auto made = transport::MakeSubscription<msg::String>(
        link.node(), link.Name(topic),
        [this, &text](const msg::String& message, const transport::SampleInfo&) {
          text = message.data;
          states += &text == &state ? 1 : 0;
        },
        transport::kLatchedQos);
    if (made) subscriptions_.push_back(std::move(made).value());
  }

  std::vector<std::unique_ptr<transport::Subscription>> subscriptions_;
};

int NoMission(const ToolLink& link) {
  if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
  return FailSend(ExitCode::kNotDone, link.NotFound("mission").message);
}

void PrintState(const Watch& watch, bool json) {
  if (json) {
    const nlohmann::ordered_json text = {
        {"state", *watch.state}, {"last_error", *watch.last_error}, {"plan_id", *watch.plan_id}};
    std::cout << text.dump() << std::endl;
    return;
  }
  std::cout << *watch.state << (watch.plan_id->empty() ? "" : ", " + *watch.plan_id)
            << (watch.last_error->empty() ? "" : ": " + *watch.last_error) << std::endl;
}

transport::ProgramMark Mission(const ToolLink& link) {
  return transport::PublisherOf<msg::String>(link.Name("meilin/state"));
}

// Publishes a message once a mission subscribes it. Empty: done.
template <msg::Message M>
std::optional<int> PublishTo(ToolLink& link, const std::string& name, const M& message,
                             std::unique_ptr<transport::DirectedPublisher<M>>& kept) {
  auto made = transport::MakeDirectedPublisher<M>(link.node(), link.Name(name), Mission(link));
  if (!made) return FailSend(ExitCode::kUsage, made.error().message);
  kept = std::move(made).value();
  if (!link.RunUntil([&] { return kept->Ready(); }, link.discovery())) return NoMission(link);
  Result<> sent = kept->Publish(message);
  if (sent) sent = kept->Flush(link.discovery());
  if (!sent) return FailSend(ExitCode::kNotDone, sent.error().message);
  return std::nullopt;
}

int SendPlan(ToolLink& link, const std::string& file, bool json) {
  const DrawnPlanReading reading = ReadPlanFile(file);
  // The mission checks it from where the robot is; here only what is no plan at all is refused.
  if (!reading.plan) {
    program::PrintErrors(reading.diagnostics);
    return program::kUsageError;
  }
  Watch watch(link);
  if (!link.RunUntil([&] { return watch.complete(); }, link.discovery())) return NoMission(link);
  const std::string before = *watch.plan_id;
  const int states = watch.states;
  auto made = transport::MakeDirectedPublisher<msg::Float32MultiArray>(
      link.node(), link.Name("mf_action_seq"), Mission(link), transport::kLatchedQos);
  if (!made) return FailSend(ExitCode::kUsage, made.error().message);
  const auto& publisher = made.value();
  if (!link.RunUntil([&] { return publisher->Ready(); }, link.discovery())) return NoMission(link);
  Result<> sent = publisher->Publish(ToActionSequence(reading.plan->steps));
  if (sent) sent = publisher->Flush(link.discovery());
  if (!sent) return FailSend(ExitCode::kNotDone, sent.error().message);
  const auto answered = [&] {
    return *watch.plan_id != before || (watch.states > states && *watch.state == kPlanRejected);
  };
  if (!link.RunUntil(answered, link.discovery())) {
    return FailSend(ExitCode::kNotDone, "the mission did not answer");
  }
  PrintState(watch, json);
  return *watch.plan_id != before ? 0 : static_cast<int>(ExitCode::kNotDone);
}

int SendReset(ToolLink& link) {
  std::unique_ptr<transport::DirectedPublisher<msg::String>> publisher;
  return PublishTo<msg::String>(link, "meilin/command", {"RESET"}, publisher).value_or(0);
}

int SendState(ToolLink& link, bool json) {
  Watch watch(link);
  if (!link.RunUntil([&] { return watch.complete(); }, link.discovery())) return NoMission(link);
  PrintState(watch, json);
  return 0;
}

}  // namespace

int Send(int argc, const char* const* argv) {
  CLI::App app("Gives a running match a plan, or shows its state.", "musher-meilin send");
  program::ToolOptions options;
  program::SetUpCommandLineTool(app, options, "Not used by this tool", kSendFooter);
  std::string file;
  CLI::App* plan = app.add_subcommand("plan", "Publishes a drawn plan");
  plan->add_option("FILE", file, "As config/meilin/plan_blue.toml")->required();
  CLI::App* reset = app.add_subcommand("reset", "The match begins again, without a plan");
  app.add_subcommand("state", "Prints the state of the match");
  if (const auto end = program::Parse(app, argc, argv, options)) {
    return program::Say(*end, "musher-meilin");
  }
  const auto link = ToolLink::Open(options);
  if (!link) return FailSend(ExitCode::kUsage, link.error().message);
  if (plan->parsed()) return SendPlan(*link.value(), file, options.json);
  if (reset->parsed()) return SendReset(*link.value());
  return SendState(*link.value(), options.json);
}

}  // namespace musher::meilin
