#pragma once
// The config of the camera manager, a TOML file; README.md and config/camera/cameras.toml explain
// its keys.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::camera {

enum class SourceKind : std::uint8_t {
  kWorld,   // another topic
  kVideo,   // a video file
  kDevice,  // a V4L device
  kFolder   // pictures, by name
};

// What a picture is like. 0 or empty: as its source has it.
struct Format {
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;
  std::string encoding;

  friend bool operator==(const Format&, const Format&) = default;
};

struct CameraConfig {
  std::string name;
  std::string topic;     // relative, where its pictures are published
  std::string frame_id;  // of their header
  SourceKind source = SourceKind::kWorld;
  std::string from;   // a topic, an absolute path, or a device's path or number
  bool loops = true;  // a video or a folder restarts at its end
  Format format;
  double rate_hz = 0;      // at most; 0: as the source has it
  bool on_demand = false;  // off while its topics have no subscriber
  double hfov_deg = 0;     // from edge to edge, if the source does not report it; 0: unknown

  friend bool operator==(const CameraConfig&, const CameraConfig&) = default;
};

struct ServiceConfig {
  std::string camera;  // the camera of camera_service
  std::string topic = "image";
  std::string folder;  // absolute, for pictures and videos; empty: "camera" in the state folder

  friend bool operator==(const ServiceConfig&, const ServiceConfig&) = default;
};

struct CamerasConfig {
  Duration self_check_time = Milliseconds(5000);  // how long a camera may take to its first picture
  Duration silence = Milliseconds(2000);          // timeout without a picture
  Duration retry = Milliseconds(2000);            // from a failure to the next attempt
  std::vector<std::string> skip;                  // not checked
  std::vector<std::string> critical;              // a failure fails SelfCheck
  std::vector<State> on_in = {"Active", "Protected"};  // states in which cameras are on
  ServiceConfig service;
  std::vector<CameraConfig> cameras;  // in the order of the file

  friend bool operator==(const CamerasConfig&, const CamerasConfig&) = default;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<CamerasConfig> ReadCamerasFile(const std::string& path);

// The same for a text; `path` is what diagnostics and relative paths refer to.
Parsed<CamerasConfig> ReadCamerasText(std::string_view text, const std::string& path);

}  // namespace musher::camera
