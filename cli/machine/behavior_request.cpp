#include "musher/cli/machine/behavior_request.hpp"

namespace musher::cli {

BehaviorAnswer QueryBehavior(Link& link, const GlobalOptions& global, const std::string& name,
                             const msg::GetBehavior::Request& request) {
  return QueryApplication<msg::GetBehavior>(
      link, global, name, {"get_behavior", "a state machine (--tree shows a behaviour tree)"},
      request);
}

TreeAnswer QueryTree(Link& link, const GlobalOptions& global, const std::string& name,
                     const msg::GetTree::Request& request) {
  return QueryApplication<msg::GetTree>(link, global, name, {"get_tree", "a behaviour tree"},
                                        request);
}

}  // namespace musher::cli
