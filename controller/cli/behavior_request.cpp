#include "musher/controller/cli/behavior_request.hpp"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/names.hpp"

namespace musher::cli {
namespace {

constexpr Duration kAnswerTime = std::chrono::seconds(5);

}  // namespace

Failure NoSuchActuator(const Link& link, const GlobalOptions& global, const std::string& name,
                       const std::set<std::string>& present) {
  if (present.empty() && !link.HasMachine()) return link.NotFound("actuator");
  if (present.empty()) {
    return {ExitCode::kNoController,
            {kCodeNetError, fmt::format("no actuator '{}' in namespace '{}': none runs there", name,
                                        global.name_space)}};
  }
  const std::vector<std::string> names(present.begin(), present.end());
  const std::string near = Nearest(name, names);
  return {
      ExitCode::kNoController,
      {kCodeNetError, fmt::format("no actuator '{}' in namespace '{}'; {}", name, global.name_space,
                                  near.empty() ? fmt::format("running: {}", fmt::join(names, ", "))
                                               : fmt::format("did you mean '{}'?", near))}};
}

BehaviorAnswer QueryBehavior(Link& link, const GlobalOptions& global, const std::string& name,
                             const msg::GetBehavior::Request& request) {
  if (!config_toml::IsName(name)) {
    return Failure{ExitCode::kUsage,
                   {kCodeParametersInvalid, "invalid actuator name '" + name + "'"}};
  }
  // The running actuators, for the error message. Observers may lack permission to subscribe to it.
  std::set<std::string> present;
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(!global.keys.empty());
  const auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      link.node(), transport::ActuatorStatusTopic(global.name_space),
      [&present](const msg::ActuatorStatus& status, const transport::SampleInfo&) {
        present.insert(status.name);
      },
      qos);
  const auto client = transport::MakeClient<msg::GetBehavior>(
      link.node(), transport::ResolveName(global.name_space, name + "/get_behavior"));
  if (!client) return Failure{ExitCode::kUsage, client.error()};

  const Duration wait = global.timeout.value_or(kAnswerTime);
  std::optional<Result<msg::GetBehavior::Response>> reply;
  client.value()->Call(request, wait * 2, [&reply](auto result) { reply = std::move(result); });
  const auto answered = [&reply] { return reply.has_value(); };
  link.RunUntil([&] { return answered() || client.value()->Ready(); },
                std::min(link.discovery(), wait));
  const bool found = answered() || client.value()->Ready();
  if (found) link.RunUntil(answered, wait);
  if (link.interrupted()) {
    return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  }
  if (!found && !present.contains(name)) return NoSuchActuator(link, global, name, present);
  if (!found) {
    return Failure{ExitCode::kNotDone,
                   {kCodeUnSupport, name + " runs but is not a state machine: it does not offer " +
                                        name + "/get_behavior"}};
  }
  if (!reply || !*reply) {
    return Failure{ExitCode::kNoAnswer,
                   {kCodeTimeout, fmt::format("{} did not answer within {:g} s", name,
                                              std::chrono::duration<double>(wait).count())}};
  }
  if (!reply->value().error.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, name + ": " + reply->value().error}};
  }
  return std::move(*reply).value();
}

}  // namespace musher::cli
