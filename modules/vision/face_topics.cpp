#include "musher/modules/vision/face_topics.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/faces/faces_json.hpp"
#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {
namespace {

constexpr transport::Qos kNewestQos{transport::Qos::Reliability::kBestEffort,
                                    transport::Qos::Durability::kVolatile, 1};
constexpr int kRareInARow = 5;

std::string Ms(Duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) +
         " ms";
}

FeedRules FeedRulesOf(const VisionConfig& config) {
  return {.picture = config.picture,
          .camera_info = config.CameraInfoTopic(),
          .hfov_rad = config.hfov_rad,
          .needs_lens = true,
          .rate_hz = config.rate_hz,
          .silence = config.silence,
          .still = config.still,
          .hang = config.limits.hang};
}

}  // namespace

FaceTopics::FaceTopics(const Dependencies& dependencies, DetectorWorker<Detector>& worker,
                       VisionConfig config)
    : stamp_ns_(dependencies.stamp_ns),
      config_(std::move(config)),
      faults_(dependencies.node.loop(), dependencies.log),
      watch_(config_.faces),
      endpoints_(dependencies.node, dependencies.name_space),
      target_(endpoints_.Advertise<msg::PointStamped>(config_.publish_under + "/target")),
      too_close_(endpoints_.Advertise<msg::Bool>(config_.publish_under + "/too_close")),
      faces_(endpoints_.Advertise<msg::String>(config_.publish_under + "/faces_json", kNewestQos)),
      feed_(dependencies, FeedRulesOf(config_),
            {.on_shot = [&worker](Shot shot) { worker.Submit(std::move(shot)); },
             .on_jump = [this] { OnJump(); },
             .on_silence = [this] { OnSilence(); },
             .busy = [&worker] { return worker.Busy(); }}) {}

Result<std::unique_ptr<FaceTopics>> FaceTopics::Make(const Dependencies& dependencies,
                                                     DetectorWorker<Detector>& worker,
                                                     const VisionConfig& config) {
  std::unique_ptr<FaceTopics> topics(new FaceTopics(dependencies, worker, config));
  if (!topics->endpoints_.opened()) return topics->endpoints_.opened().error();
  return topics;
}

Result<> FaceTopics::SetOn(bool on) {
  on_ = on;
  return Reconsider();
}

Result<> FaceTopics::SetChecked(bool checked) {
  checked_ = checked;
  if (checked) feed_.ForgetSeen();
  return Reconsider();
}

// Tracks are kept for when it is on again, if not too much time has passed by then.
Result<> FaceTopics::Reconsider() {
  const bool looked = looks();
  Result<> switched = feed_.SetOn(on_ || checked_);
  if (looked && !looks()) PublishEmpty();
  return switched;
}

void FaceTopics::OnJump() {
  watch_ = FaceWatch(config_.faces);
  too_close_now_ = false;
}

void FaceTopics::OnResult(const DetectionResult<Detector>& result) {
  if (!feed_.OnResult(result.stamp_ns, result.found ? Result<>() : result.found.error())) return;
  NoteGap(Duration(result.stamp_ns - std::exchange(looked_ns_, result.stamp_ns)));
  const Sight sight = watch_.OnPicture(result.stamp_ns, result.found.value(),
                                       feed_.LensFor(result.width_px, result.height_px));
  if (on_) PublishSight(sight);
}

// A single long gap does not count.
void FaceTopics::NoteGap(Duration gap) {
  const Duration longest = config_.faces.tracker.confirm_within;
  rare_ = gap > longest ? rare_ + 1 : 0;
  if (rare_ == 0) return faults_.Set(rarity_, Ok(), "pictures are processed often enough again");
  if (rare_ < kRareInARow) return;
  faults_.Set(
      rarity_,
      Error{VisionCode(KeyCode::kTimeout), "pictures are processed " + Ms(gap) +
                                               " apart, more than [faces] confirm_within_ms (" +
                                               Ms(longest) + "): faces are published late"},
      "");
}

void FaceTopics::OnSilence() {
  if (!on_) return;
  PublishEmpty();
  if (too_close_now_) static_cast<void>(too_close_->Publish({true}));
}

void FaceTopics::PublishSight(const Sight& sight) {
  if (sight.target) {
    msg::PointStamped target;
    target.header = {msg::ToStamp(std::chrono::nanoseconds(sight.stamp_ns)), config_.frame_id};
    target.point = {sight.target->box.center_x(), sight.target->box.center_y(),
                    sight.target->distance_m.value_or(0)};
    static_cast<void>(target_->Publish(target));
  }
  if (sight.too_close) {
    too_close_now_ = *sight.too_close;
    static_cast<void>(too_close_->Publish({too_close_now_}));
  }
  static_cast<void>(faces_->Publish({FacesJson(sight)}));
}

void FaceTopics::PublishEmpty() {
  Sight empty;
  empty.stamp_ns = stamp_ns_();
  static_cast<void>(faces_->Publish({FacesJson(empty)}));
}

}  // namespace musher::vision
