#include "musher/modules/vision/course/lines_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>

#include "musher/modules/vision/course/floor_color.hpp"

namespace musher::vision {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

// Of the lane's width: two lines nearer to each other are one, and those farther apart are of two
// lanes; one that is farther from the centre may be another lane's.
constexpr double kLeastGap = 0.6, kMostGap = 1.35, kFarthest = 0.95;
// By so much of its width lanes of one hall differ.
constexpr double kLaneWidthKnown = 0.05;

PieceRules RulesOf(const LinesParameters& parameters) {
  return {parameters.yellow, parameters.least_area_px2, parameters.least_length,
          parameters.least_width_m, parameters.most_width_m};
}

// Where the middle of the lane is, from its place in the region.
class Middle {
 public:
  Middle(const std::vector<YellowLine>& lines, int width, const Floor& floor,
         const LinesParameters& parameters)
      : width_(width),
        // Of the middles of pixels: (width - 1) / 2 is that of the region.
        center_x_((width - 1) / 2.0 + (parameters.ycy_center - 0.5) * width),
        floor_(floor),
        parameters_(parameters) {
    Choose(lines);
    if (parameters_.along && floor_.in_metres()) {
      ChooseLane(lines);
      return;
    }
    if (left_ != right_ && !AreOfOneLane(*left_, *right_)) left_ = right_ = Nearer(*left_, *right_);
    if (left_ == right_) LookBeside(*left_);
    if (IsShapeless(*left_) || IsShapeless(*right_)) {
      doubt_ = "what has the colour of the lines has not the shape of one";
    }
  }

  double offset() const { return (middle_x() - center_x_) / width_; }
  // Two lines, as far apart as those of a lane: hardly by chance.
  bool is_pair() const {
    return left_ != right_ && floor_.in_metres() && !left_->lies_across && !right_->lies_across &&
           Gap(*left_, *right_, floor_).has_value();
  }
  // By so much the middle may be wrong, across the lane; nothing where the ground is not known, and
  // of lines that do not lead along a lane.
  std::optional<double> UncertaintyM() const {
    if (!left_->leads_away || !right_->leads_away) return std::nullopt;
    const auto one = UncertaintyM(*left_), other = UncertaintyM(*right_);
    if (!one || !other) return std::nullopt;
    if (left_ == right_) {
      if (!beside_px_) return std::nullopt;
      return std::hypot(*one, kLaneWidthKnown * parameters_.lane_m / 2);
    }
    const auto gap_m = Gap(*left_, *right_, floor_);
    const double odd_m = gap_m ? std::abs(*gap_m - parameters_.lane_m) / 2 : 0;
    return std::hypot(std::hypot(*one, *other) / 2, odd_m);
  }
  // From its place to the middle, to the right in the picture.
  std::optional<double> OffsetM() const {
    const double y = (left_->place.y + right_->place.y) / 2;
    const auto middle = floor_.At(middle_x(), y), center = floor_.At(center_x_, y);
    if (!floor_.in_metres() || !middle || !center) return std::nullopt;
    const double way_m = cv::norm(*middle - *center);
    return middle_x() < center_x_ ? -way_m : way_m;
  }
  bool is_of_one() const { return left_ == right_ && !beside_px_; }
  const std::string& doubt() const { return doubt_; }

 private:
  std::optional<double> UncertaintyM(const YellowLine& line) const {
    constexpr double kBlurPx = 1.5, kOfWidth = 0.25;
    const auto at = floor_.At(line.place.x, line.place.y);
    const auto beside = floor_.At(line.place.x + 1, line.place.y);
    if (!at || !beside) return std::nullopt;
    const double continued = cv::norm(*at - line.middle) / line.length;
    return std::hypot(kBlurPx * cv::norm(*beside - *at),
                      kOfWidth * line.width * (1 + 2 * continued));
  }

  // Between the lines of a lane along which it looks, one that lies across bounds nothing.
  void Choose(const std::vector<YellowLine>& lines) {
    const YellowLine *inner_left = nullptr, *inner_right = nullptr;
    const YellowLine* along = OneOfALane(lines);
    left_ = right_ = along != nullptr ? along : &lines.front();
    for (const YellowLine& line : lines) {
      if (along != nullptr && line.lies_across) continue;
      const double x = line.place.x;
      if (x < left_->place.x) left_ = &line;
      if (x > right_->place.x) right_ = &line;
      if (x <= center_x_ && (inner_left == nullptr || x > inner_left->place.x)) inner_left = &line;
      if (x >= center_x_ && (inner_right == nullptr || x < inner_right->place.x))
        inner_right = &line;
    }
    if (parameters_.ycy_pair != LanePair::kInnermost) return;
    if (inner_left == nullptr || inner_right == nullptr) return;
    left_ = inner_left;
    right_ = inner_right;
  }

  bool IsLane(const YellowLine& one, const YellowLine& other) const {
    constexpr double kMostOff = 0.2;  // of the lane's width
    const auto gap_m = Gap(one, other, floor_);
    return gap_m && std::abs(*gap_m - parameters_.lane_m) <= kMostOff * parameters_.lane_m;
  }

  // Of two that lead away, as far apart as those of a lane; null: no two do.
  const YellowLine* OneOfALane(const std::vector<YellowLine>& lines) const {
    if (!floor_.in_metres()) return nullptr;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        if (lines[i].leads_away && lines[j].leads_away && IsLane(lines[i], lines[j])) {
          return &lines[i];
        }
      }
    }
    return nullptr;
  }

  // Of lines that all lead away: two as far apart as those of a lane, the nearest to the centre.
  void ChooseLane(const std::vector<YellowLine>& lines) {
    std::optional<double> nearest;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        if (!IsLane(lines[i], lines[j])) continue;
        const double off = std::abs((lines[i].place.x + lines[j].place.x) / 2 - center_x_);
        if (nearest && off >= *nearest) continue;
        nearest = off;
        const bool in_order = lines[i].place.x < lines[j].place.x;
        left_ = &lines[in_order ? i : j];
        right_ = &lines[in_order ? j : i];
      }
    }
    if (!nearest) doubt_ = "no two of the lines are as far apart as those of a lane";
  }

  // Nearly as wide as long, and wider than a line: glare or dirt touches it, or it is none.
  bool IsShapeless(const YellowLine& line) const {
    return floor_.in_metres() && line.placed && !line.has_axis() &&
           line.width > 2 * parameters_.most_width_m;
  }

  // True where it is not known. Neither one line that is seen twice, nor lines of two lanes.
  bool AreOfOneLane(const YellowLine& one, const YellowLine& other) const {
    if (!floor_.in_metres() || one.lies_across || other.lies_across) return true;
    const auto gap_m = Gap(one, other, floor_);
    return !gap_m ||
           (*gap_m >= kLeastGap * parameters_.lane_m && *gap_m <= kMostGap * parameters_.lane_m);
  }

  const YellowLine* Nearer(const YellowLine& one, const YellowLine& other) const {
    const auto off = [&](const YellowLine& line) { return std::abs(line.place.x - center_x_); };
    return off(one) <= off(other) ? &one : &other;
  }

  // Where the other line of the lane would be seen, from the only one.
  void LookBeside(const YellowLine& line) {
    if (!floor_.in_metres() || line.lies_across) return;
    const cv::Point2d& at = line.place;
    const auto here = floor_.At(at.x, at.y), center = floor_.At(center_x_, at.y);
    const auto aside = Aside(line);
    if (!here || !center || !aside) return;
    if (std::abs((*here - *center).dot(*aside)) > kFarthest * parameters_.lane_m) {
      doubt_ =
          "the only line is farther from the middle than a lane is wide: it may be of another lane";
    }
    const double side = at.x < center_x_ ? parameters_.lane_m : -parameters_.lane_m;
    const auto other = floor_.Seen(*here + side * *aside);
    const auto middle = floor_.Seen(*here + side / 2 * *aside);
    // As the middle of two lines is found: between their places in the picture.
    if (other) {
      beside_px_ = (other->x - at.x) / 2;
    } else if (middle) {
      beside_px_ = middle->x - at.x;
    }
  }

  // Across the line, to the right in the picture; of length 1, on the floor.
  std::optional<cv::Point2d> Aside(const YellowLine& line) const {
    constexpr double kStepPx = 4;
    // Towards the centre: beyond the line the picture may end.
    const double to_left = line.place.x < center_x_ ? 0 : kStepPx, to_right_px = kStepPx - to_left;
    const auto left = floor_.At(line.place.x - to_left, line.place.y);
    const auto right = floor_.At(line.place.x + to_right_px, line.place.y);
    if (!left || !right) return std::nullopt;
    const cv::Point2d to_right = (*right - *left) / cv::norm(*right - *left);
    if (!line.has_axis()) return to_right;
    const cv::Point2d across(-line.axis.y, line.axis.x);
    return across.dot(to_right) < 0 ? -across : across;
  }

  double middle_x() const {
    return (left_->place.x + right_->place.x) / 2 + beside_px_.value_or(0);
  }

  const int width_;
  const double center_x_;
  const Floor& floor_;
  const LinesParameters& parameters_;
  const YellowLine* left_ = nullptr;
  const YellowLine* right_ = nullptr;  // the same: there is one
  std::optional<double> beside_px_;    // of the middle, from the only line
  std::string doubt_;
};

std::string Ycy(const Middle& middle, double threshold) {
  const double offset = middle.offset();
  if (middle.is_of_one()) return offset < 0 ? "left" : offset > 0 ? "right" : "center";
  if (offset > threshold) return "left";
  return offset < -threshold ? "right" : "center";
}

std::string Dy(double line_offset, double threshold) {
  if (line_offset < -threshold) return "front";
  return line_offset > threshold ? "back" : "center";
}

// The lowest pixel of the lines in each of some columns.
void AddEdge(const cv::Mat& mask, const std::vector<YellowLine>& lines, const cv::Rect& region,
             const cv::Size& picture, int columns, msg::YellowLines& message) {
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  for (const YellowLine& line : lines) {
    cv::drawContours(filled, line.pieces, -1, cv::Scalar(255), cv::FILLED);
  }
  for (int i = 0; i < columns; ++i) {
    const int x = std::min(mask.cols - 1, static_cast<int>((i + 0.5) * mask.cols / columns));
    int y = mask.rows - 1;
    while (y >= 0 && !(filled.at<std::uint8_t>(y, x) && mask.at<std::uint8_t>(y, x))) --y;
    if (y < 0) continue;
    message.edge_x.push_back(static_cast<float>((region.x + x + 0.5) / picture.width));
    message.edge_y.push_back(static_cast<float>((region.y + y + 0.5) / picture.height));
  }
}

// The words and numbers of the line that is nearest to the vertical centre line.
void AddNearest(const std::vector<YellowLine>& lines, const cv::Rect& region, int picture_rows,
                const LinesParameters& parameters, msg::YellowLines& message) {
  const double center_x = (region.width - 1) / 2.0;
  const auto nearest =
      std::min_element(lines.begin(), lines.end(), [&](const auto& one, const auto& other) {
        return std::abs(one.centroid.x - center_x) < std::abs(other.centroid.x - center_x);
      });
  const double line_offset = (nearest->centroid.y + 0.5) / region.height - parameters.dy_target;
  message.line_offset = static_cast<float>(line_offset);
  message.dy = Dy(line_offset, parameters.dy_threshold);
  const double gap_px = picture_rows - (region.y + nearest->box.y + nearest->box.height);
  message.bottom_gap_px = static_cast<float>(gap_px);
  if (gap_px < parameters.walk_bottom_px) {
    message.walk = "back";
  } else if (std::abs(nearest->centroid.x - center_x) > parameters.walk_x_px) {
    message.walk = "front";
  }
}

// The ground from the region's upper edge down to the robot, at a quarter of its size.
cv::Mat FloorSample(const cv::Mat& bgr, const cv::Rect& region) {
  constexpr double kScale = 0.25;
  cv::Mat below = bgr.rowRange(region.y, bgr.rows);
  if (std::min(below.rows, below.cols) * kScale < 1) return below;
  cv::Mat sample;
  cv::resize(below, sample, {}, kScale, kScale, cv::INTER_NEAREST);
  return sample;
}

}  // namespace

LinesFound FindLines(const cv::Mat& bgr, const LinesParameters& parameters) {
  CheckCoursePicture(bgr);
  const cv::Rect region = RectOf(parameters.region, bgr.size());
  LineMask seen = MaskOfLines(bgr(region), parameters.yellow, parameters.most_coverage,
                              FloorSample(bgr, region));
  constexpr int kKernelPx = 3;
  CleanMask(seen.mask, kKernelPx, kKernelPx);
  const Floor floor(parameters.mount, region, bgr.size());
  LinesOnFloor on_floor = LinesOf(bgr(region), seen.mask, floor, RulesOf(parameters));
  std::vector<YellowLine>& lines = on_floor.lines;
  const bool found_any = !lines.empty();
  if (parameters.along && floor.in_metres()) {
    std::erase_if(lines, [](const YellowLine& line) { return !line.leads_away; });
  }
  const auto most = static_cast<std::size_t>(std::max(0, parameters.most_lines));
  if (lines.size() > most) lines.resize(most);

  LinesFound found;
  msg::YellowLines& message = found.lines;
  message.contours = static_cast<std::uint32_t>(lines.size());
  message.ycy = message.dy = message.walk = "center";
  message.middle_offset = message.line_offset = message.bottom_gap_px = kUnknown;
  message.doubt = seen.doubt;
  if (lines.empty() && !on_floor.odd.empty()) {
    message.doubt = "what has the colour of the lines " + on_floor.odd;
  }
  if (lines.empty() && found_any) message.doubt = "no line leads away from the camera";
  if (lines.empty()) return found;

  const Middle middle(lines, region.width, floor, parameters);
  message.middle_offset = static_cast<float>(middle.offset());
  message.doubt = middle.doubt();
  for (const YellowLine& line : lines) message.area_px2 += static_cast<float>(line.area_px2);
  // Where most of it is none, what is left is by chance as wide as a line.
  const bool little = on_floor.odd_area_px2 > double(message.area_px2);
  if (message.doubt.empty() && little && !middle.is_pair()) {
    message.doubt = "most of what has the colour of the lines is none";
  }
  const auto uncertainty_m = middle.UncertaintyM();
  if (message.doubt.empty()) message.ycy = Ycy(middle, parameters.ycy_threshold);
  const auto middle_m = middle.OffsetM();
  if (uncertainty_m && middle_m) {
    message.middle_m = static_cast<float>(*middle_m);
    message.uncertainty_m = static_cast<float>(*uncertainty_m);
  }
  AddNearest(lines, region, bgr.rows, parameters, message);
  AddEdge(seen.mask, lines, region, bgr.size(), parameters.edge_columns, message);
  for (YellowLine& line : lines) {
    for (Contour& piece : line.pieces) {
      for (cv::Point& point : piece) point += region.tl();
      found.outlines.push_back(std::move(piece));
    }
  }
  return found;
}

}  // namespace musher::vision
