#pragma once
// The commands of musher-camera, one function each: prints the outcome and returns the exit code.

#include <functional>
#include <memory>
#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/tool/options.hpp"
#include "musher/transport/node.hpp"

namespace musher::camera::tool {

ExitCode Run(const ToolOptions& global, const ListOptions& options);
ExitCode Run(const ToolOptions& global, const ShotOptions& options);
ExitCode Run(const ToolOptions& global, const StripOptions& options);
ExitCode Run(const ToolOptions& global, const WatchOptions& options);

// "musher-camera: <why>" on stderr.
ExitCode Fail(ExitCode exit, const Error& error);

Result<std::unique_ptr<transport::Subscription>> SubscribeToPictures(
    program::ToolLink& link, const std::string& topic,
    std::function<void(msg::Image&&, const transport::SampleInfo&)> on_picture);

// Why no picture was received: the topic has no publisher, or it is silent.
Error NothingCame(const transport::Subscription& subscription, const std::string& topic,
                  const ToolOptions& global, double seconds);

// By the clock of the options.
Duration AgeOf(const msg::Image& picture, program::ToolLink& link, const ToolOptions& global);

// In the format of the ending of `file`; a picture that cannot be converted is refused.
Result<> Save(msg::Image picture, const std::string& file);

Duration Seconds(double seconds);

}  // namespace musher::camera::tool
