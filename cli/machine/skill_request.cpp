#include "musher/cli/machine/skill_request.hpp"

#include <fmt/format.h>

#include <optional>

namespace musher::cli {
namespace {

constexpr Duration kSkillAnswerTime = std::chrono::seconds(5);

}  // namespace

SkillAnswer QuerySkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::GetSkill::Request& request) {
  const auto client = transport::MakeClient<msg::GetSkill>(
      link.node(), transport::ResolveName(global.name_space, actuator + "/get_skill"));
  if (!client) return Failure{ExitCode::kUsage, client.error()};
  const Duration wait = global.timeout.value_or(kSkillAnswerTime);
  std::optional<Result<msg::GetSkill::Response>> reply;
  client.value()->Call(request, wait * 2, [&reply](auto result) { reply = std::move(result); });
  link.RunUntil([&reply] { return reply.has_value(); }, wait);
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  if (!reply || !*reply) {
    return Failure{
        ExitCode::kNoAnswer,
        {kCodeTimeout, fmt::format("{} did not answer within {:g} s", actuator, ToSeconds(wait))}};
  }
  if (!reply->value().error.empty()) {
    return Failure{ExitCode::kNotDone, {kCodeFailed, actuator + ": " + reply->value().error}};
  }
  return std::move(*reply).value();
}

}  // namespace musher::cli
