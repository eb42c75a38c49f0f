// musher down: TearDown in reverse order, then the processes end, then the controller does.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/switch_request.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::cli {

ExitCode Down(const GlobalOptions& global, Console& console) {
  return RequestSwitch(State(kTearDown), "", global, console);
}

}  // namespace musher::cli
