// What a person asks of the policy: musher wake, keep, low-power, poweroff, reboot.

#include <fmt/format.h>

#include <functional>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/link.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/messages/musher_msgs/policy_request.hpp"

namespace musher::cli {
namespace {

constexpr Duration kPolicyTimeout = std::chrono::seconds(60);

struct Asked {
  std::string command;  // as it was typed, for messages
  msg::RequestPolicy::Request request;
};

// `done` makes a sentence of the state that the machine is in then.
ExitCode Ask(const Asked& asked, const std::function<std::string(const std::string&)>& done,
             const GlobalOptions& global, Console& console) {
  const auto link = Link::Open(global);
  if (!link) return console.Fail(link.error());
  const auto answer =
      link.value()->Ask<msg::RequestPolicy>("request_policy", asked.request, kPolicyTimeout);
  if (const auto* failure = std::get_if<Failure>(&answer)) return console.Fail(*failure);
  const auto& response = std::get<msg::RequestPolicy::Response>(answer);
  if (response.code != kCodeOk) {
    return console.Fail(
        {ExitCode::kNotDone, {response.code, asked.command + ": " + response.reason}});
  }
  console.Print(console.mode().json ? PolicyJson(asked.request, response)
                                    : done(response.state) + "\n");
  return ExitCode::kDone;
}

}  // namespace

ExitCode Wake(const GlobalOptions& global, Console& console) {
  return Ask(
      {"wake", {"wake-up", "", 0, true}},
      [](const std::string& state) { return "awake: the machine is in " + state; }, global,
      console);
}

ExitCode Keep(const KeepOptions& options, const GlobalOptions& global, Console& console) {
  if (options.end) {
    return Ask(
        {"keep --end", {"keep", "", 0, false}},
        [](const std::string& state) {
          return "nothing keeps the machine in " + state + " any more";
        },
        global, console);
  }
  const auto seconds = options.seconds;
  return Ask(
      {"keep " + options.state, {"keep", options.state, seconds, true}},
      [seconds](const std::string& state) {
        return fmt::format("the machine is kept in {} for {} s", state, seconds);
      },
      global, console);
}

ExitCode LowPower(const LowPowerOptions& options, const GlobalOptions& global, Console& console) {
  const char* request = options.this_run ? "low-power" : "low-power-store";
  return Ask(
      {"low-power", {request, "", 0, options.on}},
      [&options](const std::string&) {
        return std::string("who lies still ") +
               (options.on ? "goes to LowPower" : "stays as it is") +
               (options.this_run ? ", until the controller ends" : "");
      },
      global, console);
}

ExitCode PowerOff(const GlobalOptions& global, Console& console) {
  return Ask(
      {"poweroff", {"power-off", "", 0, true}},
      [](const std::string&) { return "the robot is being torn down and powered off"; }, global,
      console);
}

ExitCode Reboot(const GlobalOptions& global, Console& console) {
  return Ask(
      {"reboot", {"reboot", "", 0, true}},
      [](const std::string&) { return "the robot is being torn down and rebooted"; }, global,
      console);
}

}  // namespace musher::cli
