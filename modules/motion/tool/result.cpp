// musher-motion result ID: executes one motion to its end.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/modules/motion/tool/commands.hpp"
#include "musher/transport/service.hpp"

namespace musher::motion::tool {
namespace {

constexpr Duration kLongestMotion = std::chrono::seconds(180);

}  // namespace

ExitCode Run(const GlobalOptions& global, const ResultOptions& options) {
  const auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  const auto client = transport::MakeClient<msg::MotionResultCmd>(
      link.value()->node(), link.value()->Name("motion_result_cmd"));
  if (!client) return Fail(ExitCode::kUsage, client.error());
  const MotionArguments& arguments = options.requested.arguments;
  msg::MotionResultCmd::Request request;
  request.motion_id = options.requested.id;
  request.cmd_source = options.source;
  request.duration = arguments.duration_ms;
  request.value = arguments.value;
  request.vel_des = arguments.vel_des;
  request.rpy_des = arguments.rpy_des;
  request.pos_des = arguments.pos_des;
  request.step_height = arguments.step_height;
  std::optional<Result<msg::MotionResultCmd::Response>> reply;
  client.value()->Call(request, kLongestMotion, [&](auto result) { reply = std::move(result); });
  const bool found = link.value()->Find([&] { return client.value()->Ready() || reply; });
  if (!found && !link.value()->interrupted()) {
    return Fail(ExitCode::kNotDone, link.value()->NotFound("motion manager"));
  }
  if (!link.value()->RunUntil([&] { return reply.has_value(); }, kLongestMotion * 2)) {
    return Fail(ExitCode::kInterrupted, {kCodeFailed, "interrupted; the motion continues"});
  }
  if (!*reply) return Fail(ExitCode::kNotDone, reply->error());
  const auto& response = reply->value();
  const std::string name = NameOf(global, options.requested.id);
  if (global.json) {
    std::cout << nlohmann::json{{"motion_id", response.motion_id},
                                {"result", response.result},
                                {"code", response.code},
                                {"text", CodeMeaning(response.code)}}
                     .dump(2)
              << std::endl;
  } else if (response.result) {
    std::cout << "motion " << name << " is done" << std::endl;
  }
  if (response.result) return ExitCode::kDone;
  return Fail(ExitCode::kNotDone,
              {response.code, "motion " + name + ": " + CodeMeaning(response.code)});
}

}  // namespace musher::motion::tool
