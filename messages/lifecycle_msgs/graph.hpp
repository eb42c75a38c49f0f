#pragma once
#include "musher/messages/lifecycle_msgs/transition_event.hpp"

namespace musher::msg {

// lifecycle_msgs/msg/TransitionDescription
struct TransitionDescription {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::msg::dds_::TransitionDescription_";
  Transition transition;
  State start_state;
  State goal_state;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.transition, m.start_state, m.goal_state);
  }
  friend bool operator==(const TransitionDescription&, const TransitionDescription&) = default;
};

// lifecycle_msgs/srv/GetAvailableStates: service `<node>/get_available_states`.
struct GetAvailableStates {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::srv::dds_::GetAvailableStates_";
  using Request = Empty;
  struct Response {
    std::vector<State> available_states;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.available_states);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// lifecycle_msgs/srv/GetAvailableTransitions: services `<node>/get_available_transitions`, the
// transitions that may be requested now, and `<node>/get_transition_graph`, all transitions.
struct GetAvailableTransitions {
  static constexpr std::string_view kTypeName =
      "lifecycle_msgs::srv::dds_::GetAvailableTransitions_";
  using Request = Empty;
  struct Response {
    std::vector<TransitionDescription> available_transitions;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.available_transitions);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
