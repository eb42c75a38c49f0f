#include "musher/cli/machine/application_request.hpp"

#include <fmt/format.h>

#include <vector>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/words.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {

Failure NoSuchActuator(const Link& link, const GlobalOptions& global, const std::string& name,
                       const std::set<std::string>& present) {
  if (present.empty() && !link.HasMachine()) return link.NotFound("actuator");
  if (present.empty()) {
    return {ExitCode::kNoController,
            {kCodeNetError, fmt::format("no actuator '{}' in {}: none runs there", name,
                                        NamespaceText(global.name_space))}};
  }
  const std::vector<std::string> names(present.begin(), present.end());
  const std::string hint = DidYouMean(name, names);
  return {
      ExitCode::kUsage,
      {kCodeParametersInvalid,
       fmt::format("no actuator '{}' in {}{}", name, NamespaceText(global.name_space),
                   hint.empty() ? fmt::format("; running: {}", fmt::join(names, ", ")) : hint)}};
}

namespace internal {

std::optional<Failure> InvalidName(const std::string& name) {
  if (config_toml::IsName(name)) return std::nullopt;
  return Failure{ExitCode::kUsage,
                 {kCodeParametersInvalid, "invalid actuator name '" + name + "'"}};
}

std::unique_ptr<transport::Subscription> CollectActuators(Link& link, const GlobalOptions& global,
                                                          std::set<std::string>& present) {
  transport::Qos qos = transport::kLatchedFromManyQos;
  qos.partition = transport::ReaderPartition(!global.keys.empty());
  auto statuses = transport::MakeSubscription<msg::ActuatorStatus>(
      link.node(), transport::ActuatorStatusTopic(global.name_space),
      [&present](const msg::ActuatorStatus& status, const transport::SampleInfo& info) {
        if (transport::IsFrom(status, info)) present.insert(status.name);
      },
      qos);
  return statuses ? std::move(statuses).value() : nullptr;
}

Failure NotOffered(const std::string& name, const ApplicationKind& kind) {
  return {ExitCode::kNotDone,
          {kCodeUnSupport, fmt::format("{} runs but is not {}: it does not offer {}/{}", name,
                                       kind.what, name, kind.service)}};
}

Failure NoAnswerOf(const std::string& name, Duration wait) {
  return {ExitCode::kNoAnswer,
          {kCodeTimeout, fmt::format("{} did not answer within {:g} s", name, ToSeconds(wait))}};
}

}  // namespace internal
}  // namespace musher::cli
