#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/msg/AudioPlay: topic `speech_play`, a phrase by its number. Interrupts what plays.
struct AudioPlay {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::AudioPlay_";

  static constexpr std::uint16_t kSelfCheckOk = 60;
  static constexpr std::uint16_t kSelfCheckFailed = 61;
  static constexpr std::uint16_t kBatteryLevel = 1000;  // plus the charge in %
  static constexpr std::uint16_t kAppConnected = 2002;
  static constexpr std::uint16_t kStarted = 5300;
  static constexpr std::uint16_t kReady = 9000;
  static constexpr std::uint16_t kStop = 9999;
  static constexpr std::uint16_t kBattery0 = 10000;
  static constexpr std::uint16_t kBattery5 = 10005;
  static constexpr std::uint16_t kBattery20 = 10020;
  static constexpr std::uint16_t kBattery30 = 10030;

  std::string module_name;  // the caller
  std::uint16_t play_id = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.module_name, m.play_id);
  }
  friend bool operator==(const AudioPlay&, const AudioPlay&) = default;
};

// protocol/msg/AudioPlayExtend: topic `speech_play_extend`, a phrase or a text.
struct AudioPlayExtend {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::AudioPlayExtend_";
  std::string module_name;
  bool is_online = false;  // true: `text` is spoken; false: `speech` is played
  AudioPlay speech;
  std::string text;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.module_name, m.is_online, m.speech, m.text);
  }
  friend bool operator==(const AudioPlayExtend&, const AudioPlayExtend&) = default;
};

// protocol/msg/AudioStatus: whether the microphone listens.
struct AudioStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::AudioStatus_";

  static constexpr std::uint8_t kNormal = 0;
  static constexpr std::uint8_t kOffMic = 1;

  std::uint8_t state = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.state);
  }
  friend bool operator==(const AudioStatus&, const AudioStatus&) = default;
};

// protocol/srv/AudioTextPlay: service `speech_text_play`, answered when the sound has ended.
struct AudioTextPlay {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::AudioTextPlay_";

  static constexpr std::uint8_t kFinished = 0;
  static constexpr std::uint8_t kFailed = 1;

  struct Request {
    std::string module_name;
    bool is_online = false;  // true: `text` is spoken; false: `speech` is played
    AudioPlay speech;
    std::string text;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.module_name, m.is_online, m.speech, m.text);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::uint8_t status = 0;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.status, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/AudioVolumeGet: service `audio_volume_get`.
struct AudioVolumeGet {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::AudioVolumeGet_";
  using Request = Empty;
  struct Response {
    std::uint8_t volume = 0;  // 0 to 100
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.volume, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/AudioVolumeSet: service `audio_volume_set`.
struct AudioVolumeSet {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::AudioVolumeSet_";
  struct Request {
    std::uint8_t volume = 0;  // 0 to 100

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.volume);
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

// protocol/srv/AudioExecute: services `set_audio_state`, which takes `status`, and
// `get_audio_state`, which does not look at it.
struct AudioExecute {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::AudioExecute_";
  struct Request {
    std::string client;
    AudioStatus status;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.client, m.status);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool result = false;  // set: done; get: the microphone is off
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/SdcardPlayIdQuery: service `sdcard_playid_query`, whether a phrase exists.
struct SdcardPlayIdQuery {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::SdcardPlayIdQuery_";
  struct Request {
    std::uint16_t play_id = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.play_id);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool exist = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.exist, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
