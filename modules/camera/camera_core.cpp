#include "musher/modules/camera/camera_core.hpp"

#include <utility>

#include "musher/modules/camera/camera_code.hpp"

namespace musher::camera {
namespace {

std::string SizeText(const std::pair<std::uint32_t, std::uint32_t>& size) {
  return std::to_string(size.first) + "x" + std::to_string(size.second);
}

}  // namespace
CameraCore::CameraCore(const CameraConfig& camera, Duration silence, Duration retry)
    : name_(camera.name),
      source_(camera.source),
      from_(camera.from),
      rate_hz_(camera.rate_hz),
      silence_(silence),
      retry_(retry),
      pace_(camera.rate_hz) {}

CameraActions CameraCore::Want(bool wanted, Time now) {
  CameraActions actions;
  if (wanted == wanted_) return actions;
  wanted_ = wanted;
  has_given_ = false;
  expected_.reset();
  pace_ = Pace(rate_hz_);
  fault_.reset();
  reopen_at_.reset();
  ended_ = false;
  actions.open = wanted;
  actions.close = !wanted && std::exchange(open_, false);
  if (wanted) {
    open_ = true;
    last_frame_at_ = now;
  }
  return actions;
}

CameraActions CameraCore::OnFrame(const FrameFacts& frame, Time now) {
  if (!open_) return {};
  CameraActions actions;
  last_frame_at_ = now;
  if (fault_) {
    fault_.reset();
    actions.log = LogLine{kCodeOk, name_ + ": receiving pictures again"};
  }
  const std::pair size(frame.width_px, frame.height_px);
  if (expected_ && *expected_ != size) {
    actions.log =
        LogLine{CameraCode(KeyCode::kParametersInvalid),
                name_ + ": its pictures are " + SizeText(size) + ", not " + SizeText(*expected_)};
  }
  expected_ = size;  // so that it is logged once
  has_given_ = true;
  actions.publish = pace_.Due(frame.stamp_ns);
  return actions;
}

CameraActions CameraCore::OnFailed(const Error& error, Time now) {
  if (!open_) return {};
  CameraActions actions = BeginFault(error.code, error.message);
  actions.close = true;
  open_ = false;
  reopen_at_ = now + retry_;
  return actions;
}

CameraActions CameraCore::OnEnded(Time) {
  if (!open_) return {};
  CameraActions actions;
  actions.log = LogLine{kCodeOk, name_ + ": " + from_ + " has ended"};
  actions.close = true;
  open_ = false;
  ended_ = true;
  return actions;
}

CameraActions CameraCore::Tick(Time now) {
  if (reopen_at_ && now >= *reopen_at_) {
    reopen_at_.reset();
    open_ = true;
    last_frame_at_ = now;
    CameraActions actions;
    actions.open = true;
    return actions;
  }
  if (!open_ || now < last_frame_at_ + silence_) return {};
  const std::string silent = "no picture for " + std::to_string(ToMilliseconds(silence_)) + " ms";
  if (source_ == SourceKind::kWorld) {
    return fault_ ? CameraActions{} : BeginFault(CameraCode(KeyCode::kTimeout), silent);
  }
  return OnFailed({CameraCode(KeyCode::kTimeout), silent}, now);
}

std::optional<Time> CameraCore::NextTick() const {
  if (reopen_at_) return reopen_at_;
  if (!open_) return std::nullopt;
  // A source that was reopened may be silent, too.
  if (fault_ && source_ == SourceKind::kWorld) return std::nullopt;
  return last_frame_at_ + silence_;
}

CameraActions CameraCore::BeginFault(std::int32_t code, std::string text) {
  CameraActions actions;
  LogLine log{code, name_ + ": " + std::move(text)};
  if (!fault_) actions.log = log;
  fault_ = std::move(log);
  return actions;
}

}  // namespace musher::camera
