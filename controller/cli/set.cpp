// musher set STATE [ACTUATOR]: switches the machine or one actuator and prints the outcome.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/switch_request.hpp"

namespace musher::cli {

ExitCode Set(const SetOptions& options, const GlobalOptions& global, Console& console) {
  return RequestSwitch(options.state, options.actuator, global, console);
}

}  // namespace musher::cli
