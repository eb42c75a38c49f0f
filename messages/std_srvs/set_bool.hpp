#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// std_srvs/srv/SetBool
struct SetBool {
  static constexpr std::string_view kTypeName = "std_srvs::srv::dds_::SetBool_";
  struct Request {
    bool data = false;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.data);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::string message;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.message);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
