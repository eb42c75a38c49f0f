#pragma once
// Queries an application, an actuator that offers a service about itself: `<actuator>/get_behavior`
// of a state machine, `<actuator>/get_tree` of a behaviour tree.

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <variant>

#include "musher/cli/machine/link.hpp"

namespace musher::cli {

// What is queried.
struct ApplicationKind {
  std::string_view service;  // below the actuator's name
  std::string_view what;     // "a state machine", in messages
};

// The failure "no actuator '<name>' in namespace …"; `present`: the actuators that run there.
Failure NoSuchActuator(const Link& link, const GlobalOptions& global, const std::string& name,
                       const std::set<std::string>& present);

namespace internal {

inline constexpr Duration kApplicationAnswerTime = std::chrono::seconds(5);

std::optional<Failure> InvalidName(const std::string& name);
// Collects the running actuators, for the error message. Observers may lack permission to
// subscribe to them.
std::unique_ptr<transport::Subscription> CollectActuators(Link& link, const GlobalOptions& global,
                                                          std::set<std::string>& present);
Failure NotOffered(const std::string& name, const ApplicationKind& kind);
Failure NoAnswerOf(const std::string& name, Duration wait);

}  // namespace internal

// Queries the actuator `name`. The Failure says whether no actuator of that name runs, it is of
// another kind, it does not answer, or it answered with an error.
template <msg::Service S>
std::variant<typename S::Response, Failure> QueryApplication(Link& link,
                                                             const GlobalOptions& global,
                                                             const std::string& name,
                                                             const ApplicationKind& kind,
                                                             const typename S::Request& request) {
  if (auto invalid = internal::InvalidName(name)) return *std::move(invalid);
  std::set<std::string> present;
  const auto statuses = internal::CollectActuators(link, global, present);
  const auto client = transport::MakeClient<S>(
      link.node(),
      transport::ResolveName(global.name_space, name + "/" + std::string(kind.service)));
  if (!client) return Failure{ExitCode::kUsage, client.error()};

  const Duration wait = global.timeout.value_or(internal::kApplicationAnswerTime);
  std::optional<Result<typename S::Response>> reply;
  client.value()->Call(request, wait * 2, [&reply](auto result) { reply = std::move(result); });
  const auto answered = [&reply] { return reply.has_value(); };
  link.RunUntil([&] { return answered() || client.value()->Ready(); },
                std::min(link.discovery(), wait));
  const bool found = answered() || client.value()->Ready();
  if (found) link.RunUntil(answered, wait);
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  if (!found && !present.contains(name)) return NoSuchActuator(link, global, name, present);
  if (!found) return internal::NotOffered(name, kind);
  if (!reply || !*reply) return internal::NoAnswerOf(name, wait);
  if (!reply->value().error.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, name + ": " + reply->value().error}};
  }
  return std::move(*reply).value();
}

}  // namespace musher::cli
