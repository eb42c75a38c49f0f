// musher-motion status: the present motion of the body.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/modules/motion/motion_code.hpp"
#include "musher/modules/motion/tool/commands.hpp"

namespace musher::motion::tool {

ExitCode Run(const GlobalOptions& global, const StatusOptions&) {
  const auto link = program::ToolLink::Open(global);
  if (!link) return Fail(ExitCode::kUsage, link.error());
  std::optional<msg::MotionStatus> status;
  const auto subscription = transport::MakeSubscription<msg::MotionStatus>(
      link.value()->node(), link.value()->Name("motion_status"),
      [&](const msg::MotionStatus& message, const transport::SampleInfo&) { status = message; });
  if (!subscription) return Fail(ExitCode::kUsage, subscription.error());
  if (!link.value()->Find([&] { return status.has_value(); })) {
    return Fail(ExitCode::kNotDone, link.value()->NotFound("motion manager"));
  }
  const std::int32_t code = CodeOfStatus(status->switch_status);
  if (global.json) {
    std::cout << nlohmann::json{{"motion_id", status->motion_id},
                                {"order_process_bar", status->order_process_bar},
                                {"switch_status", status->switch_status},
                                {"contact", status->contact},
                                {"feet", FeetText(status->contact)},
                                {"ori_error", status->ori_error},
                                {"footpos_error", status->footpos_error},
                                {"motor_error", status->motor_error},
                                {"code", code}}
                     .dump(2)
              << std::endl;
    return ExitCode::kDone;
  }
  if (status->motion_id == kNoMotion) {
    std::cout << "the motion board is silent, or executes a motion that is not in the table"
              << std::endl;
    return ExitCode::kDone;
  }
  const bool changing = status->switch_status == msg::MotionStatus::kTransitioning;
  std::cout << "motion " << NameOf(global, status->motion_id) << ", "
            << int{status->order_process_bar} << " % done" << (changing ? ", changing to it" : "")
            << (code == kCodeOk ? "" : "; " + CodeMeaning(code)) << std::endl
            << "on the ground: " << FeetText(status->contact) << std::endl;
  if (const std::string feet = FootFaultText(status->footpos_error); !feet.empty()) {
    std::cout << "in the wrong place: " << feet << std::endl;
  }
  for (std::size_t i = 0; i < status->motor_error.size(); ++i) {
    const std::int32_t error = status->motor_error[i];
    if (error != 0) std::cout << MotorName(i) << ": " << MotorFaultText(error) << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::motion::tool
