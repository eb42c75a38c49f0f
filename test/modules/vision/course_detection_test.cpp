// The detectors of config/vision/course.toml in rendered pictures of the course with labels, as far
// away and as much from aside as the course uses them. benchmark_detection has the whole figures.

#include <gmock/gmock.h>

#include <map>
#include <ostream>

#include "musher/test/modules/vision/labelled/tally.hpp"

namespace musher::vision {
namespace {

constexpr double kWalkedByM = 1;  // the walker depends on lines up to there

std::unique_ptr<CourseDetector> Made(const CourseEntry& entry) {
  if (entry.kind != CourseKind::kQr) return entry.factory.make().value();
  auto parameters = std::get<QrParameters>(entry.parameters);
  parameters.thorough_every = 1;
  parameters.letters = false;  // they take a tenth of a second where there are none
  return MakeQrDetector(parameters);
}

Tally Looked(CourseKind kind, const LabelledSettings& settings) {
  const std::vector<CourseEntry> entries = ShippedDetectors();
  std::map<std::string, std::unique_ptr<CourseDetector>> detectors;
  Tally tally;
  std::int64_t stamp_ns = 0;
  SeeLabelledPictures(settings, {kind}, [&](const LabelledPicture& picture) {
    const CourseEntry& entry = DetectorOf(entries, kind, picture.camera);
    auto& detector = detectors[entry.name];
    if (!detector) detector = Made(entry);
    const CourseSight sight = detector->Look(picture.bgr, ++stamp_ns, picture.lens);
    if (!sight.lines) {
      tally.Add(TallyOf(sight, picture));
      return;
    }
    const auto& parameters = std::get<LinesParameters>(entry.parameters);
    const LineTallies by_range = TallyOfLines(*sight.lines, parameters, picture);
    for (std::size_t i = 0; kLineRangesM.at(i + 1) <= kWalkedByM; ++i) tally.Add(by_range.at(i));
  });
  return tally;
}

struct Floor {
  const char* name;
  CourseKind kind;
  double most_distance_m;
  double most_angle_deg;
  double least_found;  // share
  int least_shown;     // pictures, or columns of lines

  friend std::ostream& operator<<(std::ostream& out, const Floor& floor) {
    return out << floor.name;
  }
};

class ShippedDetector : public ::testing::TestWithParam<Floor> {};

TEST_P(ShippedDetector, FindsTheThingAndNothingElse) {
  const Floor& floor = GetParam();
  LabelledSettings settings;
  settings.lights = 1;
  settings.texels_per_m = 100;
  settings.most_distance_m = floor.most_distance_m;
  settings.most_angle_deg = floor.most_angle_deg;
  const Tally tally = Looked(floor.kind, settings);
  EXPECT_GE(tally.shown, floor.least_shown);
  EXPECT_GE(tally.absent, floor.least_shown / 2);
  EXPECT_GE(tally.found, floor.least_found * tally.shown) << "of " << tally.shown;
  EXPECT_EQ(tally.false_finds, 0) << "of " << tally.shown + tally.absent;
}

INSTANTIATE_TEST_SUITE_P(OfTheCourse, ShippedDetector,
                         ::testing::Values(Floor{"Qr", CourseKind::kQr, 3.0, 15, 0.9, 10},
                                           Floor{"Arrow", CourseKind::kArrow, 3.0, 30, 1, 12},
                                           Floor{"Barrier", CourseKind::kBarrier, 3.0, 30, 1, 12},
                                           Floor{"Marker", CourseKind::kMarker, 3.0, 30, 1, 12},
                                           Floor{"Light", CourseKind::kLight, 2.5, 30, 1, 12},
                                           Floor{"Lines", CourseKind::kLines, 3, 30, 0.85, 300}),
                         [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace musher::vision
