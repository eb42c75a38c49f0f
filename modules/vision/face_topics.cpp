#include "musher/modules/vision/face_topics.hpp"

#include <chrono>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/faces_json.hpp"

namespace musher::vision {
namespace {

constexpr transport::Qos kNewestQos{transport::Qos::Reliability::kBestEffort,
                                    transport::Qos::Durability::kVolatile, 1};

Error Wrong(KeyCode key, const std::string& what) {
  return {MakeCode(ModuleCode::kFace, key), what};
}

constexpr int kRareInARow = 5;
constexpr Duration kQuiet = std::chrono::minutes(1);  // in the log

std::string Ms(Duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) +
         " ms";
}

}  // namespace

FaceTopics::FaceTopics(const Dependencies& dependencies, VisionConfig config)
    : dependencies_(dependencies),
      config_(std::move(config)),
      gate_(config_.rate_hz),
      watch_(config_.faces),
      endpoints_(dependencies.node, dependencies.name_space),
      target_(endpoints_.Advertise<msg::PointStamped>(config_.publish_under + "/target")),
      too_close_(endpoints_.Advertise<msg::Bool>(config_.publish_under + "/too_close")),
      faces_(endpoints_.Advertise<msg::String>(config_.publish_under + "/faces_json", kNewestQos)) {
}

Result<std::unique_ptr<FaceTopics>> FaceTopics::Make(const Dependencies& dependencies,
                                                     const VisionConfig& config) {
  std::unique_ptr<FaceTopics> topics(new FaceTopics(dependencies, config));
  if (!topics->endpoints_.opened()) return topics->endpoints_.opened().error();
  return topics;
}

Result<> FaceTopics::SetOn(bool on) {
  on_ = on;
  return Reconsider();
}

Result<> FaceTopics::SetChecked(bool checked) {
  checked_ = checked;
  if (checked) seen_ = false;
  return Reconsider();
}

Result<> FaceTopics::Reconsider() {
  const bool wanted = on_ || checked_;
  if (wanted == looks()) return Ok();
  if (wanted) return Subscribe();
  Unsubscribe();
  return Ok();
}

Result<> FaceTopics::Subscribe() {
  auto camera =
      std::make_unique<transport::Endpoints>(dependencies_.node, dependencies_.name_space);
  camera->Subscribe<msg::CameraInfo>(
      config_.CameraInfoTopic(), [this](const msg::CameraInfo& info) { OnInfo(info); },
      transport::kSensorDataQos);
  auto* pictures = camera->Subscribe<msg::Image>(
      config_.picture, [this](msg::Image&& picture) { OnPicture(std::move(picture)); }, kNewestQos);
  if (!camera->opened()) return camera->opened();
  camera_ = std::move(camera);
  pictures_ = pictures;
  seen_ = false;
  AwaitNext();
  return Ok();
}

// Tracks are kept for when it is on again, if not too much time has passed by then.
void FaceTopics::Unsubscribe() {
  silence_timer_.reset();
  pictures_ = nullptr;
  camera_.reset();
  silence_ = {};
  requested_at_.reset();
  PublishEmpty();
}

void FaceTopics::OnInfo(const msg::CameraInfo& info) {
  Result<Lens> lens = LensOf(info);
  Set(info_fault_, lens ? Result<>() : lens.error(), "CameraInfo is ok again");
  if (lens) lens_ = lens.value();
}

void FaceTopics::OnPicture(msg::Image picture) {
  const Result<> valid = CheckPicture(picture);
  Set(picture_fault_, valid, "pictures are ok again");
  if (!valid) return;
  const msg::Stamp& stamp = picture.header.stamp;
  const std::int64_t at_ns = stamp.sec * std::int64_t{1'000'000'000} + stamp.nanosec;
  const std::int64_t stamp_ns = at_ns == 0 ? dependencies_.stamp_ns() : at_ns;
  switch (gate_.Check(stamp_ns)) {
    case StampGate::Verdict::kNotNewer:
    case StampGate::Verdict::kTooSoon:
      return;
    case StampGate::Verdict::kLookAfterJump:
      OnJump();
      break;
    case StampGate::Verdict::kLook:
      break;
  }
  newest_ns_ = stamp_ns;
  if (!requested_at_) requested_at_ = dependencies_.clock.Now();
  dependencies_.looker.Look(stamp_ns, std::move(picture));
}

void FaceTopics::OnJump() {
  watch_ = FaceWatch(config_.faces);
  too_close_now_ = false;
  // Two cameras on one topic would log it with each picture.
  const Time now = dependencies_.node.loop().Now();
  if (jump_logged_at_ && now < *jump_logged_at_ + kQuiet) return;
  jump_logged_at_ = now;
  dependencies_.log({kCodeOk,
                     "time jumped back: all tracks are dropped. The world was restarted, or "
                     "two cameras on " +
                         PictureTopic()});
}

void FaceTopics::OnResult(const LookResult& result) {
  requested_at_.reset();
  if (result.stamp_ns != newest_ns_) requested_at_ = dependencies_.clock.Now();
  // A result from before a pause, or from before a jump of time.
  if (!looks() || result.stamp_ns > newest_ns_) return;
  Set(detector_fault_, result.faces ? Result<>() : result.faces.error(),
      "the detector is ok again");
  if (!result.faces) return;
  ++looked_at_;
  seen_ = true;
  NoteGap(Duration(result.stamp_ns - std::exchange(looked_ns_, result.stamp_ns)));
  Set(silence_, Ok(), "receiving pictures again");
  AwaitNext();
  const Sight sight = watch_.OnPicture(result.stamp_ns, result.faces.value(), LensFor(result));
  if (on_) PublishSight(sight);
}

std::optional<Lens> FaceTopics::LensFor(const LookResult& result) const {
  if (lens_) return lens_;
  if (!config_.hfov_rad) return std::nullopt;
  return PinholeOf(*config_.hfov_rad, result.width_px, result.height_px);
}

void FaceTopics::AwaitNext() {
  silence_timer_ =
      dependencies_.clock.At(dependencies_.clock.Now() + config_.silence, [this] { OnSilence(); });
}

// A single long gap does not count.
void FaceTopics::NoteGap(Duration gap) {
  const Duration longest = config_.faces.tracker.confirm_within;
  rare_ = gap > longest ? rare_ + 1 : 0;
  if (rare_ == 0) return Set(rarity_, Ok(), "pictures are processed often enough again");
  if (rare_ < kRareInARow) return;
  Set(rarity_,
      Wrong(KeyCode::kTimeout, "pictures are processed " + Ms(gap) +
                                   " apart, more than [faces] confirm_within_ms (" + Ms(longest) +
                                   "): faces are published late"),
      "");
}

void FaceTopics::OnSilence() {
  // By the same clock as the silence: the world's time may run faster than the detector's.
  const bool hangs =
      requested_at_ && dependencies_.clock.Now() - *requested_at_ >= config_.silence / 2;
  const std::string why =
      hangs ? "the detector has been processing one for " + Ms(dependencies_.looker.Busy())
      : pictures_->MatchedWriters() == 0 ? "no publisher of " + PictureTopic()
                                         : "no usable picture on " + PictureTopic();
  Set(silence_, Wrong(KeyCode::kTimeout, "no picture for " + Ms(config_.silence) + ": " + why), "");
  AwaitNext();
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
  empty.stamp_ns = dependencies_.stamp_ns();
  static_cast<void>(faces_->Publish({FacesJson(empty)}));
}

Result<> FaceTopics::Check() const {
  constexpr auto kFailed = KeyCode::kSelfCheckFailed;
  const Duration busy = dependencies_.looker.Busy();
  if (busy > config_.look.hang) {
    return Wrong(kFailed, "the detector hangs: it has been processing one picture for " + Ms(busy));
  }
  if (detector_fault_.error) return Wrong(kFailed, detector_fault_.error->message);
  if (!seen_) {
    if (picture_fault_.error) return Wrong(kFailed, picture_fault_.error->message);
    const bool published = looks() && pictures_->MatchedWriters() > 0;
    return Wrong(kFailed, published ? "no picture came on " + PictureTopic()
                                    : "no publisher of " + PictureTopic());
  }
  if (!lens_ && !config_.hfov_rad) {
    return Wrong(kFailed, info_fault_.error
                              ? info_fault_.error->message
                              : "no CameraInfo came on " +
                                    transport::ResolveName(dependencies_.name_space,
                                                           config_.CameraInfoTopic()) +
                                    ", and the config has no hfov_deg: distances are not known");
  }
  return Ok();
}

void FaceTopics::Set(LoggedFault& fault, const Result<>& result, const std::string& well) const {
  fault.error = result ? std::nullopt : std::optional(result.error());
  if (result.ok() != fault.logged) return;
  const Time now = dependencies_.node.loop().Now();
  if (!result && fault.logged_at && now < *fault.logged_at + kQuiet) return;
  fault.logged = !result;
  if (!result) fault.logged_at = now;
  dependencies_.log(result ? Error{kCodeOk, well} : result.error());
}

}  // namespace musher::vision
