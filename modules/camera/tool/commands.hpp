#pragma once
// The commands of musher-camera, one function each: prints what came of it and gives the exit code.

#include <functional>
#include <memory>
#include <string>

#include "musher/lifecycle/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/camera/tool/options.hpp"
#include "musher/transport/node.hpp"

namespace musher::camera::tool {

ExitCode Run(const HandOptions& global, const ListOptions& options);
ExitCode Run(const HandOptions& global, const ShotOptions& options);
ExitCode Run(const HandOptions& global, const StripOptions& options);
ExitCode Run(const HandOptions& global, const WatchOptions& options);

// "musher-camera: <why>" on stderr.
ExitCode Fail(ExitCode exit, const Error& error);

Result<std::unique_ptr<transport::Subscription>> Hear(
    program::HandLink& link, const std::string& topic,
    std::function<void(msg::Image&&, const transport::SampleInfo&)> on_picture);

// Why no picture came: nobody publishes it, or he is silent.
Error NothingCame(const transport::Subscription& subscription, const std::string& topic,
                  const HandOptions& global, double seconds);

// By the clock that was chosen.
Duration AgeOf(const msg::Image& picture, program::HandLink& link, const HandOptions& global);

// As the ending of `file` says; what cannot be converted is refused.
Result<> Save(msg::Image picture, const std::string& file);

std::string Decimal(double value, int digits);
Duration Seconds(double seconds);

}  // namespace musher::camera::tool
