#pragma once
// An operator's request to the controller's policy. Field comments: messages/idl/musher_msgs.idl.

#include "musher/messages/cdr.hpp"

namespace musher::msg {

// musher_msgs/srv/RequestPolicy: service `musher/request_policy`. Answers when it is done or
// refused; for one that ends the robot, when it is accepted.
struct RequestPolicy {
  static constexpr std::string_view kTypeName = "musher_msgs::srv::dds_::RequestPolicy_";
  struct Request {
    std::string request;
    std::string state;
    std::int64_t seconds = 0;
    bool enable = false;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.request, m.state, m.seconds, m.enable);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t code = 0;
    std::string reason;
    std::string state;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.code, m.reason, m.state);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
