// musher-camera shot: one picture into a file.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/messages/stamp.hpp"
#include "musher/modules/camera/tool/commands.hpp"

namespace musher::camera::tool {

ExitCode Run(const ToolOptions& global, const ShotOptions& options) {
  const auto opened = program::ToolLink::Open(global);
  if (!opened) return Fail(ExitCode::kUsage, opened.error());
  program::ToolLink& link = *opened.value();
  std::optional<msg::Image> taken;
  const auto subscription =
      SubscribeToPictures(link, options.topic, [&](msg::Image&& picture, const auto&) {
        if (!taken) taken = std::move(picture);
      });
  if (!subscription) return Fail(ExitCode::kUsage, subscription.error());
  if (!link.RunUntil([&] { return taken.has_value(); }, Seconds(options.timeout_s))) {
    if (link.interrupted()) return ExitCode::kInterrupted;
    return Fail(ExitCode::kNotDone,
                NothingCame(*subscription.value(), options.topic, global, options.timeout_s));
  }
  const nlohmann::json report = {{"file", options.file},
                                 {"topic", options.topic},
                                 {"frame_id", taken->header.frame_id},
                                 {"stamp_ns", msg::FromStamp(taken->header.stamp).count()},
                                 {"width", taken->width},
                                 {"height", taken->height},
                                 {"encoding", taken->encoding}};
  const std::string shape = std::to_string(taken->width) + "x" + std::to_string(taken->height);
  if (Result<> saved = Save(std::move(*taken), options.file); !saved) {
    return Fail(ExitCode::kNotDone, saved.error());
  }
  if (global.json) {
    std::cout << report.dump(2) << std::endl;
  } else {
    std::cout << options.file << ": " << shape << " of " << options.topic << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::camera::tool
