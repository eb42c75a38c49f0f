#pragma once
// A Qos in Cyclone's form, as rmw_cyclonedds fills it in.

#include <dds/dds.h>

#include <memory>
#include <string>

#include "musher/transport/endpoint.hpp"

namespace musher::transport::dds {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using QosPtr = std::unique_ptr<dds_qos_t, QosDeleter>;

// For a writer or reader; `user_data` may be empty.
QosPtr MakeQos(const Qos& qos, const std::string& user_data);

}  // namespace musher::transport::dds
