#pragma once
// What cameras and service are given: where they talk, what time it is, where they say what was
// wrong.

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
  std::function<msg::Stamp()> stamp;      // of the module's time, for headers
  std::function<void(const Told&)> tell;  // to the log
  std::function<Result<>()> may_be_used;  // camera_service's own work, or why not
  SourceOpener open;

  std::string Name(std::string_view name) const { return transport::ResolveName(name_space, name); }
};

}  // namespace musher::camera
