#pragma once
// ROS 2's mapping of services on DDS topics, types and QoS.

#include <string>

#include "musher/transport/endpoint.hpp"

namespace musher::transport {

inline std::string RequestTopic(const std::string& service) {
  return "rq/" + service + "Request";
}
inline std::string ReplyTopic(const std::string& service) {
  return "rr/" + service + "Reply";
}
inline std::string RequestType(const std::string& type) {
  return type + "Request_";
}
inline std::string ResponseType(const std::string& type) {
  return type + "Response_";
}

// Matches ROS 2's service QoS. The depth is local to each side: a reader that keeps all does not
// lose the eleventh of many simultaneous requests.
inline constexpr Qos kServiceReaderQos{Qos::Reliability::kReliable, Qos::Durability::kVolatile, 0};

}  // namespace musher::transport
