#pragma once
#include "musher/messages/lifecycle_msgs/transition_event.hpp"

namespace musher::msg {

// lifecycle_msgs/srv/ChangeState: service `<node>/change_state`.
struct ChangeState {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::srv::dds_::ChangeState_";
  struct Request {
    Transition transition;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.transition);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// lifecycle_msgs/srv/GetState: service `<node>/get_state`.
struct GetState {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::srv::dds_::GetState_";
  using Request = Empty;
  struct Response {
    State current_state;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.current_state);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
