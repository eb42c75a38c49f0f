#pragma once
// The decision of camera_service on a request. Pure.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "musher/base/result.hpp"
#include "musher/messages/protocol/camera.hpp"

namespace musher::camera {

// Of pictures, videos and the topic `image`; 0: as the camera has it.
struct Shape {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  double rate_hz = 0;

  friend bool operator==(const Shape&, const Shape&) = default;
};

// What the reply depends on beside the request.
struct ServiceState {
  bool on = false;               // the camera
  std::optional<Error> refusal;  // why it may not be used now
  bool recording = false;
  bool publishing = false;
};

struct SetShape {
  Shape shape;
  friend bool operator==(const SetShape&, const SetShape&) = default;
};
struct TakePicture {
  Shape shape;
  std::string file;  // a plain name; empty: one by the time
  friend bool operator==(const TakePicture&, const TakePicture&) = default;
};
struct StartRecording {
  Shape shape;
  std::string file;
  friend bool operator==(const StartRecording&, const StartRecording&) = default;
};
struct StopRecording {
  friend bool operator==(const StopRecording&, const StopRecording&) = default;
};
struct ReportState {
  friend bool operator==(const ReportState&, const ReportState&) = default;
};
struct DeleteFile {
  std::string file;
  friend bool operator==(const DeleteFile&, const DeleteFile&) = default;
};
struct ListFiles {
  friend bool operator==(const ListFiles&, const ListFiles&) = default;
};
struct StartImage {
  Shape shape;
  friend bool operator==(const StartImage&, const StartImage&) = default;
};
struct StopImage {
  friend bool operator==(const StopImage&, const StopImage&) = default;
};

using Decision = std::variant<msg::CameraService::Response,  // a refusal
                              SetShape, TakePicture, StartRecording, StopRecording, ReportState,
                              DeleteFile, ListFiles, StartImage, StopImage>;

// `requested`: the shape set by command 0, for what the request leaves open.
Decision Decide(const msg::CameraService::Request& request, const ServiceState& state,
                const Shape& requested);

// A reply with the code of `result`.
msg::CameraService::Response Answer(std::uint8_t result, std::string text);

// Why a text is no name of a file that camera_service may write or delete; nothing when it is one.
// A valid name stays in the folder: no '/', no leading dot, no control characters.
std::optional<std::string> FaultOfName(const std::string& name);

}  // namespace musher::camera
