// musher behavior NAME [--follow] [--send COMMAND]: the state machine of a running application, or
// with --tree its behaviour tree.

#include <CLI/CLI.hpp>
#include <algorithm>

#include "musher/cli/commands/behavior_tree.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/console/error_json.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/behavior_request.hpp"
#include "musher/cli/machine/meant_actuator.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/text.hpp"
#include "musher/messages/std_msgs/string.hpp"

namespace musher::cli {
namespace {

struct BehaviorOptions {
  std::string name;
  std::uint32_t history = 10;  // changes
  bool follow = false;
  std::string send;      // a command; empty: only show the state machine
  bool tree = false;     // the behaviour tree instead
  bool entries = false;  // of its blackboards, too
};

using Report = msg::GetBehavior::Response;

constexpr std::uint32_t kAllChanges = 1000;  // more than a machine remembers
constexpr Duration kSendTime = std::chrono::seconds(5);

void Print(const std::string& name, const Report& report, Console& console) {
  console.Print(console.mode().json ? BehaviorJson(name, report)
                                    : BehaviorText(name, report, console.mode().colour));
}

// The changes after `last`; all of them if it is not among them.
std::vector<msg::BehaviorChange> Since(const std::optional<msg::BehaviorChange>& last,
                                       std::vector<msg::BehaviorChange> changes) {
  if (!last) return changes;
  const auto found = std::find(changes.rbegin(), changes.rend(), *last);
  if (found != changes.rend()) changes.erase(changes.begin(), found.base());
  return changes;
}

class Watch {
 public:
  Watch(Link& link, const GlobalOptions& global, const std::string& name, Console& console)
      : link_(link), global_(global), name_(name), console_(console) {}

  ExitCode Run(const Report& begin) {
    Remember(begin);
    link_.EndWithReader();
    transport::SubscriptionEvents events;
    events.on_writer_lost = [this](transport::EndpointId) { lost_ = true; };
    const auto states = transport::MakeSubscription<msg::String>(
        link_.node(), transport::ResolveName(global_.name_space, name_ + "/behavior_state"),
        [this](const msg::String&, const transport::SampleInfo&) { changed_ = true; },
        transport::kLatchedQos, std::move(events));
    if (!states) return console_.Fail(states.error());
    // The latched state arrives at once, unless the application exits before it is discovered.
    const bool found = link_.RunUntil([this] { return changed_ || lost_; }, link_.discovery());
    if (!found) lost_ = true;
    while (!link_.interrupted() && console_.HasReader()) {
      link_.RunUntil([this] { return changed_ || lost_; }, std::chrono::hours(24));
      if (std::exchange(changed_, false)) PrintChanges();
      if (std::exchange(lost_, false)) PrintLost();
    }
    return ExitCode::kDone;
  }

 private:
  void PrintChanges() {
    const auto answer = QueryBehavior(link_, global_, name_, {"", kAllChanges});
    if (link_.interrupted()) return;
    if (const auto* failure = std::get_if<Failure>(&answer)) return PrintFailure(*failure);
    Report report = std::get<Report>(answer);
    const bool moved = report.current_state != state_;
    report.history = Since(last_, std::move(report.history));
    if (report.history.empty() && !moved) return;
    if (console_.mode().json) {
      console_.Print(BehaviorJson(name_, report));
    } else {
      console_.Print(BehaviorLines(report, WallNow(), console_.mode().colour));
    }
    Remember(report);
  }
  // A restarted application begins a new history.
  void PrintLost() {
    last_.reset();
    state_.clear();
    PrintFailure({ExitCode::kNoController, {kCodeNetError, name_ + " is lost"}});
  }
  void PrintFailure(const Failure& failure) {
    if (console_.mode().json) return console_.Print(FailureJson(failure));
    console_.Print(LocalTime(WallNow()) + "  " + failure.error.message);
  }
  void Remember(const Report& report) {
    state_ = report.current_state;
    if (!report.history.empty()) last_ = report.history.back();
  }

  Link& link_;
  const GlobalOptions& global_;
  const std::string& name_;
  Console& console_;
  bool changed_ = false;
  bool lost_ = false;
  std::string state_;
  std::optional<msg::BehaviorChange> last_;
};

// Sends options.send to the application, which need not be discovered yet.
std::optional<Failure> Send(Link& link, const GlobalOptions& global,
                            const BehaviorOptions& options) {
  using Reply = Result<msg::SendCommand::Response>;
  const auto meant = MeantActuator::Begin(link, global);
  if (!meant) return Failure{ExitCode::kUsage, meant.error()};
  if (auto failure = meant.value()->Check(options.name)) return failure;
  const auto client = transport::MakeClient<msg::SendCommand>(
      link.node(), transport::ResolveName(global.name_space, options.name + "/send_command"));
  if (!client) return Failure{ExitCode::kUsage, client.error()};
  std::optional<Reply> reply;
  const Duration wait = global.timeout.value_or(kSendTime);
  client.value()->Call({options.send}, wait, [&reply](auto result) { reply = std::move(result); });
  link.RunUntil([&reply] { return reply.has_value(); }, wait);
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  if (!reply || !*reply) {
    return Failure{
        ExitCode::kNoAnswer,
        {kCodeTimeout, options.name + " did not answer whether it accepts " + options.send}};
  }
  if (!reply->value().success) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, reply->value().message}};
  }
  return std::nullopt;
}

ExitCode Behavior(const BehaviorOptions& options, const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global, &console);
  if (!link) return console.Fail(link.error());
  if (options.tree) {
    if (!options.send.empty()) {
      if (const auto failure = Send(*link.value(), global, options)) return console.Fail(*failure);
    }
    return ShowTree(*link.value(), global,
                    {options.name, options.history, options.entries, options.follow}, console);
  }
  const auto answer = QueryBehavior(*link.value(), global, options.name,
                                    {"", options.follow ? kAllChanges : options.history});
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const auto& report = std::get<Report>(answer);
  if (!options.send.empty()) {
    if (const auto failure = Send(*link.value(), global, options)) return console.Fail(*failure);
    if (!options.follow) {
      console.Print(console.mode().json ? BehaviorSentJson(options.name, options.send)
                                        : "sent " + options.send + " to " + options.name + "\n");
      return ExitCode::kDone;
    }
  }
  Report shown = report;
  if (shown.history.size() > options.history) {
    shown.history.erase(shown.history.begin(), shown.history.end() - options.history);
  }
  Print(options.name, shown, console);
  if (!options.follow) return ExitCode::kDone;
  return Watch(*link.value(), global, options.name, console).Run(report);
}

}  // namespace

void AddBehavior(Grammar& grammar) {
  auto [app, options] = grammar.Add("behavior", "Show the state machine or tree of an application",
                                    Behavior, "musher behavior show --follow");
  grammar
      .Offer(app.add_option("NAME", options.name, "The application's actuator"),
             Names::kApplications)
      ->required()
      ->type_name("");
  app.add_option("--history", options.history, "Number of latest changes to show; default 10")
      ->check(CLI::Range(0U, 1000U).description(""))
      ->type_name("N");
  app.add_flag("-f,--follow", options.follow, "Show every change as it happens");
  auto* tree = app.add_flag("-t,--tree", options.tree,
                            "Show its behaviour tree; --follow redraws it on a terminal");
  app.add_flag("--entries", options.entries, "Also show the blackboards of the tree")->needs(tree);
  grammar
      .Offer(
          app.add_option(
              "--send", options.send,
              "Send it this command, which it must have registered; START begins one that waits"),
          Names::kCommands)
      ->check([](const std::string& word) { return word.empty() ? "needs a command" : ""; })
      ->type_name("COMMAND");
}

}  // namespace musher::cli
