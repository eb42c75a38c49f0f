#pragma once
// What one camera does: when its source is opened and closed, which of its frames are published,
// and what is told of it. Pure: no IO, the time is an argument.
//
//   Closed ──wanted──▶ Open ──failed, ended, silent──▶ Open, troubled
//     ▲                  │                                │   opened again after `retry`,
//     └────not wanted────┴────────────────────────────────┘   well at the next frame
//
// A trouble is told once when it begins and once when it is over, however often the source fails
// in between. A source that is only silent is left open where it may come back by itself (a topic);
// all others are opened again.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/pace.hpp"

namespace musher::camera {

// A line for the log, with the code of what was wrong; 0 when it is well again.
struct Told {
  std::int32_t code = kCodeOk;
  std::string text;

  friend bool operator==(const Told&, const Told&) = default;
};

// What is to be done, in this order.
struct CameraActions {
  std::optional<Told> told;
  bool close = false;
  bool open = false;
  bool publish = false;  // the frame

  friend bool operator==(const CameraActions&, const CameraActions&) = default;
};

// Of a frame, what the decision needs.
struct FrameFacts {
  std::int64_t stamp_ns = 0;
  std::uint32_t width_px = 0;
  std::uint32_t height_px = 0;

  friend bool operator==(const FrameFacts&, const FrameFacts&) = default;
};

class CameraCore {
 public:
  CameraCore(const CameraConfig& camera, Duration silence, Duration retry);

  // Whether the camera is to be on.
  CameraActions Want(bool wanted, Time now);

  // What its source says its pictures will be like.
  void OnAnnounced(std::uint32_t width_px, std::uint32_t height_px) {
    expected_ = {width_px, height_px};
  }
  CameraActions OnFrame(const FrameFacts& frame, Time now);
  // The source cannot be opened, or has gone.
  CameraActions OnFailed(const Error& error, Time now);
  // The video is over.
  CameraActions OnEnded(Time now);
  CameraActions Tick(Time now);

  // When Tick() has something to do.
  std::optional<Time> NextTick() const;

  bool wanted() const { return wanted_; }
  // Since it was last wanted.
  bool has_given() const { return has_given_; }
  bool ended() const { return ended_; }
  // What is wrong now.
  const std::optional<Told>& trouble() const { return trouble_; }

  // Told of a code of the camera server.
  static std::int32_t Code(KeyCode key) { return MakeCode(ModuleCode::kCameraServer, key); }

 private:
  CameraActions Trouble(std::int32_t code, std::string text);

  std::string name_;
  SourceKind source_;
  std::string from_;
  double rate_hz_;
  Duration silence_;
  Duration retry_;

  bool wanted_ = false;
  bool open_ = false;
  bool ended_ = false;
  std::optional<Told> trouble_;
  std::optional<Time> reopen_at_;
  Time heard_at_{};  // the last frame, or when it was opened
  bool has_given_ = false;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> expected_;  // size, px
  Pace pace_;
};

}  // namespace musher::camera
