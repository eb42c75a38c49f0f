#include "musher/cli/machine/skill_request.hpp"

#include <fmt/format.h>

#include <optional>

namespace musher::cli {
namespace {

constexpr Duration kSkillAnswerTime = std::chrono::seconds(5);

// Calls a service of an actuator.
template <class Service>
std::variant<typename Service::Response, Failure> CallSkill(
    Link& link, const GlobalOptions& global, const std::string& actuator, const std::string& name,
    const typename Service::Request& request) {
  const auto client = transport::MakeClient<Service>(
      link.node(), transport::ResolveName(global.name_space, actuator + name));
  if (!client) return Failure{ExitCode::kUsage, client.error()};
  const Duration wait = global.timeout.value_or(kSkillAnswerTime);
  std::optional<Result<typename Service::Response>> reply;
  client.value()->Call(request, wait * 2, [&reply](auto result) { reply = std::move(result); });
  link.RunUntil([&reply] { return reply.has_value(); }, wait);
  if (link.interrupted()) return Failure{ExitCode::kInterrupted, {kCodeFailed, "interrupted"}};
  if (!reply || !*reply) {
    return Failure{
        ExitCode::kNoAnswer,
        {kCodeTimeout, fmt::format("{} did not answer within {:g} s", actuator, ToSeconds(wait))}};
  }
  return std::move(*reply).value();
}

}  // namespace

SkillAnswer QuerySkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::GetSkill::Request& request) {
  auto answer = CallSkill<msg::GetSkill>(link, global, actuator, "/get_skill", request);
  const auto* response = std::get_if<msg::GetSkill::Response>(&answer);
  if (response == nullptr || response->error.empty()) return answer;
  return Failure{ExitCode::kNotDone, {kCodeFailed, actuator + ": " + response->error}};
}

bool SkillRuns(const msg::SkillFeedback& feedback) {
  return feedback.state != "IDLE" && feedback.status == msg::SkillFeedback::kStatusProcessing;
}

PauseAnswer PauseSkill(Link& link, const GlobalOptions& global, const std::string& actuator,
                       const msg::PauseSkill::Request& request) {
  return CallSkill<msg::PauseSkill>(link, global, actuator, "/pause_skill", request);
}

}  // namespace musher::cli
