// Requests to the policy: musher wake, keep, low-power, poweroff, reboot.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <functional>

#include "musher/base/host.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"

namespace musher::cli {
namespace {

struct KeepOptions {
  std::string state;
  std::int64_t seconds = 0;
  bool end = false;
};

struct LowPowerOptions {
  bool on = false;
  bool this_run = false;  // else it is saved
};

constexpr Duration kPolicyTimeout = std::chrono::seconds(60);

struct PolicyCommand {
  std::string command;  // as typed, for messages
  msg::RequestPolicy::Request request;
};

// `done` makes the result message from the state that the machine is then in.
ExitCode Request(PolicyCommand policy, const std::function<std::string(const std::string&)>& done,
                 const GlobalOptions& global, Console& console) {
  policy.request.by = UserAtHost();
  const auto link = Link::OpenForCalls(global, &console);
  const auto answer =
      link->CallLeader<msg::RequestPolicy>("request_policy", policy.request, kPolicyTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const auto& response = std::get<msg::RequestPolicy::Response>(answer);
  if (response.code != kCodeOk) {
    return console.Fail(
        {ExitCode::kNotDone, {response.code, policy.command + ": " + response.reason}});
  }
  console.Print(console.mode().json ? PolicyJson(policy.request, response)
                                    : done(response.state) + "\n");
  return ExitCode::kDone;
}

ExitCode Wake(const GlobalOptions& global, Console& console) {
  return Request(
      {"wake", {"wake-up", "", 0, true}},
      [](const std::string& state) { return "awake: the machine is in " + state; }, global,
      console);
}

ExitCode Keep(const KeepOptions& options, const GlobalOptions& global, Console& console) {
  if (options.end) {
    return Request(
        {"keep --end", {"keep", "", 0, false}},
        [](const std::string& state) { return "keep ended; the machine is in " + state; }, global,
        console);
  }
  const auto seconds = options.seconds;
  return Request(
      {"keep " + options.state, {"keep", options.state, seconds, true}},
      [seconds](const std::string& state) {
        return fmt::format("the machine is kept in {} for {} s", state, seconds);
      },
      global, console);
}

ExitCode LowPower(const LowPowerOptions& options, const GlobalOptions& global, Console& console) {
  const char* request = options.this_run ? "low-power" : "low-power-store";
  return Request(
      {"low-power", {request, "", 0, options.on}},
      [&options](const std::string& state) {
        return std::string("automatic LowPower when lying still: ") + (options.on ? "on" : "off") +
               (options.this_run ? ", until the controller exits" : "") +
               (options.on ? "" : "; the machine is in " + state);
      },
      global, console);
}

ExitCode PowerOff(const GlobalOptions& global, Console& console) {
  return Request(
      {"poweroff", {"power-off", "", 0, true}},
      [](const std::string&) { return "the robot is being torn down and powered off"; }, global,
      console);
}

ExitCode Reboot(const GlobalOptions& global, Console& console) {
  return Request(
      {"reboot", {"reboot", "", 0, true}},
      [](const std::string&) { return "the robot is being torn down and rebooted"; }, global,
      console);
}

}  // namespace

void AddWake(Grammar& grammar) {
  grammar.Add("wake", "Wake the robot up from LowPower", Wake, "musher wake");
}

void AddKeep(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("keep", "Switch to a state and hold it, whatever the battery level", Keep,
                  "musher keep Active --for 60");
  constexpr std::int64_t kLongestKeep = 65'535;  // limit of CyberDog's service
  auto* state =
      grammar
          .Offer(app.add_option("STATE", options.state, "Active, Protected, ..."), Names::kStates)
          ->type_name("");
  auto* seconds = app.add_option("--for", options.seconds, "How long")
                      ->check(CLI::Range(std::int64_t{1}, kLongestKeep).description(""))
                      ->type_name("SECONDS");
  auto* end = app.add_flag("--end", options.end, "End it early");
  state->needs(seconds);
  seconds->needs(state);
  end->excludes(state);
  app.preparse_callback([](std::size_t words) {
    if (words == 0) throw CLI::ValidationError("expected STATE --for SECONDS, or --end");
  });
}

void AddLowPower(Grammar& grammar) {
  auto [app, options] = grammar.Add(
      "low-power", "Automatic LowPower when lying still: on, or off, which wakes the robot up",
      LowPower, "musher low-power off --this-run");
  grammar
      .OneOf(app.add_option_function<std::string>(
                 "on|off", [&on = options.on](const std::string& word) { on = word == "on"; },
                 "Saved, unless --this-run"),
             {"on", "off"})
      ->required();
  app.add_flag("--this-run", options.this_run, "Only until the controller ends");
}

void AddPowerOff(Grammar& grammar) {
  grammar.Add("poweroff", "Take the machine down and power the robot off", PowerOff,
              "musher poweroff");
}

void AddReboot(Grammar& grammar) {
  grammar.Add("reboot", "Take the machine down and reboot the robot", Reboot, "musher reboot");
}

}  // namespace musher::cli
