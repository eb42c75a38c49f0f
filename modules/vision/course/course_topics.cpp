#include "musher/modules/vision/course/course_topics.hpp"

#include <string>
#include <utility>

namespace musher::vision {
namespace {

constexpr transport::Qos kDrawingQos{transport::Qos::Reliability::kBestEffort,
                                     transport::Qos::Durability::kVolatile, 1};

FeedRules FeedRulesOf(const CourseEntry& entry, Duration silence) {
  return {.picture = entry.picture,
          .camera_info = entry.CameraInfoTopic(),
          .hfov_rad = entry.hfov_rad,
          .needs_lens = false,
          .rate_hz = entry.rate_hz,
          .silence = silence,
          .still = entry.still,
          .hang = entry.limits.hang};
}

}  // namespace

CourseTopics::CourseTopics(const Dependencies& dependencies,
                           DetectorWorker<CourseProcessor>& worker, const CourseEntry& entry,
                           Duration silence)
    : loop_(dependencies.node.loop()),
      log_(dependencies.log),
      worker_(worker),
      endpoints_(dependencies.node, dependencies.name_space),
      feed_(dependencies, FeedRulesOf(entry, silence),
            {.on_shot = [this](Shot shot) { OnShot(std::move(shot)); },
             .on_jump = [this] { ++run_; },
             .on_silence = [] {},
             .busy = [&worker] { return worker.Busy(); }}) {
  const transport::WriterCallbacks matched = {.on_match_changed = [this] { ReconsiderSoon(); }};
  const CourseOutputs topics = entry.Outputs();
  if (topics.lines) {
    lines_ = endpoints_.Advertise<msg::YellowLines>(*topics.lines, transport::kDefaultQos, matched);
  }
  if (topics.text) {
    texts_ = endpoints_.Advertise<msg::String>(*topics.text, transport::kDefaultQos, matched);
  }
  if (topics.sighting) {
    sightings_ =
        endpoints_.Advertise<msg::Sighting>(*topics.sighting, transport::kDefaultQos, matched);
  }
  if (topics.doubt) doubts_ = endpoints_.Advertise<msg::String>(*topics.doubt);
  drawings_ = endpoints_.Advertise<msg::Image>(topics.debug_image, kDrawingQos, matched);
}

Result<std::unique_ptr<CourseTopics>> CourseTopics::Make(const Dependencies& dependencies,
                                                         DetectorWorker<CourseProcessor>& worker,
                                                         const CourseEntry& entry,
                                                         Duration silence) {
  std::unique_ptr<CourseTopics> topics(new CourseTopics(dependencies, worker, entry, silence));
  if (!topics->endpoints_.opened()) return topics->endpoints_.opened().error();
  return topics;
}

Result<> CourseTopics::SetOn(bool on) {
  on_ = on;
  return Reconsider();
}

Result<> CourseTopics::SetChecked(bool checked) {
  checked_ = checked;
  if (checked) feed_.ForgetSeen();
  return Reconsider();
}

bool CourseTopics::IsSubscribed() const {
  return (texts_ != nullptr && texts_->MatchedReaders() > 0) ||
         (sightings_ != nullptr && sightings_->MatchedReaders() > 0) ||
         (lines_ != nullptr && lines_->MatchedReaders() > 0) || Draws();
}

Result<> CourseTopics::Reconsider() {
  const bool wanted = checked_ || (on_ && IsSubscribed());
  if (wanted && !looks()) ++run_;
  return feed_.SetOn(wanted);
}

// Not within the callback of an endpoint: it may run before all publishers exist.
void CourseTopics::ReconsiderSoon() {
  again_ = loop_.At(loop_.Now(), [this] {
    if (const Result<> switched = Reconsider(); !switched) log_(switched.error());
  });
}

void CourseTopics::OnShot(Shot shot) {
  CourseShot course;
  course.lens = feed_.LensFor(shot.picture.width, shot.picture.height);
  course.draws = on_ && Draws();
  course.run = run_;
  static_cast<Shot&>(course) = std::move(shot);
  worker_.Submit(std::move(course));
}

void CourseTopics::OnResult(const DetectionResult<CourseProcessor>& result) {
  if (!feed_.OnResult(result.stamp_ns, result.found ? Result<>() : result.found.error())) return;
  const CourseFound& found = result.found.value();
  if (!on_ || found.run != run_) return;
  // A failure to publish is ignored: the next picture follows.
  if (found.sight.text && texts_ != nullptr) {
    static_cast<void>(texts_->Publish({*found.sight.text}));
  }
  if (found.sight.sighting && sightings_ != nullptr) {
    static_cast<void>(sightings_->Publish(*found.sight.sighting));
  }
  if (!found.sight.doubt.empty() && doubts_ != nullptr) {
    static_cast<void>(doubts_->Publish({found.sight.doubt}));
  }
  if (found.sight.lines && lines_ != nullptr) {
    static_cast<void>(lines_->Publish(*found.sight.lines));
  }
  if (found.drawing) static_cast<void>(drawings_->Publish(*found.drawing));
}

}  // namespace musher::vision
