#include "musher/modules/skills/skills/take_photo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {
namespace {

constexpr Duration kBetweenAttempts = std::chrono::milliseconds(500);
constexpr View kInPicture{0, 1.2};  // what a camera shows that looks ahead

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
  table.Takes("target", "", "an object that has to be in sight, by its name or category");
  initializing_ = table.State("INITIALIZING", std::chrono::seconds(5));
  executing_ = table.State("EXECUTING", std::chrono::seconds(5));
  saving_ = table.State("SAVING", std::chrono::seconds(10));
  table.To(initializing_, executing_, "the camera is available");
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
  return SeesTarget(tick) ? skill::Next::To(executing_) : skill::Next::Stay();
}

bool TakePhoto::SeesTarget(skill::Tick& tick) const {
  const std::string target = NameOfPrim(tick.parameters.Text("target"));
  if (target.empty()) return true;
  tick.Report(20, "Looking for " + target);
  const auto pose = robot_.pose();
  const auto objects = robot_.Detect();
  if (!objects || !pose || !navigation::IsFinite(*pose)) return false;
  const auto seen = Sightings(*objects, target, *pose, kInPicture);
  DetailSightings(seen, tick);
  return !seen.empty();
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
  return tick.state == executing_ ? Capture(tick) : Save(tick);
}

skill::Next TakePhoto::OnLimit(skill::Tick& tick) {
  const std::string after = " after " + skill::SecondsText(tick.elapsed);
  if (tick.state == saving_) return skill::Next::Fail("Timeout: the file is not written" + after);
  if (tick.state == initializing_) {
    const std::string why = !robot_.Detect() ? robot_.WhyNothingSeen()
                            : !robot_.pose() ? robot_.WhyNoPose()
                                             : "it is not ahead of the camera";
    return skill::Next::Fail("Timeout: " + NameOfPrim(tick.parameters.Text("target")) +
                             " is not in sight" + after + ": " + why);
  }
  return skill::Next::Fail("Timeout: no picture of camera '" + tick.data.Text("camera") + "'" +
                           after);
}

}  // namespace musher::skills
