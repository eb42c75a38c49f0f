#pragma once
// DDS Security, with the plugins that come with Cyclone.

#include <dds/dds.h>

#include "musher/transport/dds/dds_node.hpp"

namespace musher::transport::dds {

// Sets a participant's QoS for the identity.
void SetCredentials(dds_qos_t* qos, const Credentials& credentials);

}  // namespace musher::transport::dds
