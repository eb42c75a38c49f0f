#pragma once
// The pictures of one camera for one detector: the subscription while it is on, the accepted
// pictures and their lens, and the supervision: invalid pictures, a camera that repeats its last
// ones, two cameras on one topic, silence, a detector that fails or hangs. Runs on any transport.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/sensor_msgs/camera_info.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/vision/picture/fault_log.hpp"
#include "musher/modules/vision/picture/lens.hpp"
#include "musher/modules/vision/picture/picture.hpp"
#include "musher/modules/vision/picture/picture_publishers.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::vision {

// What the topics of a detector need.
struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<std::int64_t()> stamp_ns;  // now, in the time of the pictures' stamps
  std::function<void(const Error&)> log;   // a fault; code 0: it is over
};

struct FeedRules {
  std::string picture;  // topics; relative ones are in the machine's namespace
  std::string camera_info;
  std::optional<double> hfov_rad;  // of the picture, where no CameraInfo comes
  bool needs_lens = true;          // a self-check without a lens fails
  double rate_hz = 0;              // pictures accepted in a second of their own time; 0: all
  Duration silence{};              // timeout without a processed picture
  Duration still{};                // old pictures for so long: the camera stands still; 0: off
  Duration hang{};                 // a picture that takes longer: the detector hangs
};

struct FeedEvents {
  std::function<void(Shot)> on_shot;  // an accepted picture, for the detector
  std::function<void()> on_jump;      // before a picture from before the last one: tracks are void
  std::function<void()> on_silence;   // no picture was processed for `silence`, and again
  std::function<Duration()> busy;     // how long the detector has been processing a picture
};

class PictureFeed {
 public:
  PictureFeed(const Dependencies& dependencies, FeedRules rules, FeedEvents events);

  // Subscribes to the pictures, or no longer. Fails when they cannot be subscribed to.
  Result<> SetOn(bool on);
  bool on() const { return camera_ != nullptr; }

  // The detector's result for the picture with that stamp. Returns whether the result counts: the
  // detector has not failed, and the result is from neither before a pause nor before a jump of
  // time.
  bool OnResult(std::int64_t stamp_ns, const Result<>& result);

  // From here on Check() needs another processed picture, and reports no fault of an earlier one.
  void ForgetSeen();
  // Whether a picture was processed since then and there is no fault. Fails with the reason.
  Result<> Check() const;

  // Of a picture of that size.
  std::optional<Lens> LensFor(std::uint32_t width_px, std::uint32_t height_px) const;
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  Result<> Subscribe();
  void Unsubscribe();
  void OnPicture(msg::Image picture);
  // Whether it is from one of several publishers, which is then a fault.
  bool HasSeveralPublishers(const transport::SampleInfo& info);
  std::string PublishersText() const;
  void OnInfo(const msg::CameraInfo& info);
  // Whether its pictures have been old ones for too long, which is then a fault.
  bool StandsStill(const msg::Image& picture, std::int64_t stamp_ns);
  void OnSilence();
  void AwaitNext();
  std::string Topic(const std::string& name) const {
    return transport::ResolveName(dependencies_.name_space, name);
  }

  const Dependencies dependencies_;
  const FeedRules rules_;
  const FeedEvents events_;
  const FaultLog faults_;
  StampGate gate_;
  StillPictures still_;
  PicturePublishers publishers_;
  std::optional<Lens> lens_;  // of the CameraInfo
  std::uint64_t looked_at_ = 0;
  bool seen_ = false;                            // a picture was processed since the subscription
  std::int64_t newest_ns_ = 0;                   // stamp of the last picture passed to the detector
  std::optional<std::int64_t> before_pause_ns_;  // the same, when the subscription began
  FaultLog::Fault picture_fault_;
  FaultLog::Fault still_fault_;
  FaultLog::Fault publishers_fault_;
  FaultLog::Fault info_fault_;
  FaultLog::Fault detector_fault_;
  FaultLog::Fault silence_;
  std::optional<Time> jump_logged_at_;
  std::optional<Time> requested_at_;  // when the detector got a picture, with no result since
  transport::LoopHandlePtr silence_timer_;
  // While it is on; last: their callbacks use the rest.
  std::unique_ptr<transport::Endpoints> camera_;
  std::unique_ptr<transport::Subscription> pictures_;
};

}  // namespace musher::vision
