#include "musher/modules/meilin/mission/send_tool.hpp"

#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/actuator/program/module_main.hpp"
#include "musher/messages/r2_interfaces/start_autonomy.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/mission/mission.hpp"
#include "musher/modules/meilin/mission/plan_topic.hpp"
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

constexpr const char* kStartFooter = R"(
Examples:
  musher-meilin start full
  musher-meilin start          # goes on, with the parts that are not done
  musher-meilin send state     # what can begin from where the robot is

Exit codes: 0 begun; 1 refused, or no mission (reason on stderr); 2 usage; 130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

// From the refusal of the first plan on, by which the mission has discovered the sender.
constexpr Duration kUntilKnown = PlanSenders::kJustConnected + std::chrono::seconds(1);

int FailSend(ExitCode exit, const std::string& message) {
  std::cerr << "musher-meilin: " << message << std::endl;
  return static_cast<int>(exit);
}

using OrderedJson = nlohmann::ordered_json;

// What the mission publishes, as it comes: all of its state in one message.
struct Watch {
  explicit Watch(ToolLink& link) {
    auto made = transport::MakeSubscription<msg::String>(
        link.node(), link.Name("meilin/status"),
        [this](const msg::String& message, const transport::SampleInfo&) {
          OrderedJson read = OrderedJson::parse(message.data, nullptr, false);
          if (read.is_object()) status = std::move(read);
        },
        transport::kLatchedQos);
    if (made) subscription_ = std::move(made).value();
  }
  bool complete() const { return !status.is_null(); }
  std::string Text(const char* key) const {
    const auto found = status.find(key);
    return found != status.end() && found->is_string() ? found->get<std::string>() : "";
  }
  std::int64_t Count(const char* key) const {
    const auto found = status.find(key);
    return found != status.end() && found->is_number() ? found->get<std::int64_t>() : 0;
  }

  OrderedJson status;

 private:
  std::unique_ptr<transport::Subscription> subscription_;
};

int NoMission(const ToolLink& link) {
  if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
  return FailSend(ExitCode::kNotDone, link.NotFound("mission").message);
}

// The commands that would begin the match now.
std::string Offers(const Watch& watch) {
  std::string text;
  const auto regions = watch.status.find("can_start");
  if (regions == watch.status.end()) return text;
  for (const OrderedJson& region : *regions) {
    if (!region.is_string()) continue;
    const auto name = region.get<std::string>();
    text += "\n  musher-meilin start" + (name.empty() ? "" : " " + name);
    if (name.empty()) text += "   # goes on with " + watch.Text("goes_on_with");
  }
  return text.empty() ? "" : "\nIt can begin:" + text;
}

void PrintState(const Watch& watch, bool json) {
  if (json) {
    std::cout << watch.status.dump() << std::endl;
    return;
  }
  const auto after = [&watch](const char* separator, const char* key) {
    const std::string text = watch.Text(key);
    return text.empty() ? "" : separator + text;
  };
  std::cout << watch.Text("state") << after(", ", "plan_id") << after(": ", "last_error")
            << after("\nthe last plan was refused: ", "refused_plan")
            << after("\nthe run before ended with ", "last_end") << Offers(watch) << std::endl;
}

transport::ProgramMark MissionMark(const ToolLink& link) {
  return transport::PublisherOf<msg::String>(link.Name("meilin/state"));
}

// Publishes a message once a mission subscribes it. Empty: done.
template <msg::Message M>
std::optional<int> PublishTo(ToolLink& link, const std::string& name, const M& message,
                             std::unique_ptr<transport::DirectedPublisher<M>>& kept) {
  auto made = transport::MakeDirectedPublisher<M>(link.node(), link.Name(name), MissionMark(link));
  if (!made) return FailSend(ExitCode::kUsage, made.error().message);
  kept = std::move(made).value();
  if (!link.Find([&] { return kept->Ready(); })) return NoMission(link);
  Result<> sent = kept->Publish(message);
  if (sent) sent = kept->Flush(link.discovery());
  if (!sent) return FailSend(ExitCode::kNotDone, sent.error().message);
  return std::nullopt;
}

using PlanPublisher = transport::DirectedPublisher<msg::Float32MultiArray>;

// Publishes the plan, and waits for the answer of the mission, which is then in `watch`.
Result<> PublishPlan(ToolLink& link, Watch& watch, PlanPublisher& publisher,
                     const msg::Float32MultiArray& plan) {
  const std::int64_t plans = watch.Count("plans");
  const std::int64_t refusals = watch.Count("refusals");
  if (Result<> sent = publisher.Publish(plan); !sent) return sent;
  if (Result<> sent = publisher.Flush(link.discovery()); !sent) return sent;
  const auto answered = [&] {
    return watch.Count("plans") != plans || watch.Count("refusals") != refusals;
  };
  if (link.Find(answered)) return Ok();
  return Error{kCodeNetError, "the mission did not answer"};
}

// A match that was begun cannot know that the plan of a process that has just connected was written
// just now, where that runs on another computer: this process knows it, and sends the plan again.
bool IsToBeSentAgain(const Watch& watch) {
  return watch.Text("refused_plan") == kSenderHasJustConnected;
}

// `keep`: as a planner, which stays.
int SendPlan(ToolLink& link, const std::string& file, bool keep, bool json) {
  const DrawnPlanReading reading = ReadPlanFile(file);
  // The mission checks it from where the robot is; here only what is no plan at all is refused.
  if (!reading.plan) {
    program::PrintErrors(reading.diagnostics);
    return program::kUsageError;
  }
  Watch watch(link);
  if (!link.Find([&] { return watch.complete(); })) return NoMission(link);
  const std::int64_t plans = watch.Count("plans");
  auto made = transport::MakeDirectedPublisher<msg::Float32MultiArray>(
      link.node(), link.Name("mf_action_seq"), MissionMark(link), transport::kLatchedQos);
  if (!made) return FailSend(ExitCode::kUsage, made.error().message);
  PlanPublisher& publisher = *made.value();
  if (!link.Find([&] { return publisher.Ready(); })) return NoMission(link);
  const msg::Float32MultiArray plan = ToActionSequence(reading.plan->steps);
  Result<> sent = PublishPlan(link, watch, publisher, plan);
  if (sent && watch.Count("plans") == plans && IsToBeSentAgain(watch)) {
    std::cerr << "musher-meilin: the match has just discovered this command; the plan is sent once "
                 "more in some seconds"
              << std::endl;
    link.RunUntil([] { return false; }, kUntilKnown);
    if (link.interrupted()) return static_cast<int>(ExitCode::kInterrupted);
    sent = PublishPlan(link, watch, publisher, plan);
  }
  if (!sent) return FailSend(ExitCode::kNotDone, sent.error().message);
  PrintState(watch, json);
  if (watch.Count("plans") == plans) return static_cast<int>(ExitCode::kNotDone);
  if (keep) link.RunUntil([] { return false; }, std::chrono::hours(24));
  return 0;
}

int SendReset(ToolLink& link) {
  std::unique_ptr<transport::DirectedPublisher<msg::String>> publisher;
  return PublishTo<msg::String>(link, "meilin/command", {"RESET"}, publisher).value_or(0);
}

int StartMatch(ToolLink& link, const std::string& region, bool json) {
  using Reply = Result<msg::StartAutonomy::Response>;
  const auto client =
      transport::MakeClient<msg::StartAutonomy>(link.node(), link.Name("start_autonomy"));
  if (!client) return FailSend(ExitCode::kUsage, client.error().message);
  const auto& service = client.value();
  if (!link.Find([&] { return service->Ready(); })) return NoMission(link);
  std::optional<Reply> reply;
  // It may wait for its first pose, by the machine's clock, which may be slow.
  const Duration limit = link.discovery() + 4 * Mission::kStartWait;
  service->Call({region}, limit, [&reply](const Reply& result) { reply = result; });
  link.RunUntil([&reply] { return reply.has_value(); }, limit);
  if (!reply || !*reply) {
    return FailSend(ExitCode::kNotDone,
                    "the mission did not answer, and may still begin: musher-meilin send state");
  }
  if (!reply->value().success) return FailSend(ExitCode::kNotDone, reply->value().message);
  std::cout << (json ? OrderedJson({{"begun", reply->value().message}}).dump()
                     : reply->value().message)
            << std::endl;
  return 0;
}

int SendState(ToolLink& link, bool json) {
  Watch watch(link);
  if (!link.Find([&] { return watch.complete(); })) return NoMission(link);
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
  bool keep = false;
  plan->add_flag("--keep", keep, "Keeps it published, as a planner does, until Ctrl-C");
  CLI::App* reset = app.add_subcommand(
      "reset", "The robot stands, and the match waits for its start, without a plan");
  app.add_subcommand("state", "Prints the state of the match");
  if (const auto end = program::Parse(app, argc, argv, options)) {
    return program::Print(*end, "musher-meilin");
  }
  const auto link = ToolLink::Open(options);
  if (!link) return FailSend(ExitCode::kUsage, link.error().message);
  if (plan->parsed()) return SendPlan(*link.value(), file, keep, options.json);
  if (reset->parsed()) return SendReset(*link.value());
  return SendState(*link.value(), options.json);
}

int StartTool(int argc, const char* const* argv) {
  CLI::App app("Begins a match: the word of a person, without which nothing moves.",
               "musher-meilin start");
  program::ToolOptions options;
  program::SetUpCommandLineTool(app, options, "Not used by this tool", kStartFooter);
  app.require_subcommand(0);
  std::string region;
  app.add_option("REGION", region,
                 "full: from the preparation on; meilin: the field; final: the rack; without: it "
                 "goes on where it was ended");
  if (const auto end = program::Parse(app, argc, argv, options)) {
    return program::Print(*end, "musher-meilin");
  }
  const auto link = ToolLink::Open(options);
  if (!link) return FailSend(ExitCode::kUsage, link.error().message);
  return StartMatch(*link.value(), region, options.json);
}

}  // namespace musher::meilin
