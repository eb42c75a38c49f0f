#pragma once
// DDS Security, with the plugins that come with Cyclone.

#include <dds/dds.h>
#include <dds/ddsrt/log.h>

#include "musher/transport/dds/dds_node.hpp"

namespace musher::transport::dds {

// Sets a participant's QoS for the identity.
void SetCredentials(dds_qos_t* qos, const Credentials& credentials);

// A log sink of Cyclone that writes each line at most once a minute: an unauthenticated participant
// retries for ever, with a line for each attempt. From any thread.
void LogOnceAMinute(void* unused, const dds_log_data_t* data);

}  // namespace musher::transport::dds
