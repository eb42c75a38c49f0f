#pragma once
// What cameras and camera_service depend on: the node, the clock, the log.

#include <functional>
#include <string>

#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/modules/camera/camera_core.hpp"
#include "musher/modules/camera/source.hpp"
#include "musher/transport/node.hpp"

namespace musher::camera {

struct Dependencies {
  transport::Node& node;
  std::string name_space;
  std::function<msg::Stamp()> stamp;        // of the module's time, for headers
  std::function<void(const LogLine&)> log;  // writes to the log
  std::function<Result<>()> may_be_used;    // whether camera_service may be used, or why not
  SourceOpener open;
};

}  // namespace musher::camera
