#pragma once
// The peer of a musher-exec process, which is the actuator "motion".

#include "musher/test/modules/actuator_peer.hpp"

namespace musher::exec {

class ExecPeer : public test::ActuatorPeer {
 public:
  ExecPeer()
      : ActuatorPeer("motion", {"SetUp", "TearDown", "SelfCheck", "Active", "LowPower"},
                     "musher-exec") {}
};

}  // namespace musher::exec
