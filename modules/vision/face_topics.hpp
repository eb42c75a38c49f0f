#pragma once
// Faces on the network: subscribes to pictures while it is on, passes them to a detector worker,
// and publishes the results. Runs on any transport.
//
// target and too_close are published with a picture that shows them: subscribers go by their
// age. After a start too_close is not published until a face was seen or pictures were checked for
// `hold`: a person who fills the picture is not detected, and may have been too close before.
// While it is on and no picture arrives, faces_json repeats an empty list, and too_close repeats
// true if it was true: no person has been seen to leave.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/faces/face_watch.hpp"
#include "musher/modules/vision/picture/detector_worker.hpp"
#include "musher/modules/vision/picture/fault_log.hpp"
#include "musher/modules/vision/picture/picture_feed.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::vision {

class FaceTopics {
 public:
  static Result<std::unique_ptr<FaceTopics>> Make(const Dependencies& dependencies,
                                                  DetectorWorker<Detector>& worker,
                                                  const VisionConfig& config);

  // Two reasons to be on: the present state runs a detector; a self-check runs, which
  // publishes nothing. Fails when the pictures cannot be subscribed to.
  Result<> SetOn(bool on);
  Result<> SetChecked(bool checked);

  // Whether a picture was processed since it was wanted and there is no fault. Fails with the
  // reason.
  Result<> Check() const { return feed_.Check(); }

  // Called by the worker.
  void OnResult(const DetectionResult<Detector>& result);
  void OnLeftOut() { ++left_out_; }

  bool looks() const { return feed_.on(); }
  std::uint64_t left_out() const { return left_out_; }  // dropped for a newer one
  std::uint64_t looked_at() const { return feed_.looked_at(); }

 private:
  FaceTopics(const Dependencies& dependencies, DetectorWorker<Detector>& worker,
             VisionConfig config);
  Result<> Reconsider();
  void OnJump();
  void OnSilence();
  void NoteGap(Duration gap);
  void PublishSight(const Sight& sight);
  void PublishEmpty();

  const std::function<std::int64_t()> stamp_ns_;
  const VisionConfig config_;
  const FaultLog faults_;
  bool on_ = false;
  bool checked_ = false;
  FaceWatch watch_;
  std::uint64_t left_out_ = 0;
  bool too_close_now_ = false;  // by the last picture that was processed
  std::int64_t looked_ns_ = 0;  // stamp of the last picture that was processed
  FaultLog::Fault rarity_;
  int rare_ = 0;  // pictures in a row that came long after the one before
  transport::Endpoints endpoints_;
  transport::Publisher<msg::PointStamped>* const target_;
  transport::Publisher<msg::Bool>* const too_close_;
  transport::Publisher<msg::String>* const faces_;
  PictureFeed feed_;
};

}  // namespace musher::vision
