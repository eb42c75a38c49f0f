#include "musher/modules/vision/picture/picture_feed.hpp"

#include <chrono>
#include <utility>

#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {
namespace {

constexpr transport::Qos kNewestPictureQos{transport::Qos::Reliability::kBestEffort,
                                           transport::Qos::Durability::kVolatile, 1};

Error FeedFault(KeyCode key, const std::string& what) {
  return {VisionCode(key), what};
}

std::string MsText(Duration time) {
  return std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(time).count()) +
         " ms";
}

}  // namespace

PictureFeed::PictureFeed(const Dependencies& dependencies, FeedRules rules, FeedEvents events)
    : dependencies_(dependencies),
      rules_(std::move(rules)),
      events_(std::move(events)),
      faults_(dependencies.node.loop(), dependencies.log),
      gate_(rules_.rate_hz) {}

Result<> PictureFeed::SetOn(bool on) {
  if (on == this->on()) return Ok();
  if (on) return Subscribe();
  Unsubscribe();
  return Ok();
}

Result<> PictureFeed::Subscribe() {
  auto camera =
      std::make_unique<transport::Endpoints>(dependencies_.node, dependencies_.name_space);
  camera->Subscribe<msg::CameraInfo>(
      rules_.camera_info, [this](const msg::CameraInfo& info) { OnInfo(info); },
      transport::kSensorDataQos);
  if (!camera->opened()) return camera->opened();
  auto pictures = transport::MakeSubscription<msg::Image>(
      dependencies_.node, Topic(rules_.picture),
      [this](msg::Image&& picture, const transport::SampleInfo& info) {
        if (!HasSeveralPublishers(info)) OnPicture(std::move(picture));
      },
      kNewestPictureQos);
  if (!pictures) return pictures.error();
  camera_ = std::move(camera);
  pictures_ = std::move(pictures).value();
  publishers_ = {};
  before_pause_ns_ = newest_ns_;
  ForgetSeen();
  AwaitNext();
  return Ok();
}

void PictureFeed::Unsubscribe() {
  silence_timer_.reset();
  pictures_.reset();
  camera_.reset();
  silence_ = {};
  requested_at_.reset();
}

void PictureFeed::ForgetSeen() {
  seen_ = false;
  for (FaultLog::Fault* fault :
       {&picture_fault_, &still_fault_, &publishers_fault_, &info_fault_, &detector_fault_}) {
    fault->error.reset();
  }
}

void PictureFeed::OnInfo(const msg::CameraInfo& info) {
  Result<Lens> lens = LensOf(info);
  faults_.Set(info_fault_, lens ? Result<>() : lens.error(), "CameraInfo is ok again");
  if (lens) lens_ = lens.value();
}

void PictureFeed::OnPicture(msg::Image picture) {
  const Result<> valid = CheckPicture(picture);
  faults_.Set(picture_fault_, valid, "pictures are ok again");
  if (!valid) return;
  const msg::Stamp& stamp = picture.header.stamp;
  const std::int64_t at_ns = stamp.sec * std::int64_t{1'000'000'000} + stamp.nanosec;
  const std::int64_t stamp_ns = at_ns == 0 ? dependencies_.stamp_ns() : at_ns;
  switch (gate_.Check(stamp_ns)) {
    case StampGate::Verdict::kNotNewer:
    case StampGate::Verdict::kTooSoon:
      return;
    case StampGate::Verdict::kLookAfterJump:
      before_pause_ns_.reset();
      events_.on_jump();
      faults_.Note(jump_logged_at_,
                   "time jumped back: all tracks are dropped. The world was restarted, or two "
                   "cameras on " +
                       Topic(rules_.picture));
      break;
    case StampGate::Verdict::kLook:
      break;
  }
  if (StandsStill(picture, stamp_ns)) return;
  newest_ns_ = stamp_ns;
  if (!requested_at_) requested_at_ = dependencies_.clock.Now();
  events_.on_shot({stamp_ns, std::move(picture)});
}

bool PictureFeed::HasSeveralPublishers(const transport::SampleInfo& info) {
  const Time now = dependencies_.node.loop().Now();
  publishers_.Add(info.writer, info.participant, now);
  const bool several = publishers_.AreSeveral(now);
  if (several && publishers_fault_.error) return true;  // to name them is slow
  faults_.Set(publishers_fault_,
              several ? Result<>(FeedFault(KeyCode::kParametersInvalid, PublishersText())) : Ok(),
              "one publisher of " + Topic(rules_.picture) + " again");
  return several;
}

std::string PictureFeed::PublishersText() const {
  std::string names;
  for (const transport::ParticipantId participant : publishers_.Participants()) {
    const std::string name = transport::NameOf(dependencies_.node, participant);
    if (!name.empty()) names += (names.empty() ? ": " : ", ") + name;
  }
  return "several publishers of " + Topic(rules_.picture) + names;
}

bool PictureFeed::StandsStill(const msg::Image& picture, std::int64_t stamp_ns) {
  if (rules_.still == Duration(0)) return false;
  const bool is_still = still_.StillFor(picture, stamp_ns) >= rules_.still;
  faults_.Set(still_fault_,
              is_still
                  ? Result<>(FeedFault(KeyCode::kTimeout,
                                       "the picture stands still: only old ones for " +
                                           MsText(rules_.still) + " on " + Topic(rules_.picture)))
                  : Ok(),
              "the picture changes again");
  return is_still;
}

bool PictureFeed::OnResult(std::int64_t stamp_ns, const Result<>& result) {
  requested_at_.reset();
  if (stamp_ns != newest_ns_) requested_at_ = dependencies_.clock.Now();
  if (!on() || stamp_ns > newest_ns_) return false;
  if (before_pause_ns_ && stamp_ns <= *before_pause_ns_) return false;
  faults_.Set(detector_fault_, result, "the detector is ok again");
  if (!result) return false;
  ++looked_at_;
  seen_ = true;
  faults_.Set(silence_, Ok(), "receiving pictures again");
  AwaitNext();
  return true;
}

std::optional<Lens> PictureFeed::LensFor(std::uint32_t width_px, std::uint32_t height_px) const {
  if (lens_) return lens_;
  if (!rules_.hfov_rad) return std::nullopt;
  return PinholeOf(*rules_.hfov_rad, width_px, height_px);
}

void PictureFeed::AwaitNext() {
  silence_timer_ =
      dependencies_.clock.At(dependencies_.clock.Now() + rules_.silence, [this] { OnSilence(); });
}

void PictureFeed::OnSilence() {
  // By the same clock as the silence: the world's time may run faster than the detector's.
  const bool hangs =
      requested_at_ && dependencies_.clock.Now() - *requested_at_ >= rules_.silence / 2;
  const std::string why =
      hangs ? "the detector has been processing one for " + MsText(events_.busy())
      : pictures_->MatchedWriters() == 0 ? "no publisher of " + Topic(rules_.picture)
      : publishers_fault_.error          ? publishers_fault_.error->message
      : still_fault_.error               ? "the picture stands still on " + Topic(rules_.picture)
                                         : "no usable picture on " + Topic(rules_.picture);
  faults_.Set(silence_,
              FeedFault(KeyCode::kTimeout, "no picture for " + MsText(rules_.silence) + ": " + why),
              "");
  AwaitNext();
  events_.on_silence();
}

Result<> PictureFeed::Check() const {
  constexpr auto kFailed = KeyCode::kSelfCheckFailed;
  const Duration busy = events_.busy();
  if (busy > rules_.hang) {
    return FeedFault(kFailed,
                     "the detector hangs: it has been processing one picture for " + MsText(busy));
  }
  if (detector_fault_.error) return FeedFault(kFailed, detector_fault_.error->message);
  if (still_fault_.error) return FeedFault(kFailed, still_fault_.error->message);
  if (publishers_fault_.error) return FeedFault(kFailed, publishers_fault_.error->message);
  if (!seen_) {
    if (picture_fault_.error) return FeedFault(kFailed, picture_fault_.error->message);
    if (requested_at_) {
      return FeedFault(kFailed,
                       "no picture of " + Topic(rules_.picture) +
                           " is processed yet: the detector is slow, or the computer busy");
    }
    const bool published = on() && pictures_->MatchedWriters() > 0;
    return FeedFault(kFailed, published ? "no picture came on " + Topic(rules_.picture)
                                        : "no publisher of " + Topic(rules_.picture));
  }
  // The second may have sent nothing yet. One that has crashed is matched until its lease ends.
  const bool alone = dependencies_.node.loop().Now() - publishers_.alone_since().value_or(Time()) >=
                     PicturePublishers::kWithin;
  if (pictures_ && pictures_->MatchedWriters() > 1 && !alone) {
    return FeedFault(kFailed, PublishersText());
  }
  if (!rules_.needs_lens || lens_ || rules_.hfov_rad) return Ok();
  return FeedFault(kFailed, info_fault_.error
                                ? info_fault_.error->message
                                : "no CameraInfo came on " + Topic(rules_.camera_info) +
                                      ", and the config has no hfov_deg: distances are not known");
}

}  // namespace musher::vision
