#pragma once
// The decisions for one camera: when its source is opened and closed, which of its frames are
// published, and what is logged. Pure: no IO, the time is an argument.
//
//   Closed ──wanted──▶ Open ──failed, ended, silent──▶ Open, faulty
//     ▲                  │                                │   reopened after `retry`,
//     └────not wanted────┴────────────────────────────────┘   ok at the next frame
//
// A fault is logged once when it begins and once when it is over, however often the source fails
// in between. A source that is only silent is left open if it can resume by itself (a topic); all
// others are reopened.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/pace.hpp"

namespace musher::camera {

// A line for the log, with the code of the fault; 0 when the fault is over.
struct LogLine {
  std::int32_t code = kCodeOk;
  std::string text;

  friend bool operator==(const LogLine&, const LogLine&) = default;
};

// The actions, in this order.
struct CameraActions {
  std::optional<LogLine> log;
  bool close = false;
  bool open = false;
  bool publish = false;  // the frame

  friend bool operator==(const CameraActions&, const CameraActions&) = default;
};

// What the decision needs of a frame.
struct FrameFacts {
  std::int64_t stamp_ns = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;

  friend bool operator==(const FrameFacts&, const FrameFacts&) = default;
};

class CameraCore {
 public:
  CameraCore(const CameraConfig& camera, Duration silence, Duration retry);

  // Whether the camera should be on.
  CameraActions Want(bool wanted, Time now);

  // The picture size that the source announces.
  void OnAnnounced(std::uint32_t width_px, std::uint32_t height_px) {
    expected_ = {width_px, height_px};
  }
  CameraActions OnFrame(const FrameFacts& frame, Time now);
  // The source cannot be opened, or is lost.
  CameraActions OnFailed(const Error& error, Time now);
  // The video has ended.
  CameraActions OnEnded(Time now);
  CameraActions Tick(Time now);

  // When Tick() is due.
  std::optional<Time> NextTick() const;

  bool wanted() const { return wanted_; }
  // A frame since it was last wanted.
  bool has_given() const { return has_given_; }
  bool ended() const { return ended_; }
  // The present fault.
  const std::optional<LogLine>& fault() const { return fault_; }

 private:
  CameraActions BeginFault(std::int32_t code, std::string text);

  std::string name_;
  SourceKind source_;
  std::string from_;
  double rate_hz_;
  Duration silence_;
  Duration retry_;

  bool wanted_ = false;
  bool open_ = false;
  bool ended_ = false;
  std::optional<LogLine> fault_;
  std::optional<Time> reopen_at_;
  Time last_frame_at_{};  // time of the last frame, or when it was opened
  bool has_given_ = false;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> expected_;  // size, px
  Pace pace_;
};

}  // namespace musher::camera
