#include "musher/modules/vision/face_topics.hpp"

#include <chrono>
#include <utility>

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

FaceTopics::FaceTopics(const Dependencies& around, VisionConfig config)
    : around_(around), config_(std::move(config)), gate_(config_.rate_hz), watch_(config_.faces) {}

Result<std::unique_ptr<FaceTopics>> FaceTopics::Make(const Dependencies& around,
                                                     const VisionConfig& config) {
  std::unique_ptr<FaceTopics> topics(new FaceTopics(around, config));
  if (Result<> made = topics->MakePublishers(); !made) return made.error();
  return topics;
}

Result<> FaceTopics::MakePublishers() {
  const std::string under = transport::ResolveName(around_.name_space, config_.publish_under);
  auto target = transport::MakePublisher<msg::PointStamped>(around_.node, under + "/target");
  if (!target) return target.error();
  target_ = std::move(target).value();
  auto too_close = transport::MakePublisher<msg::Bool>(around_.node, under + "/too_close");
  if (!too_close) return too_close.error();
  too_close_ = std::move(too_close).value();
  auto faces =
      transport::MakePublisher<msg::String>(around_.node, under + "/faces_json", kNewestQos);
  if (!faces) return faces.error();
  faces_ = std::move(faces).value();
  return Ok();
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
  if (wanted) return Hear();
  Leave();
  return Ok();
}

Result<> FaceTopics::Hear() {
  auto infos = transport::MakeSubscription<msg::CameraInfo>(
      around_.node, transport::ResolveName(around_.name_space, config_.CameraInfoTopic()),
      [this](const msg::CameraInfo& info, const auto&) { OnInfo(info); },
      transport::kSensorDataQos);
  if (!infos) return infos.error();
  auto pictures = transport::MakeSubscription<msg::Image>(
      around_.node, PictureTopic(),
      [this](msg::Image&& picture, const auto&) { OnPicture(std::move(picture)); }, kNewestQos);
  if (!pictures) return pictures.error();
  infos_ = std::move(infos).value();
  pictures_ = std::move(pictures).value();
  seen_ = false;
  AwaitNext();
  return Ok();
}

// Who was remembered still is when it looks again, if not too much time has passed by then.
void FaceTopics::Leave() {
  silence_timer_.reset();
  pictures_.reset();
  infos_.reset();
  silence_ = {};
  asked_.reset();
  TellNobody();
}

void FaceTopics::OnInfo(const msg::CameraInfo& info) {
  Result<Lens> lens = LensOf(info);
  Set(info_trouble_, lens ? Result<>() : lens.error(), "CameraInfo is well again");
  if (lens) lens_ = lens.value();
}

void FaceTopics::OnPicture(msg::Image picture) {
  const Result<> judged = CheckPicture(picture);
  Set(picture_trouble_, judged, "pictures are well again");
  if (!judged) return;
  const msg::Stamp& stamp = picture.header.stamp;
  const std::int64_t at_ns = stamp.sec * std::int64_t{1'000'000'000} + stamp.nanosec;
  const std::int64_t stamp_ns = at_ns == 0 ? around_.stamp_ns() : at_ns;
  switch (gate_.Judge(stamp_ns)) {
    case StampGate::Verdict::kNotNewer:
    case StampGate::Verdict::kTooSoon:
      return;
    case StampGate::Verdict::kLookAnew:
      OnJump();
      break;
    case StampGate::Verdict::kLook:
      break;
  }
  newest_ns_ = stamp_ns;
  if (!asked_) asked_ = around_.clock.Now();
  around_.looker.Look(stamp_ns, std::move(picture));
}

void FaceTopics::OnJump() {
  watch_ = FaceWatch(config_.faces);
  too_close_now_ = false;
  // Two cameras on one topic would say it with each picture.
  const Time now = around_.node.loop().Now();
  if (jump_told_ && now < *jump_told_ + kQuiet) return;
  jump_told_ = now;
  around_.log({kCodeOk,
               "time has jumped back: all faces are new. A world that was started again, or "
               "two cameras on " +
                   PictureTopic()});
}

void FaceTopics::OnResult(const LookResult& result) {
  asked_.reset();
  if (result.stamp_ns != newest_ns_) asked_ = around_.clock.Now();
  // One of before a pause, or of a time that is over.
  if (!looks() || result.stamp_ns > newest_ns_) return;
  Set(detector_trouble_, result.faces ? Result<>() : result.faces.error(),
      "the detector is well again");
  if (!result.faces) return;
  ++looked_at_;
  seen_ = true;
  NoteGap(Duration(result.stamp_ns - std::exchange(looked_ns_, result.stamp_ns)));
  Set(silence_, Ok(), "pictures come again");
  AwaitNext();
  const Sight sight = watch_.OnPicture(result.stamp_ns, result.faces.value(), LensFor(result));
  if (on_) Tell(sight);
}

std::optional<Lens> FaceTopics::LensFor(const LookResult& result) const {
  if (lens_) return lens_;
  if (!config_.hfov_rad) return std::nullopt;
  return PinholeOf(*config_.hfov_rad, result.width_px, result.height_px);
}

void FaceTopics::AwaitNext() {
  silence_timer_ = around_.clock.At(around_.clock.Now() + config_.silence, [this] { OnSilence(); });
}

// A single long gap is no more than that.
void FaceTopics::NoteGap(Duration gap) {
  const Duration longest = config_.faces.tracker.confirm_within;
  rare_ = gap > longest ? rare_ + 1 : 0;
  if (rare_ == 0) return Set(rarity_, Ok(), "pictures are looked at often enough again");
  if (rare_ < kRareInARow) return;
  Set(rarity_,
      Wrong(KeyCode::kTimeout, "pictures are looked at " + Ms(gap) +
                                   " apart, more than [faces] confirm_within_ms (" + Ms(longest) +
                                   "): faces are told late"),
      "");
}

void FaceTopics::OnSilence() {
  // By the same clock as the silence: time in a world may pass faster than the detector's.
  const bool hangs = asked_ && around_.clock.Now() - *asked_ >= config_.silence / 2;
  const std::string why = hangs ? "the detector has been at one for " + Ms(around_.looker.Busy())
                          : pictures_->MatchedWriters() == 0
                              ? "nobody publishes " + PictureTopic()
                              : "none that can be looked at comes on " + PictureTopic();
  Set(silence_, Wrong(KeyCode::kTimeout, "no picture for " + Ms(config_.silence) + ": " + why), "");
  AwaitNext();
  if (!on_) return;
  TellNobody();
  if (too_close_now_) static_cast<void>(too_close_->Publish({true}));
}

void FaceTopics::Tell(const Sight& sight) {
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

void FaceTopics::TellNobody() {
  Sight nobody;
  nobody.stamp_ns = around_.stamp_ns();
  static_cast<void>(faces_->Publish({FacesJson(nobody)}));
}

Result<> FaceTopics::Check() const {
  constexpr auto kFailed = KeyCode::kSelfCheckFailed;
  const Duration busy = around_.looker.Busy();
  if (busy > config_.look.hang) {
    return Wrong(kFailed, "the detector hangs: it has been at one picture for " + Ms(busy));
  }
  if (detector_trouble_.error) return Wrong(kFailed, detector_trouble_.error->message);
  if (!seen_) {
    if (picture_trouble_.error) return Wrong(kFailed, picture_trouble_.error->message);
    const bool published = pictures_ && pictures_->MatchedWriters() > 0;
    return Wrong(kFailed, published ? "no picture came on " + PictureTopic()
                                    : "nobody publishes " + PictureTopic());
  }
  if (!lens_ && !config_.hfov_rad) {
    return Wrong(kFailed,
                 info_trouble_.error
                     ? info_trouble_.error->message
                     : "no CameraInfo came on " +
                           transport::ResolveName(around_.name_space, config_.CameraInfoTopic()) +
                           ", and the config has no hfov_deg: distances are not known");
  }
  return Ok();
}

void FaceTopics::Set(Trouble& trouble, const Result<>& result, const std::string& well) const {
  trouble.error = result ? std::nullopt : std::optional(result.error());
  if (result.ok() != trouble.told) return;
  const Time now = around_.node.loop().Now();
  if (!result && trouble.told_at && now < *trouble.told_at + kQuiet) return;
  trouble.told = !result;
  if (!result) trouble.told_at = now;
  around_.log(result ? Error{kCodeOk, well} : result.error());
}

}  // namespace musher::vision
