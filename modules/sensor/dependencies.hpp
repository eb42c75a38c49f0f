#pragma once
// What every sensor depends on: the node, the clock, the log.

#include <functional>
#include <string>

#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::sensor {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<msg::Stamp()> stamp;            // now, in the time of the readings' stamps
  std::function<void(const std::string&)> log;  // one line, without its end
  std::function<void(std::int32_t)> report;     // publishes a code in node_errors

  std::string Name(std::string_view name) const { return transport::ResolveName(name_space, name); }
};

}  // namespace musher::sensor
