#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// protocol/srv/CameraService: service `camera_service`.
struct CameraService {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::CameraService_";

  static constexpr std::uint8_t kSetParameters = 0;
  static constexpr std::uint8_t kTakePicture = 1;
  static constexpr std::uint8_t kStartRecording = 2;
  static constexpr std::uint8_t kStopRecording = 3;
  static constexpr std::uint8_t kGetState = 4;
  static constexpr std::uint8_t kDeleteFile = 5;
  static constexpr std::uint8_t kListFiles = 6;
  static constexpr std::uint8_t kStartLiveStream = 7;
  static constexpr std::uint8_t kStopLiveStream = 8;
  static constexpr std::uint8_t kStartImagePublish = 9;
  static constexpr std::uint8_t kStopImagePublish = 10;

  static constexpr std::uint8_t kSuccess = 0;
  static constexpr std::uint8_t kInvalidArguments = 1;
  static constexpr std::uint8_t kUnsupported = 2;
  static constexpr std::uint8_t kTimeout = 3;
  static constexpr std::uint8_t kBusy = 4;
  static constexpr std::uint8_t kInvalidState = 5;
  static constexpr std::uint8_t kInnerError = 6;
  static constexpr std::uint8_t kUndefined = 255;

  struct Request {
    std::uint8_t command = 0;
    std::string args;
    std::uint16_t width = 0;   // pixels
    std::uint16_t height = 0;  // pixels
    std::uint16_t fps = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.command, m.args, m.width, m.height, m.fps);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::uint8_t result = 0;
    std::string msg;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.msg, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
