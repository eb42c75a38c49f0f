#pragma once
#include "musher/messages/builtin_interfaces/time.hpp"
#include "musher/messages/protocol/audio.hpp"

namespace musher::msg {

using Uuid = std::array<std::uint8_t, 16>;

// protocol/action/Speech: action `speech_text_action`, in the parts that ROS 2 makes of it.
struct Speech {
  struct Goal {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_Goal_";
    std::string module_name;
    bool is_online = false;
    AudioPlay speech;
    std::string text;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.module_name, m.is_online, m.speech, m.text);
    }
    friend bool operator==(const Goal&, const Goal&) = default;
  };
  // 0 success, 1 failed
  struct Result {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_Result_";
    std::uint8_t status = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.status);
    }
    friend bool operator==(const Result&, const Result&) = default;
  };
  struct Feedback {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_Feedback_";
    bool talking = false;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.talking);
    }
    friend bool operator==(const Feedback&, const Feedback&) = default;
  };
  struct FeedbackMessage {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_FeedbackMessage_";
    Uuid goal_id{};
    Feedback feedback;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.goal_id, m.feedback);
    }
    friend bool operator==(const FeedbackMessage&, const FeedbackMessage&) = default;
  };
  // service `speech_text_action/_action/send_goal`
  struct SendGoal {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_SendGoal_";
    struct Request {
      Uuid goal_id{};
      Goal goal;

      template <class Self>
      static auto Fields(Self& m) {
        return std::tie(m.goal_id, m.goal);
      }
      friend bool operator==(const Request&, const Request&) = default;
    };
    struct Response {
      bool accepted = false;
      Stamp stamp;

      template <class Self>
      static auto Fields(Self& m) {
        return std::tie(m.accepted, m.stamp);
      }
      friend bool operator==(const Response&, const Response&) = default;
    };
  };
  // service `speech_text_action/_action/get_result`
  struct GetResult {
    static constexpr std::string_view kTypeName = "protocol::action::dds_::Speech_GetResult_";
    struct Request {
      Uuid goal_id{};

      template <class Self>
      static auto Fields(Self& m) {
        return std::tie(m.goal_id);
      }
      friend bool operator==(const Request&, const Request&) = default;
    };
    struct Response {
      std::int8_t status = 0;
      Result result;

      template <class Self>
      static auto Fields(Self& m) {
        return std::tie(m.status, m.result);
      }
      friend bool operator==(const Response&, const Response&) = default;
    };
  };
};

// protocol/srv/AudioNickName: the robot's name, and the word that wakes it.
struct AudioNickName {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::AudioNickName_";
  struct Request {
    std::string nick_name;
    std::string wake_name;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.nick_name, m.wake_name);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool success = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.success, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
