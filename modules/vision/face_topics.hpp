#pragma once
// Faces on the network: subscribes to pictures while it is on, passes them to a looker, and
// publishes the results. Runs on any transport.
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
#include <optional>
#include <string>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/vision/face_watch.hpp"
#include "musher/modules/vision/looker.hpp"
#include "musher/modules/vision/picture.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::vision {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<std::int64_t()> stamp_ns;  // now, in the time of the pictures' stamps
  std::function<void(const Error&)> log;   // a fault; code 0: it is over
  Looker& looker;
};

class FaceTopics {
 public:
  static Result<std::unique_ptr<FaceTopics>> Make(const Dependencies& dependencies,
                                                  const VisionConfig& config);

  // Two reasons to be on: the robot is in a state in which it looks; a self-check runs, which
  // publishes nothing. Fails when the pictures cannot be subscribed to.
  Result<> SetOn(bool on);
  Result<> SetChecked(bool checked);

  // Whether a picture was processed since it was wanted and there is no fault. Fails with the
  // reason.
  Result<> Check() const;

  // Called by the looker.
  void OnResult(const LookResult& result);
  void OnLeftOut() { ++left_out_; }

  bool looks() const { return camera_ != nullptr; }
  std::uint64_t left_out() const { return left_out_; }  // dropped for a newer one
  std::uint64_t looked_at() const { return looked_at_; }

 private:
  // A fault that is logged once, and once when it is over; again only after a quiet minute.
  struct LoggedFault {
    std::optional<Error> error;
    bool logged = false;
    std::optional<Time> logged_at;
  };

  FaceTopics(const Dependencies& dependencies, VisionConfig config);
  Result<> Reconsider();
  Result<> Subscribe();
  void Unsubscribe();
  void OnPicture(msg::Image picture);
  void OnInfo(const msg::CameraInfo& info);
  void OnJump();
  void OnSilence();
  void AwaitNext();
  void NoteGap(Duration gap);
  void PublishSight(const Sight& sight);
  void PublishEmpty();
  std::optional<Lens> LensFor(const LookResult& result) const;
  void Set(LoggedFault& fault, const Result<>& result, const std::string& well) const;
  std::string PictureTopic() const {
    return transport::ResolveName(dependencies_.name_space, config_.picture);
  }

  const Dependencies dependencies_;
  const VisionConfig config_;
  bool on_ = false;
  bool checked_ = false;
  StampGate gate_;
  FaceWatch watch_;
  std::optional<Lens> lens_;  // of the CameraInfo
  std::uint64_t looked_at_ = 0;
  std::uint64_t left_out_ = 0;
  bool too_close_now_ = false;  // by the last picture that was processed
  bool seen_ = false;           // a picture was processed since the subscription
  std::int64_t newest_ns_ = 0;  // stamp of the last picture passed to the looker
  std::int64_t looked_ns_ = 0;  // stamp of the last picture that was processed
  LoggedFault picture_fault_;
  LoggedFault info_fault_;
  LoggedFault detector_fault_;
  LoggedFault rarity_;
  int rare_ = 0;  // pictures in a row that came long after the one before
  LoggedFault silence_;
  std::optional<Time> jump_logged_at_;
  std::optional<Time> requested_at_;  // when the looker got a picture, with no result since
  transport::Endpoints endpoints_;
  transport::Publisher<msg::PointStamped>* const target_;
  transport::Publisher<msg::Bool>* const too_close_;
  transport::Publisher<msg::String>* const faces_;
  transport::LoopHandlePtr silence_timer_;
  transport::Subscription* pictures_ = nullptr;   // of `camera_`
  std::unique_ptr<transport::Endpoints> camera_;  // while it looks
};

}  // namespace musher::vision
