// The shipped detectors of lines on floors, in light and with lanes that no author of a detector
// has drawn: a word is right, or they say that they are not sure. See floor_pictures.hpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <iostream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "musher/modules/vision/course/lines_finder.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/test/modules/vision/floor_pictures.hpp"
#include "musher/test/modules/vision/photographs.hpp"
#include "musher/test/support/nightly.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision::floors {
namespace {

LinesParameters Shipped(const std::string& name) {
  const Parsed<VisionConfig> reading = ReadVisionFile(SourceDir() + "/config/vision/course.toml");
  for (const CourseEntry& entry : reading.config.value().detectors) {
    if (entry.name == name) return std::get<LinesParameters>(entry.parameters);
  }
  ADD_FAILURE() << "there is no detector " << name;
  return {};
}

// Where a detector of the course looks, and how it stands there.
struct View {
  std::string detector;
  Camera camera;
  bool across = false;  // the lane crosses the robot's way: left in the picture of `right` is ahead
  double middle_m = 0;  // of the camera from the body's middle, along what it measures
  double to_right = 1;  // -1: a robot that is too far ahead sees the lane to the right
};

const std::vector<View>& Views() {
  static const std::vector<View> all = {{"front_lane", kFront, false, 0, 1},
                                        {"right_lane", kRight, true, 0, 1},
                                        {"left_lane", kLeft, true, 0, -1}};
  return all;
}

// Of the lane beside it on the left only the farther line, 1.3 m from the middle, is ever there.
enum class Lines {
  kTwo,
  kLeftOnly,
  kRightOnly,
  kBroken,
  kNone,
  kTwoAndFar,
  kRightAndFar,
  kFarOnly
};
constexpr std::array kAllLines{Lines::kTwo,         Lines::kLeftOnly, Lines::kRightOnly,
                               Lines::kBroken,      Lines::kNone,     Lines::kTwoAndFar,
                               Lines::kRightAndFar, Lines::kFarOnly};
std::string_view NameOf(Lines lines) {
  constexpr std::array<std::string_view, 8> kNames{
      "two lines", "left one",         "right one",          "pieces of one",
      "no line",   "two, next lane's", "right, next lane's", "next lane's alone"};
  return kNames.at(static_cast<std::size_t>(lines));
}

struct Case {
  View view;
  Material material = Material::kGrey;
  Light light;
  Lines lines = Lines::kTwo;
  double width_m = 0.05;
  double aside_m = 0;  // of the robot from the lane's middle: to the left, or ahead of it
  std::uint64_t seed = 1;
  cv::Mat photograph{};  // of the floor, instead of the material
  double wide_m = 1;     // of it
  std::string photograph_name{};
};

// The tapes of a lane that is 0.83 m wide between them, beside a robot that is not in its middle.
std::vector<Tape> TapesOf(const Case& tried) {
  std::vector<Tape> tapes;
  const auto add = [&](double aside_m, double from_m, double to_m) {
    const double at = aside_m - tried.aside_m;
    tapes.push_back(tried.view.across ? Tape{{at, from_m}, {at, to_m}, tried.width_m}
                                      : Tape{{from_m, at}, {to_m, at}, tried.width_m});
  };
  const double half = (0.83 + tried.width_m) / 2;
  const auto is_any_of = [&](std::initializer_list<Lines> some) {
    return std::ranges::find(some, tried.lines) != some.end();
  };
  if (is_any_of({Lines::kTwo, Lines::kTwoAndFar, Lines::kLeftOnly})) add(half, -2.4, 2.4);
  if (is_any_of({Lines::kTwo, Lines::kTwoAndFar, Lines::kRightOnly, Lines::kRightAndFar})) {
    add(-half, -2.4, 2.4);
  }
  if (is_any_of({Lines::kTwoAndFar, Lines::kRightAndFar, Lines::kFarOnly}))
    add(3 * half, -2.4, 2.4);
  if (tried.lines == Lines::kBroken) {
    for (double from = -2.4; from < 2.4; from += 0.22) add(half, from, from + 0.15);
  }
  return tapes;
}

enum class Verdict { kRight, kUnsure, kWrong };

std::string Truth(const Case& tried) {
  constexpr double kInTheMiddleM = 0.03;
  if (std::abs(tried.aside_m) < kInTheMiddleM) return "center";
  return tried.aside_m * tried.view.to_right > 0 ? "left" : "right";
}

bool HasLane(Lines lines) {
  return lines != Lines::kNone && lines != Lines::kFarOnly;
}

Verdict Compare(const Case& tried, const msg::YellowLines& lines) {
  if (!lines.doubt.empty() || lines.contours == 0) return Verdict::kUnsure;
  if (!HasLane(tried.lines)) return Verdict::kWrong;
  return lines.ycy == Truth(tried) ? Verdict::kRight : Verdict::kWrong;
}

std::string_view PoolsOf(const Light& light) {
  return light.pools ? " and lamps" : "";
}

std::string TextOf(const Case& tried) {
  std::string material = tried.photograph_name;
  for (const auto& [each, name] : Materials()) {
    if (material.empty() && each == tried.material) material = name;
  }
  return fmt::format("{} on {}, {:.0f} K, {:.0f} % light{}, {}, {:.0f} cm wide, {:+.2f} m, seed {}",
                     tried.view.detector, material, tried.light.kelvin, 100 * tried.light.share,
                     PoolsOf(tried.light), NameOf(tried.lines), 100 * tried.width_m, tried.aside_m,
                     tried.seed);
}

// The pictures of a floor in a light: each view, each kind of line, three places of the robot.
std::vector<Case> CasesOn(Material material, const Light& light, std::uint64_t seed) {
  constexpr std::array kWidthsM{0.03, 0.05, 0.07};
  std::vector<Case> cases;
  for (const View& view : Views()) {
    for (const Lines lines : kAllLines) {
      for (const double aside_m : {-0.2, 0.0, 0.2}) {
        if (lines == Lines::kNone && aside_m != 0) continue;
        cases.push_back(
            {view, material, light, lines, kWidthsM.at(seed % kWidthsM.size()), aside_m, ++seed});
      }
    }
  }
  return cases;
}

struct Count {
  int right = 0, unsure = 0, wrong = 0;
  void Add(Verdict verdict) {
    ++(verdict == Verdict::kRight ? right : verdict == Verdict::kUnsure ? unsure : wrong);
  }
  int all() const { return right + unsure + wrong; }
};

class Tally {
 public:
  Tally() {
    for (const View& view : Views()) parameters_[view.detector] = Shipped(view.detector);
  }

  // A new row.
  void Begin() { counts_ = {}; }

  void Try(const Case& tried) {
    const cv::Mat bgr = FloorPicture({tried.material, tried.light, TapesOf(tried), tried.seed,
                                      tried.photograph, tried.wide_m})
                            .SeenBy(tried.view.camera);
    const msg::YellowLines lines = FindLines(bgr, parameters_[tried.view.detector]).lines;
    const Verdict verdict = Compare(tried, lines);
    counts_[tried.lines].Add(verdict);
    // Without a lane nothing has to be found: a doubt is right.
    all_.Add(!HasLane(tried.lines) && verdict == Verdict::kUnsure ? Verdict::kRight : verdict);
    const bool is_known = tried.material == Material::kParquet && tried.light.pools;
    if (verdict == Verdict::kWrong && is_known) ++known_wrong_;
    if (verdict == Verdict::kWrong && !is_known) {
      wrong_ += fmt::format("{}: {} of {} lines, offset {:.3f}\n", TextOf(tried), lines.ycy,
                            lines.contours, lines.middle_offset);
    }
    if (const char* folder = std::getenv("MUSHER_SHOW_PICTURES");
        folder != nullptr && verdict != Verdict::kRight &&
        (HasLane(tried.lines) || verdict == Verdict::kWrong)) {
      Show(folder, bgr, tried, lines);
    }
  }

  const std::string& wrong() const { return wrong_; }
  int known_wrong() const { return known_wrong_; }
  const Count& all() const { return all_; }
  std::string Row() {
    std::string row;
    for (const Lines lines : kAllLines) {
      const Count& count = counts_[lines];
      row += fmt::format("{} {}/{}/{}; ", NameOf(lines), count.right, count.unsure, count.wrong);
    }
    return row;
  }

 private:
  static void Show(const std::string& folder, const cv::Mat& bgr, const Case& tried,
                   const msg::YellowLines& lines);

  std::map<std::string, LinesParameters> parameters_;
  std::map<Lines, Count> counts_;  // of the row
  Count all_;
  std::string wrong_;
  int known_wrong_ = 0;
};

void Tally::Show(const std::string& folder, const cv::Mat& bgr, const Case& tried,
                 const msg::YellowLines& lines) {
  static int number = 0;
  cv::Mat shown = bgr.clone();
  const std::string text = fmt::format("{} {} {:.3f} of {}", TextOf(tried), lines.ycy,
                                       lines.middle_offset, lines.contours);
  cv::putText(shown, text, {4, 12}, cv::FONT_HERSHEY_SIMPLEX, 0.3, {0, 0, 255});
  cv::putText(shown, lines.doubt, {4, 26}, cv::FONT_HERSHEY_SIMPLEX, 0.3, {0, 0, 255});
  cv::imwrite(fmt::format("{}/{:04}.png", folder, number++), shown);
}

constexpr std::array kLights{Light{6500, 1},        Light{6500, 0.3}, Light{3000, 0.3},
                             Light{8000, 1},        Light{3000, 1},   Light{6500, 0.1},
                             Light{6500, 0.3, true}};

// A sixth of the pictures of every floor in its hardest lights in the gate, all in the nightly run;
// MUSHER_FIRST=N has other pictures.
TEST(LinesOnFloors, AreRightOrInDoubt) {
  constexpr int kGateStep = 6;
  int number = 0;
  Tally tally;
  const char* first = std::getenv("MUSHER_FIRST");
  std::uint64_t seed = first == nullptr ? 1 : std::strtoull(first, nullptr, 10);
  for (const auto& [material, name] : Materials()) {
    for (const Light& light : kLights) {
      seed += 100;
      const bool is_hard = (light.kelvin == 3000 && light.share < 1) || light.pools;
      if (!testing::Nightly() && !is_hard) continue;
      tally.Begin();
      for (const Case& tried : CasesOn(material, light, seed)) {
        if (testing::Nightly() || ++number % kGateStep == 0) tally.Try(tried);
      }
      std::cout << fmt::format("{}, {:.0f} K, {:.0f} % light{}, right/unsure/wrong: {}\n", name,
                               light.kelvin, 100 * light.share, PoolsOf(light), tally.Row());
    }
  }
  // Known: a strip of parquet in a lamp's light may be as wide and as yellow as a line.
  constexpr int kMostInParquetUnderLamps = 4;
  EXPECT_EQ(tally.wrong(), "");
  EXPECT_LE(tally.known_wrong(), kMostInParquetUnderLamps);
  // Half of the gate's pictures are in lamps' light.
  EXPECT_GE(tally.all().right, (testing::Nightly() ? 0.9 : 0.85) * tally.all().all());
}

// Lines on floors of photographs of Debian packages.
class LinesOnPhotographs : public ::testing::TestWithParam<photographs::Package> {};

TEST_P(LinesOnPhotographs, AreRightOrInDoubt) {
  if (!photographs::IsInstalled(GetParam())) {
    GTEST_SKIP() << "needs the Debian package " << GetParam().name;
  }
  Tally tally;
  std::uint64_t seed = 3000;
  for (const photographs::Photograph& floor : GetParam().floors) {
    const cv::Mat photograph = photographs::LinearOf(GetParam(), floor);
    for (const Light& light : {Light{6500, 1}, Light{3000, 0.3}}) {
      tally.Begin();
      for (Case tried : CasesOn(Material::kGrey, light, seed += 100)) {
        tried.photograph = photograph;
        tried.wide_m = floor.wide_m;
        tried.photograph_name = floor.name;
        tally.Try(tried);
      }
      std::cout << fmt::format("{}, {:.0f} K, {:.0f} % light, right/unsure/wrong: {}\n", floor.name,
                               light.kelvin, 100 * light.share, tally.Row());
    }
  }
  // Known: three of 1,320, where one of three lines is not seen, or grass has the colour of the
  // lines in a warm lamp's light.
  constexpr double kMostWrong = 0.01;
  EXPECT_LE(tally.all().wrong, kMostWrong * tally.all().all()) << tally.wrong();
}

std::vector<photographs::Package> WithFloors() {
  std::vector<photographs::Package> packages = photographs::Packages();
  std::erase_if(packages, [](const photographs::Package& each) { return each.floors.empty(); });
  return packages;
}

std::string NameOfPackage(const ::testing::TestParamInfo<photographs::Package>& info) {
  std::string name = info.param.name;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Packages, LinesOnPhotographs, ::testing::ValuesIn(WithFloors()),
                         NameOfPackage);

}  // namespace
}  // namespace musher::vision::floors
