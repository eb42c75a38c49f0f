#include "musher/test/modules/vision/labelled/tally.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "musher/modules/vision/vision_config.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::vision {
namespace {

cv::Rect2d BoxOf(const msg::Sighting& sighting, const cv::Size& size) {
  return {double(sighting.x) * size.width, double(sighting.y) * size.height,
          double(sighting.width) * size.width, double(sighting.height) * size.height};
}

// Whether the middle of one is in the other, and their sizes are alike.
bool IsOver(const cv::Rect2d& found, const cv::Rect2d& real) {
  constexpr double kRimPx = 4;
  const cv::Point2d middle = (found.tl() + found.br()) / 2;
  const cv::Rect2d around(real.x - kRimPx, real.y - kRimPx, real.width + 2 * kRimPx,
                          real.height + 2 * kRimPx);
  return around.contains(middle) && found.area() < 4 * around.area();
}

// Pixels of one column; whole numbers are the middles of pixels.
struct Column {
  double x = 0;
  int top = 0, bottom = 0;  // the first and the last row of the region
};

struct Edge {
  double y = 0;
  Eigen::Vector2d at_m{0, 0};
};

std::optional<Edge> PaintedEdge(const LabelledPicture& picture, const Column& column) {
  for (int y = column.bottom; y >= column.top; --y) {
    const auto at = picture.GroundAt({column.x, double(y)});
    if (at && picture.lines->HasLine(*at)) return Edge{double(y), *at};
  }
  return std::nullopt;
}

std::optional<std::size_t> RangeOf(const LabelledPicture& picture, const Eigen::Vector2d& at_m) {
  const double distance_m = (at_m - picture.body_m).norm();
  for (std::size_t i = 0; i + 1 < kLineRangesM.size(); ++i) {
    if (distance_m >= kLineRangesM[i] && distance_m < kLineRangesM[i + 1]) return i;
  }
  return std::nullopt;
}

}  // namespace

void Tally::Add(const Tally& other) {
  shown += other.shown;
  found += other.found;
  absent += other.absent;
  false_finds += other.false_finds;
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
}

Tally TallyOf(const CourseSight& sight, const LabelledPicture& picture) {
  Tally tally;
  const msg::Sighting sighting = sight.sighting.value_or(NoSighting());  // nothing in a doubt
  if (!picture.there) {
    tally.absent = 1;
    // A code that is no word is seen, but not published.
    const bool is_false = picture.kind == CourseKind::kQr ? sight.text.has_value() : sighting.seen;
    tally.false_finds = is_false ? 1 : 0;
    return tally;
  }
  tally.shown = 1;
  if (!sighting.seen) return tally;
  const bool is_it = IsOver(BoxOf(sighting, picture.bgr.size()), picture.box) &&
                     (picture.text.empty() || sighting.text == picture.text);
  (is_it ? tally.found : tally.false_finds) = 1;
  if (is_it && std::isfinite(sighting.distance_m)) {
    tally.errors.push_back(double(sighting.distance_m) / picture.distance_m - 1);
  }
  return tally;
}

LineTallies TallyOfLines(const msg::YellowLines& lines, const LinesParameters& parameters,
                         const LabelledPicture& picture) {
  constexpr double kNearPx = 3, kNearM = 0.02, kOnLineM = 0.04;
  const cv::Size size = picture.bgr.size();
  const cv::Rect region = RectOf(parameters.region, size);
  std::map<int, double> reported;  // rows by columns
  for (std::size_t i = 0; i < lines.edge_x.size(); ++i) {
    reported[cvRound(double(lines.edge_x[i]) * size.width - 0.5)] =
        double(lines.edge_y[i]) * size.height - 0.5;
  }
  LineTallies tallies;
  for (int i = 0; i < parameters.edge_columns; ++i) {
    const int x = region.x + std::min(region.width - 1, static_cast<int>((i + 0.5) * region.width /
                                                                         parameters.edge_columns));
    const auto painted = PaintedEdge(picture, {double(x), region.y, region.br().y - 1});
    const auto range = painted ? RangeOf(picture, painted->at_m) : std::nullopt;
    if (range) (picture.there ? tallies[*range].shown : tallies[*range].absent) += 1;
    const auto edge = reported.find(x);
    if (edge == reported.end()) continue;
    const auto at = picture.GroundAt({double(x), edge->second});
    const bool on_a_line = picture.there && at && picture.lines->HasLine(*at, kOnLineM);
    if (!on_a_line) {
      const auto where = at ? RangeOf(picture, *at) : std::nullopt;
      if (where) tallies[*where].false_finds += 1;
      continue;
    }
    if (!range) continue;
    const double error_m = (*at - painted->at_m).norm();
    if (std::abs(edge->second - painted->y) > kNearPx && error_m > kNearM) continue;
    tallies[*range].found += 1;
    tallies[*range].errors.push_back(error_m);
  }
  return tallies;
}

std::vector<CourseEntry> ShippedDetectors() {
  const Parsed<VisionConfig> reading = ReadVisionFile(SourceDir() + "/config/vision/course.toml");
  if (!reading.config) throw std::runtime_error(FormatDiagnostic(reading.diagnostics.front()));
  return reading.config->detectors;
}

const CourseEntry& DetectorOf(const std::vector<CourseEntry>& entries, CourseKind kind,
                              std::size_t camera) {
  constexpr std::array<const char*, world::kCameras> kOfWalker{"front", "left", "right"};
  const auto entry = std::find_if(entries.begin(), entries.end(), [&](const CourseEntry& each) {
    return each.kind == kind && (kind != CourseKind::kLines || each.name == kOfWalker.at(camera));
  });
  if (entry == entries.end()) throw std::runtime_error("a detector is missing in the config");
  return *entry;
}

}  // namespace musher::vision
