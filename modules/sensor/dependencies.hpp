#pragma once
// What every sensor is given: where it talks, what time it is, and where it says what was wrong.

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
  std::function<msg::Stamp()> stamp;            // now, as the stamps of readings have it
  std::function<void(const std::string&)> log;  // one line, without its end
  std::function<void(std::int32_t)> report;     // a code, to who collects errors

  std::string Name(std::string_view name) const { return transport::ResolveName(name_space, name); }
};

}  // namespace musher::sensor
