#pragma once
// Two processes that exchange a sample over the network of the machine.

#include "musher/base/network_profile.hpp"
#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// At most `timeout`. Uses topics of its own, without credentials. To be used before this process
// has threads.
DdsTrial TryDds(TransportProfile profile, Duration timeout);

}  // namespace musher::cli
