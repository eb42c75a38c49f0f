// Reads the guests of a scene, and checks that they can be where they are placed.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/scene_file/scene_keys.hpp"
#include "musher/modules/world/scene_file/scene_things.hpp"
#include "musher/modules/world/simulation/guests.hpp"

namespace musher::world {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Position;
using config_toml::TableReader;

constexpr int kMostFace = 999;
constexpr double kLeastTallM = 0.5;
constexpr double kMostTallM = 2.5;
constexpr double kLeastWalk = 0.05;
constexpr double kMostWalk = 3;
constexpr double kLongestTimetableS = 3600;  // of a timetable
constexpr std::size_t kMostGuests = 50;

std::string At(Duration time) {
  char text[32];
  std::snprintf(text, sizeof(text), "at %.1f s", ToSeconds(time));
  return text;
}

// Where it is written in the file, and its name in messages.
struct Written {
  Position at;
  std::string path;
};

class GuestReader {
 public:
  GuestReader(Findings& findings, Scene& scene) : findings_(findings), scene_(scene) {}

  void Read(TableReader& reader) {
    GuestSpec guest;
    keys::ReadSome(
        reader,
        {row::Text("name", guest.name), keys::Center(guest.from_m),
         keys::Angle("yaw_deg", guest.yaw_rad), row::Integer("face", guest.face, 0, kMostFace),
         row::Number("height_m", guest.height_m, kLeastTallM, kMostTallM),
         row::Number("speed_m_s", guest.speed_m_s, kLeastWalk, kMostWalk),
         keys::Colour("color", guest.color, findings_), row::Bool("gown", guest.gown)});
    keys::Each(reader, "act", findings_, [&](TableReader& act) { ReadAct(act, guest); });
    const auto earlier = [](const GuestAct& a, const GuestAct& b) { return a.at < b.at; };
    if (!std::is_sorted(guest.acts.begin(), guest.acts.end(), earlier)) {
      findings_.Error(reader.At("act"), reader.path() + ".act: expected them in the order of at_s");
    }
    written_.push_back({reader.at(), reader.path()});
    scene_.guests.push_back(std::move(guest));
  }

  // Runs their timetables once, without the robot's own movements.
  void Try() {
    if (scene_.guests.size() > kMostGuests) {
      return findings_.Error(written_[kMostGuests].at, "expected at most 50 guests");
    }
    constexpr Duration kTryStep = Milliseconds(100);
    Guests guests(scene_);
    const Robot robot = RobotAtStart();
    const Duration end = End();
    reported_.assign(scene_.guests.size(), false);
    for (Duration now{}; now < end; now += kTryStep) {
      guests.Step(scene_, robot, now, kTryStep);
      for (std::size_t i = 0; i < reported_.size(); ++i) Check(guests.all(), i, now);
    }
    if (scene_.guests_repeat == Duration::zero()) return;
    for (std::size_t i = 0; i < reported_.size(); ++i) {
      if (!guests.all()[i].here || scene_.guests[i].acts.empty()) continue;
      Report(i, "is still present when the timetable repeats, at repeat_s of [guests]");
    }
  }

 private:
  void ReadAct(TableReader& reader, GuestSpec& guest) {
    using LookAt = GuestLook::At;
    GuestAct act;
    double at_s = 0;
    row::Required("at_s", "a time", row::Number("at_s", at_s, 0, kLongestTimetableS))(reader);
    act.at = FromSeconds(at_s);
    act.walk_to_m = keys::ReadPoint(reader, "walk_to_m");
    act.speed_m_s = reader.Number("speed_m_s", kLeastWalk, kMostWalk);
    if (const auto look = reader.Choice<LookAt>(
            "look",
            {{"robot", LookAt::kRobot}, {"away", LookAt::kAway}, {"ahead", LookAt::kAhead}})) {
      act.look = GuestLook{*look};
    }
    if (const auto degrees = reader.Number("look_deg", -360, 360)) {
      if (act.look) {
        reader.Fault(reader.At("look_deg"), "look_deg", "expected either look or look_deg");
      }
      act.look = GuestLook{LookAt::kYaw, keys::Radians(*degrees)};
    }
    std::vector<std::pair<std::string_view, Gesture>> gestures;
    for (std::size_t i = 0; i < kGestureNames.size(); ++i) {
      gestures.emplace_back(kGestureNames[i], static_cast<Gesture>(i));
    }
    act.gesture = reader.Choice("gesture", gestures);
    act.leave = reader.Bool("leave").value_or(false);
    const Vector2 start = scene_.start.position_m;
    const double least_m = scene_.body.radius_m + kGuestRadiusM;
    if (act.walk_to_m && (*act.walk_to_m - start).norm() < least_m) {
      reader.Fault(reader.At("walk_to_m"), "walk_to_m",
                   "too close to the robot: expected at least its radius_m and 0.2 m from it");
    }
    guest.acts.push_back(act);
  }

  Robot RobotAtStart() const {
    const Attitude standing{scene_.body.stand_height_m, 0, 0};
    return {scene_.start.position_m, scene_.body.radius_m,
            CameraInPlace(scene_.cameras.cameras.front(), scene_.start, standing).translation()};
  }

  // When all have done everything, or repeat.
  Duration End() const {
    constexpr Duration kLastWalk = std::chrono::minutes(2);
    if (scene_.guests_repeat > Duration::zero()) return scene_.guests_repeat;
    Duration end{};
    for (const GuestSpec& guest : scene_.guests) {
      if (!guest.acts.empty()) end = std::max(end, guest.acts.back().at);
    }
    return end + kLastWalk;
  }

  void Check(const std::vector<Guest>& guests, std::size_t i, Duration now) {
    const Guest& guest = guests[i];
    if (!guest.here) return;
    const GuestSpec& spec = scene_.guests[i];
    if (!IsFree(scene_, guest.position_m, kGuestRadiusM, spec.height_m)) {
      Report(i, At(now) + " it is in an obstacle or outside the place");
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (!guests[j].here) continue;
      if ((guests[j].position_m - guest.position_m).norm() >= 2 * kGuestRadiusM) continue;
      Report(i, At(now) + " it overlaps " + written_[j].path);
    }
  }

  // Once for each guest: later errors follow from the first.
  void Report(std::size_t i, const std::string& what) {
    if (reported_[i]) return;
    reported_[i] = true;
    findings_.Error(written_[i].at, written_[i].path + ": " + what);
  }

  using Vector2 = Eigen::Vector2d;

  Findings& findings_;
  Scene& scene_;
  std::vector<Written> written_;
  std::vector<bool> reported_;
};

}  // namespace

void ReadGuests(TableReader& root, Findings& findings, Scene& scene) {
  double repeat_s = ToSeconds(scene.guests_repeat);
  row::Sub("guests", {row::Number("repeat_s", repeat_s, 0, kLongestTimetableS),
                      keys::Topic("gesture_topic", scene.gesture_topic)})(root);
  scene.guests_repeat = FromSeconds(repeat_s);
  GuestReader guests(findings, scene);
  keys::Each(root, "guest", findings, [&](TableReader& reader) { guests.Read(reader); });
  if (!findings.HasErrors()) guests.Try();
}

}  // namespace musher::world
