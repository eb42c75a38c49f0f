#pragma once
// Whether a machine and its ROS 2 nodes can meet, by what is set here and in the config: for
// `musher check`, which may run on another computer than the robot, so that all findings are
// warnings.

#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::cli {

// `environment`: that of this process, which a machine that is started here has, too.
std::vector<Diagnostic> CheckRos(const MachineConfig& config,
                                 const transport::Environment& environment);

}  // namespace musher::cli
