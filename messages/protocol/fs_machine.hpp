#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/srv/FsMachine: service `<module>machine_service`, how CyberDog's manager drives a
// module. Field comments: messages/idl/protocol.idl.
struct FsMachine {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::FsMachine_";
  struct Request {
    std::string target_state;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.target_state);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::uint8_t current_state = 0;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.current_state, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
