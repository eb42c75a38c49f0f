#pragma once
// The last changes of a machine.

#include "musher/behavior/fsm/listener.hpp"
#include "musher/behavior/recent.hpp"

namespace musher::fsm {

using History = Recent<Change>;

}  // namespace musher::fsm
