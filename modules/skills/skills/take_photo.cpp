#include "musher/modules/skills/skills/take_photo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

namespace musher::skills {
namespace {

constexpr Duration kBetweenAttempts = std::chrono::milliseconds(500);
constexpr double kInPictureRad = 0.6;  // to each side: what a camera shows that looks ahead
constexpr double kAimedRad = 0.1;
constexpr double kAimRadS = 0.6;
constexpr double kStillRadS = 0.05;  // a picture is sharp then
constexpr Duration kTurnHeldLimit = std::chrono::seconds(1);
constexpr Duration kUnknownLimit = std::chrono::seconds(1);

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

// A file of the format PPM.
std::vector<std::uint8_t> PpmOf(const Picture& picture) {
  const std::string head = fmt::format("P6\n{} {}\n255\n", picture.width, picture.height);
  std::vector<std::uint8_t> file(head.begin(), head.end());
  file.reserve(file.size() + picture.bgr.size());
  for (std::size_t i = 0; i + 2 < picture.bgr.size(); i += 3) {
    file.insert(file.end(), {picture.bgr[i + 2], picture.bgr[i + 1], picture.bgr[i]});
  }
  return file;
}

bool EndsInPng(const std::string& path) {
  constexpr std::string_view kEnding = ".png";
  if (path.size() <= kEnding.size()) return false;
  return std::ranges::equal(path.substr(path.size() - kEnding.size()), kEnding, [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

std::optional<std::string> PictureFault(const Picture& picture) {
  const std::uint64_t expected = std::uint64_t{3} * picture.width * picture.height;
  if (expected > 0 && picture.bgr.size() == expected) return std::nullopt;
  return fmt::format("a picture of {} x {} pixels with {} bytes", picture.width, picture.height,
                     picture.bgr.size());
}

}  // namespace

void TakePhoto::Declare(skill::Table& table) {
  table.Does("Saves the next picture of a camera as a PNG file, or keeps it in its data");
  table.Uses(kCamera);
  table.Takes("camera_type", "sensor.camera.rgb",
              "a camera of the robot; sensor.camera.rgb and default: its first one");
  table.Also("camera_type", "camera_name");
  table.Takes("save_path", "",
              "the file, which ends in .png; empty: the picture stays in the data");
  table.Also("save_path", "save_to_file");
  table.Takes("target", "", "an object to which it turns first, by its name or category");
  table.Takes("turn", true, "false: it does not turn, but waits until the target is ahead");
  table.UsesWhen(kBase, [](const skill::Values& given) {
    return !given.Text("target").empty() && given.Get<bool>("turn", true);
  });
  initializing_ = table.State("INITIALIZING", std::chrono::seconds(5));
  aiming_ = table.State("AIMING", std::chrono::seconds(15));
  executing_ = table.State("EXECUTING", std::chrono::seconds(5));
  saving_ = table.State("SAVING", std::chrono::seconds(10));
  table.To(initializing_, executing_, "the camera is available");
  table.To(initializing_, aiming_, "the target is aside");
  table.To(aiming_, executing_, "the robot looks at the target");
  table.To(executing_, initializing_, "retry");
  table.To(executing_, saving_, "the picture is taken");
  table.To(executing_, skill::kSucceeded, "the picture is kept");
  table.To(saving_, executing_, "the picture is lost");
  table.To(saving_, skill::kSucceeded, "the file is written");
  table.Limit({.retries = 2});
}

skill::Next TakePhoto::Initialize(skill::Tick& tick) {
  const auto camera = CameraOf(robot_, tick.parameters.Text("camera_type"));
  if (!camera) return skill::Next::Fail(camera.error().message);
  const std::string path = tick.parameters.Text("save_path");
  if (!path.empty() && !EndsInPng(path)) {
    return skill::Next::Fail("Invalid save_path '" + path + "': expected a file that ends in .png");
  }
  tick.data.Set("camera", camera.value());
  tick.Report(20, "Preparing camera");
  if (tick.retries > 0 && tick.elapsed < kBetweenAttempts) return skill::Next::Stay();
  return FindTarget(tick);
}

std::optional<TakePhoto::Aim> TakePhoto::AimAt(skill::Tick& tick) const {
  const auto pose = robot_.pose();
  const auto objects = robot_.Detect();
  if (!objects || !pose || !navigation::IsFinite(*pose)) return std::nullopt;
  const auto seen = Sightings(*objects, NameOfPrim(tick.parameters.Text("target")), *pose, {});
  DetailSightings(seen, tick);
  if (seen.empty()) return std::nullopt;
  const navigation::Point& at = seen.front().object.pose.at;
  const double x_m = at.x_m - pose->at.x_m, y_m = at.y_m - pose->at.y_m;
  const bool here = x_m == 0 && y_m == 0;
  return Aim{*pose, at, here ? 0 : navigation::Wrapped(std::atan2(y_m, x_m) - pose->yaw_rad)};
}

std::string TakePhoto::WhyNoAim(const std::string& target) const {
  if (!robot_.Detect()) return robot_.WhyNothingSeen();
  return robot_.pose() ? "the place of " + target + " is not known" : robot_.WhyNoPose();
}

bool TakePhoto::Turns(const skill::Tick& tick, const Aim& aim) const {
  constexpr double kInTheAirM = 0.1;
  if (!tick.parameters.Get<bool>("turn", true)) return false;
  return !robot_.flies() || aim.own.at.z_m >= kInTheAirM;
}

skill::Next TakePhoto::FindTarget(skill::Tick& tick) {
  const std::string target = NameOfPrim(tick.parameters.Text("target"));
  if (target.empty()) return skill::Next::To(executing_);
  tick.Report(20, "Looking for " + target);
  const auto aim = AimAt(tick);
  if (!aim) return skill::Next::Stay();
  const double off_rad = std::abs(aim->off_rad);
  if (Turns(tick, *aim)) return skill::Next::To(off_rad <= kAimedRad ? executing_ : aiming_);
  return off_rad <= kInPictureRad ? skill::Next::To(executing_) : skill::Next::Stay();
}

skill::Next TakePhoto::TurnToTarget(skill::Tick& tick) {
  const std::string target = NameOfPrim(tick.parameters.Text("target"));
  if (tick.entered) held_ = unknown_ = {};
  tick.Report(30, "Turning to " + target);
  const auto aim = AimAt(tick);
  unknown_ = aim ? Duration{} : unknown_ + tick.step;
  if (!aim) {
    StopTurn();
    if (unknown_ < kUnknownLimit) return skill::Next::Stay();
    return skill::Next::Fail("It has not turned to " + target + ": " + WhyNoAim(target));
  }
  tick.Detail("off_rad", aim->off_rad);
  if (std::abs(aim->off_rad) <= kAimedRad) {
    StopTurn();
    const bool turns = std::abs(robot_.velocity().yaw_rad_s) > kStillRadS;
    return turns ? skill::Next::Stay() : skill::Next::To(executing_);
  }
  Turn(*aim, tick);
  const std::string held_by = robot_.HeldBy();
  held_ = held_by.empty() ? Duration{} : held_ + tick.step;
  if (held_ < kTurnHeldLimit) return skill::Next::Stay();
  return EndTurn(aim, "It has not turned to " + target + ": " + held_by);
}

void TakePhoto::Turn(const Aim& aim, const skill::Tick& tick) {
  turning_ = true;
  if (!robot_.flies()) {
    return robot_.SetVelocity({.yaw_rad_s = std::clamp(1.5 * aim.off_rad, -kAimRadS, kAimRadS)});
  }
  if (!place_) place_ = aim.own;
  const navigation::Pose to{place_->at, navigation::Wrapped(aim.own.yaw_rad + aim.off_rad)};
  robot_.SetVelocity(hold_.Command(to, aim.own, PositionHold::SecondsOf(tick.step)));
}

skill::Next TakePhoto::EndTurn(const std::optional<Aim>& aim, const std::string& why) {
  StopTurn();
  const bool in_picture = aim && std::abs(aim->off_rad) <= kInPictureRad;
  return in_picture ? skill::Next::To(executing_, why) : skill::Next::Fail(why);
}

void TakePhoto::StopTurn() {
  // Without a turn another skill may move the robot.
  if (std::exchange(turning_, false)) robot_.StopMotion();
  place_.reset();
  hold_.Reset();
}

void TakePhoto::OnEnd(const skill::Ended& /*ended*/) {
  StopTurn();
}

void TakePhoto::OnPause() {
  StopTurn();
}

skill::Next TakePhoto::Keep(const Picture& picture, skill::Tick& tick) {
  tick.data.Set("photo_data", Base64(PpmOf(picture)));
  tick.Detail("width", static_cast<std::int64_t>(picture.width));
  tick.Detail("height", static_cast<std::int64_t>(picture.height));
  return skill::Next::Succeed("Photo captured");
}

skill::Next TakePhoto::Capture(skill::Tick& tick) {
  if (tick.entered || !picture_.valid()) picture_ = robot_.TakePicture(tick.data.Text("camera"));
  tick.Report(40, "Taking the picture");
  if (!picture_.done()) return skill::Next::Stay();
  if (!picture_.result()) {
    return skill::Next::Retry(initializing_,
                              "Capture failed: " + picture_.result().error().message);
  }
  const auto fault = PictureFault(picture_.result().value());
  if (fault) return skill::Next::Retry(initializing_, "Capture failed: " + *fault);
  if (tick.parameters.Text("save_path").empty()) return Keep(picture_.result().value(), tick);
  return skill::Next::To(saving_);
}

skill::Next TakePhoto::Save(skill::Tick& tick) {
  const std::string path = tick.parameters.Text("save_path");
  // A restored run has no picture any more.
  if (!picture_.done()) return skill::Next::Replan(executing_, "the picture is lost");
  const Picture& picture = picture_.result().value();
  if (tick.entered || !file_.valid()) file_ = robot_.SavePng(picture, path);
  tick.Report(80, "Saving the picture");
  if (!file_.done()) return skill::Next::Stay();
  if (!file_.result()) {
    return skill::Next::Fail("Save failed: " + file_.result().error().message);
  }
  tick.Detail("path", file_.result().value());
  tick.Detail("width", static_cast<std::int64_t>(picture.width));
  tick.Detail("height", static_cast<std::int64_t>(picture.height));
  return skill::Next::Succeed("Photo saved to " + file_.result().value());
}

skill::Next TakePhoto::Step(skill::Tick& tick) {
  if (tick.state == initializing_) return Initialize(tick);
  if (tick.state == aiming_) return TurnToTarget(tick);
  return tick.state == executing_ ? Capture(tick) : Save(tick);
}

skill::Next TakePhoto::OnLimit(skill::Tick& tick) {
  const std::string after = " after " + skill::SecondsText(tick.elapsed);
  if (tick.state == saving_) return skill::Next::Fail("Timeout: the file is not written" + after);
  const std::string target = NameOfPrim(tick.parameters.Text("target"));
  if (tick.state == aiming_) {
    return EndTurn(AimAt(tick), "Timeout: it has not turned to " + target + after);
  }
  if (tick.state == initializing_) {
    const std::string why = AimAt(tick) ? "it is not ahead of the camera" : WhyNoAim(target);
    return skill::Next::Fail("Timeout: " + target + " is not in sight" + after + ": " + why);
  }
  return skill::Next::Fail("Timeout: no picture of camera '" + tick.data.Text("camera") + "'" +
                           after);
}

}  // namespace musher::skills
