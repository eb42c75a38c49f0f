#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// lifecycle_msgs/msg/State. The ids are those of Ros2State (lifecycle/config/ros2_states.hpp).
struct State {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::msg::dds_::State_";
  std::uint8_t id = 0;
  std::string label;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.label);
  }
  friend bool operator==(const State&, const State&) = default;
};

// lifecycle_msgs/msg/Transition
struct Transition {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::msg::dds_::Transition_";
  std::uint8_t id = 0;
  std::string label;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.id, m.label);
  }
  friend bool operator==(const Transition&, const Transition&) = default;
};

// lifecycle_msgs/msg/TransitionEvent: topic `<node>/transition_event`.
struct TransitionEvent {
  static constexpr std::string_view kTypeName = "lifecycle_msgs::msg::dds_::TransitionEvent_";
  std::uint64_t timestamp = 0;
  Transition transition;
  State start_state;
  State goal_state;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.timestamp, m.transition, m.start_state, m.goal_state);
  }
  friend bool operator==(const TransitionEvent&, const TransitionEvent&) = default;
};

}  // namespace musher::msg
