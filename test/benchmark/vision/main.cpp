// The face detector over the frames of the wedding scene: how much of a CPU a picture takes it,
// which of the guests who look at the robot it finds, what it finds where no guest is, and the
// error of its distances.
//
//   benchmark_vision [SECONDS [MODEL]]
//
// The robot stands and looks ahead, a picture each 200 ms of the world's time. Guests whose face is
// hidden, by the edge of the picture or by another one, are not counted.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/picture/lens.hpp"
#include "musher/modules/world/render/shot.hpp"
#include "musher/modules/world/scene_file/scene_toml.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::benchmark {
namespace {

constexpr double kFaceM = 0.2;  // distances are given as shares of those with the fitting one

struct Truth {
  Eigen::Vector2d at{0, 0};  // in the picture, shares of it
  double size = 0;           // of the head, share of the picture's height
  double distance_m = 0;
  bool looks = false;
  bool hidden = false;
};

struct Frame {
  msg::Image picture;
  std::vector<Truth> guests;
};

msg::Image Message(world::Image image) {
  msg::Image picture;
  picture.width = static_cast<std::uint32_t>(image.width);
  picture.height = static_cast<std::uint32_t>(image.height);
  picture.encoding = "bgr8";
  picture.step = picture.width * 3;
  picture.data = std::move(image.bgr);
  return picture;
}

// The guests in the picture, or partly in it.
std::vector<Truth> GuestsIn(const world::World& world, const world::Camera& camera) {
  const auto from_place = world.CameraPose(0).inverse();
  const auto& lens = camera.intrinsics();
  std::vector<Truth> guests;
  for (std::size_t i = 0; i < world.guests().size(); ++i) {
    const world::Guest& guest = world.guests()[i];
    if (!guest.here) continue;
    const auto& spec = world.scene().guests.at(i);
    const Eigen::Vector3d head = from_place * HeadOf(spec, guest);
    const auto pixel = Project(lens, head);
    if (!pixel || head.z() < 0.1) continue;
    Truth truth;
    truth.at = {pixel->x() / lens.width_px, pixel->y() / lens.height_px};
    truth.size = HeadHeightM(spec) * lens.focal_px / head.z() / lens.height_px;
    truth.distance_m = head.norm();
    truth.looks = guest.looks_at_robot;
    const double margin = truth.size / 2;
    truth.hidden = truth.at.x() < margin || truth.at.x() > 1 - margin || truth.at.y() < margin ||
                   truth.at.y() > 1 - margin;
    guests.push_back(truth);
  }
  for (Truth& behind : guests) {
    for (const Truth& before : guests) {
      const double apart = (behind.at - before.at).norm();
      if (before.distance_m < behind.distance_m && apart < before.size) behind.hidden = true;
    }
  }
  return guests;
}

std::vector<Frame> FramesOf(const std::string& file, int seconds) {
  world::SceneReading reading = world::ReadSceneFile(file);
  if (!reading.scene) {
    std::fprintf(stderr, "%s cannot be read\n", file.c_str());
    std::exit(1);
  }
  world::World world(*reading.scene);
  const auto scenery = world::Scenery::Make(world.scene());
  if (!scenery) std::exit(1);
  const world::Camera camera(world.scene().cameras.cameras[0]);
  std::vector<Frame> frames;
  constexpr int kSteps = 10;  // of 20 ms
  for (int i = 0; i < seconds * 5; ++i) {
    for (int step = 0; step < kSteps; ++step) world.Step();
    frames.push_back(
        {Message(camera.Shoot(*scenery.value(), ViewOf(world, 0))), GuestsIn(world, camera)});
  }
  return frames;
}

struct Found {
  std::vector<std::vector<vision::FaceBox>> faces;  // of each frame
  std::vector<double> times_ms;
};

// Of this thread, on which the detector works: other work on the machine does not count.
double CpuMs() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) / 1e6;
}

Found Look(vision::Detector& detector, const std::vector<Frame>& frames) {
  Found found;
  for (const Frame& frame : frames) {
    const double begin_ms = CpuMs();
    found.faces.push_back(detector.Detect(frame.picture));
    found.times_ms.push_back(CpuMs() - begin_ms);
  }
  return found;
}

bool IsAt(const Truth& guest, const vision::FaceBox& face) {
  return (guest.at - Eigen::Vector2d(face.center_x(), face.center_y())).norm() < guest.size;
}

struct Score {
  int counted = 0;
  int found = 0;
  int turned = 0;        // guests that do not look at the robot
  int found_turned = 0;  // and are found
  int false_finds = 0;
  std::vector<double> ratios;  // of a distance to the true one, by kFaceM
};

// Of guests from `from_m` to `to_m` away.
Score ScoreOf(const Found& found, const std::vector<Frame>& frames, const vision::Lens& lens,
              double from_m, double to_m) {
  Score score;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& faces = found.faces[i];
    const auto& guests = frames[i].guests;
    for (const Truth& guest : guests) {
      if (guest.hidden || guest.distance_m < from_m || guest.distance_m >= to_m) continue;
      const auto face = std::find_if(faces.begin(), faces.end(),
                                     [&](const auto& each) { return IsAt(guest, each); });
      const bool is_found = face != faces.end();
      (guest.looks ? score.counted : score.turned) += 1;
      (guest.looks ? score.found : score.found_turned) += is_found ? 1 : 0;
      if (!guest.looks || !is_found) continue;
      score.ratios.push_back(DistanceM(lens, *face, face->height, kFaceM) / guest.distance_m);
    }
    for (const vision::FaceBox& face : faces) {
      const bool is_false = std::none_of(guests.begin(), guests.end(),
                                         [&](const Truth& guest) { return IsAt(guest, face); });
      score.false_finds += is_false ? 1 : 0;
    }
  }
  return score;
}

void Run(int seconds, const std::string& model) {
  const auto frames = FramesOf(SourceDir() + "/config/scenes/wedding.toml", seconds);
  const auto reading = world::ReadSceneFile(SourceDir() + "/config/scenes/wedding.toml");
  const vision::Lens lens = vision::PinholeOf(reading.scene->cameras.cameras[0].hfov_rad, 640, 480);
  const Table table("A picture of 640 x 480 of the wedding scene, " +
                    std::to_string(frames.size()) + " of them");
  std::vector<std::string> lines;
  for (const auto& [width_px, step] :
       {std::pair(320, 1.1), std::pair(320, 1.2), std::pair(400, 1.1), std::pair(480, 1.1),
        std::pair(480, 1.2), std::pair(640, 1.1)}) {
    vision::CascadeConfig config;
    config.model = model;
    config.width_px = width_px;
    config.step = step;
    auto detector = vision::MakeCascadeDetector(config);
    if (!detector) {
      std::fprintf(stderr, "%s\n", detector.error().message.c_str());
      std::exit(1);
    }
    char setting[64];
    std::snprintf(setting, sizeof setting, "%d px wide, steps of %.1f", width_px, step);
    const Found found = Look(*detector.value(), frames);
    const Score all = ScoreOf(found, frames, lens, 0, 1e9);
    table.Row(setting, found.times_ms, "ms");
    std::string line = std::string("| ") + setting;
    for (const auto& [from_m, to_m] :
         {std::pair(0.0, 0.7), std::pair(0.7, 2.0), std::pair(2.0, 2.5), std::pair(2.5, 9.0)}) {
      const Score score = ScoreOf(found, frames, lens, from_m, to_m);
      line += " | " + std::to_string(score.found) + " of " + std::to_string(score.counted);
    }
    line += " | " + std::to_string(all.found_turned) + " of " + std::to_string(all.turned) + " | " +
            std::to_string(all.false_finds);
    char off[64];
    std::snprintf(off, sizeof off, " | %.3f (%.3f - %.3f) |", Median(all.ratios),
                  Quantile(all.ratios, 0.05), Quantile(all.ratios, 0.95));
    lines.push_back(line + off);
  }
  std::puts(
      "\n| setting | found below 0.7 m | 0.7 to 2 m | 2 to 2.5 m | beyond | found of those who "
      "look elsewhere | false | distance by 0.2 m / true one, median (5 - 95 %) |\n"
      "|---|---|---|---|---|---|---|---|");
  for (const std::string& line : lines) std::puts(line.c_str());
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 90;
  musher::benchmark::Run(seconds, argc > 2 ? argv[2] : musher::vision::DefaultModel());
}
