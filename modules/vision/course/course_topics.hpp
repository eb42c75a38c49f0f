#pragma once
// One detector of a course on the network: subscribes to pictures while it is on and one of its
// outputs has a subscriber, passes the newest one to the detector, and publishes the results. Runs
// on any transport.
//
// Each time that it subscribes to pictures, and after a jump of time, the detector starts again: it
// remembers no earlier picture.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/vision/course/course_processor.hpp"
#include "musher/modules/vision/picture/detector_worker.hpp"
#include "musher/modules/vision/picture/picture_feed.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::vision {

class CourseTopics {
 public:
  // `silence`: timeout without a processed picture while an output has a subscriber.
  static Result<std::unique_ptr<CourseTopics>> Make(const Dependencies& dependencies,
                                                    DetectorWorker<CourseProcessor>& worker,
                                                    const CourseEntry& entry, Duration silence);

  // The present state runs a detector. Fails when the pictures cannot be subscribed to.
  Result<> SetOn(bool on);
  // A self-check runs, which needs no subscriber and publishes nothing.
  Result<> SetChecked(bool checked);

  // Whether a picture was processed since it was wanted and there is no fault. Fails with the
  // reason.
  Result<> Check() const { return feed_.Check(); }

  // Called by the worker.
  void OnResult(const DetectionResult<CourseProcessor>& result);
  void OnLeftOut() { ++left_out_; }

  bool looks() const { return feed_.on(); }
  std::uint64_t left_out() const { return left_out_; }  // dropped for a newer one
  std::uint64_t looked_at() const { return feed_.looked_at(); }

 private:
  CourseTopics(const Dependencies& dependencies, DetectorWorker<CourseProcessor>& worker,
               const CourseEntry& entry, Duration silence);
  bool IsSubscribed() const;
  bool Draws() const { return drawings_->MatchedReaders() > 0; }
  Result<> Reconsider();
  void ReconsiderSoon();
  void OnShot(Shot shot);

  transport::EventLoop& loop_;
  const std::function<void(const Error&)> log_;
  DetectorWorker<CourseProcessor>& worker_;
  bool on_ = false;
  bool checked_ = false;
  std::uint32_t run_ = 0;  // of the subscriptions to pictures, and of the jumps of time
  std::uint64_t left_out_ = 0;
  transport::LoopHandlePtr again_;
  transport::Endpoints endpoints_;
  // Null: this kind of detector does not publish it.
  transport::Publisher<msg::String>* texts_ = nullptr;
  transport::Publisher<msg::Sighting>* sightings_ = nullptr;
  transport::Publisher<msg::String>* doubts_ = nullptr;
  transport::Publisher<msg::YellowLines>* lines_ = nullptr;
  transport::Publisher<msg::Image>* drawings_ = nullptr;
  PictureFeed feed_;
};

}  // namespace musher::vision
