#include "musher/modules/vision/course/line_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace musher::vision {
namespace {

constexpr std::size_t kMostPieces = 64;
constexpr int kSamples = 15;        // of a piece's width
constexpr double kShapeSteps = 24;  // of the grid on which a piece's shape is taken, each way
constexpr double kBlurPx = 2;       // by which a camera widens a line
constexpr double kSquint =
    M_SQRT2;  // the shorter of two perpendicular cuts is at most so much wider
// From a piece's middle to the axis of its line, at most: in widths of the line, or so much.
constexpr double kWidthsBeside = 1.5;
constexpr double kLeastBesideM = 0.05, kLeastBesidePx = 4;
// See Tint: of contrast around a piece, and on each side of it; and of the tint of the strongest
// piece, for paint is of one colour.
constexpr double kLeastOffFloor = 12, kLeastOffSide = 8, kLeastOfStrongest = 0.7;
// Between the ends of two pieces, at most: so much, or in the picture the length of the longer one.
constexpr double kMostGapM = 0.4;
constexpr double kMostTurn = 0.35;  // radians between the axes of two pieces

// The piece alone: 255 within its outline and in the mask.
cv::Mat Filled(const Contour& outline, const cv::Rect& box, const cv::Mat& mask) {
  cv::Mat filled = cv::Mat::zeros(box.size(), CV_8UC1);
  cv::drawContours(filled, std::vector<Contour>{outline}, 0, cv::Scalar(255), cv::FILLED,
                   cv::LINE_8, cv::noArray(), 0, -box.tl());
  cv::bitwise_and(filled, mask(box), filled);
  return filled;
}

// From a set pixel as far as the pixels beside it are set, along x (step 1, 0) or y.
struct Run {
  int from = 0;
  int to = 0;  // beyond the last one
  double middle() const { return (from + to - 1) / 2.0; }
};

Run RunThrough(const cv::Mat& filled, const cv::Point& at, bool along_x) {
  const auto set = [&](int i) {
    const cv::Point point = along_x ? cv::Point(i, at.y) : cv::Point(at.x, i);
    const int end = along_x ? filled.cols : filled.rows;
    return i >= 0 && i < end && filled.at<std::uint8_t>(point) != 0;
  };
  Run run{along_x ? at.x : at.y, (along_x ? at.x : at.y) + 1};
  while (set(run.from - 1)) --run.from;
  while (set(run.to)) ++run.to;
  return run;
}

// The widths of a piece where it is cut along x and along y through the same point.
class Widths {
 public:
  Widths(const cv::Mat& filled, const cv::Rect& box, const cv::Size& region, const Floor& floor)
      : filled_(filled), box_(box), region_(region), floor_(floor) {}

  // With what of it the camera's blur may be.
  struct Width {
    double m = 0;
    double blur_m = 0;
    bool clipped = false;  // the piece goes on beyond the region
  };
  // The narrowest first; none where the region cuts the piece off, or the ground is not known.
  std::vector<Width> Sorted() const {
    std::vector<Width> widths;
    for (int i = 0; i < kSamples; ++i) {
      const int y = (2 * i + 1) * box_.height / (2 * kSamples);
      std::vector<cv::Point> row;
      if (cv::countNonZero(filled_.row(y)) == 0) continue;
      cv::findNonZero(filled_.row(y), row);
      const cv::Point first(row[row.size() / 2].x, y);
      const Run across = RunThrough(filled_, first, true);
      const cv::Point at(static_cast<int>(across.middle()), y);
      const Run down = RunThrough(filled_, at, false);
      const auto one = CutX(across, y), other = CutY(down, at.x);
      if (!one || !other) continue;
      const Width& width = one->m < other->m ? *one : *other;
      if (!width.clipped) widths.push_back(width);
    }
    std::ranges::sort(widths, {}, &Width::m);
    return widths;
  }

 private:
  std::optional<Width> CutX(const Run& run, int y) const {
    const int from = box_.x + run.from, to = box_.x + run.to;
    return Between({double(from), box_.y + y + 0.5}, {double(to), box_.y + y + 0.5}, run,
                   from <= 0 || to >= region_.width);
  }

  std::optional<Width> CutY(const Run& run, int x) const {
    const int from = box_.y + run.from, to = box_.y + run.to;
    return Between({box_.x + x + 0.5, double(from)}, {box_.x + x + 0.5, double(to)}, run,
                   from <= 0 || to >= region_.height);
  }

  std::optional<Width> Between(const cv::Point2d& a, const cv::Point2d& b, const Run& run,
                               bool clipped) const {
    const auto one = floor_.At(a.x, a.y), other = floor_.At(b.x, b.y);
    if (!one || !other) return std::nullopt;
    const double width_m = cv::norm(*one - *other);
    return Width{width_m, width_m * std::min(1.0, kBlurPx / (run.to - run.from)), clipped};
  }

  const cv::Mat& filled_;
  const cv::Rect& box_;
  const cv::Size& region_;
  const Floor& floor_;
};

// The width that no line has; nothing: it may be one. A few cuts may be wider, where something
// touches the line.
std::optional<double> OddWidth(const std::vector<Widths::Width>& widths, const PieceRules& rules) {
  constexpr double kOfLine = 0.8;
  if (widths.empty()) return std::nullopt;
  const auto at = [&](double share) {
    return widths[static_cast<std::size_t>(share * static_cast<double>(widths.size() - 1))];
  };
  const Widths::Width middle = at(0.5), wide = at(kOfLine);
  if (middle.m + middle.blur_m < rules.least_width_m) return middle.m;
  if (wide.m - wide.blur_m > kSquint * rules.most_width_m) return wide.m;
  return std::nullopt;
}

// Points of the floor, whose spread is the shape of what they cover.
class Shape {
 public:
  void Add(const cv::Point2d& point, double weight) {
    n_ += weight;
    sum_ += weight * point;
    xx_ += weight * point.x * point.x;
    xy_ += weight * point.x * point.y;
    yy_ += weight * point.y * point.y;
  }
  void Add(const Shape& other) {
    n_ += other.n_;
    sum_ += other.sum_;
    xx_ += other.xx_;
    xy_ += other.xy_;
    yy_ += other.yy_;
  }

  void Describe(YellowLine& line) const {
    line.placed = n_ > 0;
    if (!line.placed) return;
    line.middle = sum_ / n_;
    const double a = xx_ / n_ - line.middle.x * line.middle.x;
    const double b = xy_ / n_ - line.middle.x * line.middle.y;
    const double c = yy_ / n_ - line.middle.y * line.middle.y;
    const double half = std::hypot((a - c) / 2, b);
    const double turn = std::atan2(2 * b, a - c) / 2;
    constexpr double kOfUniform = 12;  // the square of a length, in variances of what is even on it
    line.axis = {std::cos(turn), std::sin(turn)};
    line.length = std::sqrt(kOfUniform * std::max(0.0, (a + c) / 2 + half));
    line.width = std::sqrt(kOfUniform * std::max(0.0, (a + c) / 2 - half));
  }

 private:
  double n_ = 0;
  cv::Point2d sum_;
  double xx_ = 0, xy_ = 0, yy_ = 0;
};

int StepOf(int length_px) {
  return std::max(1, static_cast<int>(length_px / kShapeSteps));
}

Shape ShapeOf(const cv::Mat& filled, const cv::Rect& box, const Floor& floor) {
  const int step_x = StepOf(box.width), step_y = StepOf(box.height);
  Shape shape;
  for (int y = step_y / 2; y < box.height; y += step_y) {
    for (int x = step_x / 2; x < box.width; x += step_x) {
      if (filled.at<std::uint8_t>(y, x) == 0) continue;
      const auto point = floor.At(box.x + x + 0.5, box.y + y + 0.5);
      if (point) shape.Add(*point, double(step_x) * step_y);
    }
  }
  return shape;
}

// The direction of a colour from grey, in the a and b of Lab; 0 of a range that has grey in it.
cv::Vec2d DirectionOf(const HsvRange& color) {
  constexpr int kHues = 180, kGreyish = 20;
  if (color.from[1] < kGreyish) return {0, 0};
  const int wide = (color.to[0] - color.from[0] + kHues) % kHues;
  cv::Mat3b pixel(1, 1);
  pixel(0, 0) = {static_cast<std::uint8_t>((color.from[0] + wide / 2) % kHues), 255, 255};
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2BGR);
  cv::cvtColor(pixel, pixel, cv::COLOR_BGR2Lab);
  constexpr double kGrey = 128;
  return cv::normalize(cv::Vec2d(pixel(0, 0)[1] - kGrey, pixel(0, 0)[2] - kGrey));
}

// The colour of a piece beside that of the floor around it, brightness aside.
struct Tint {
  double tint = 0;  // the piece's own: how much of its colour it has, for its brightness
  // How much more of its colour it has than what is around it, and than the one of its two sides
  // that has more: in OpenCV's Lab, 0 to 255.
  double contrast = 0, least_contrast = 0;
  bool is_rim = false;  // one side is bright and one dark, and the piece between them
};

struct Side {
  cv::Vec3d sum;
  int count = 0;
  cv::Vec3d mean() const { return sum / std::max(1, count); }
};

// The pixels of `around` on either side of the piece's axis in the picture.
std::array<Side, 2> SidesOf(const cv::Mat& lab, const cv::Mat& piece, const cv::Mat& around) {
  const cv::Moments moments = cv::moments(piece, true);
  const double x = moments.m10 / moments.m00, y = moments.m01 / moments.m00;
  const double turn = std::atan2(2 * moments.mu11, moments.mu20 - moments.mu02) / 2;
  const double aside_x = -std::sin(turn), aside_y = std::cos(turn);
  std::array<Side, 2> sides;
  for (int row = 0; row < lab.rows; ++row) {
    const auto* in = around.ptr<std::uint8_t>(row);
    const auto* color = lab.ptr<cv::Vec3b>(row);
    for (int column = 0; column < lab.cols; ++column) {
      if (in[column] == 0) continue;
      Side& side = sides.at((column - x) * aside_x + (row - y) * aside_y < 0 ? 0 : 1);
      side.sum += cv::Vec3d(color[column]);
      ++side.count;
    }
  }
  return sides;
}

// Nothing where there is not enough around it.
std::optional<Tint> TintOf(const cv::Mat& bgr, const cv::Mat& mask, const cv::Mat& filled,
                           const cv::Rect& box, const HsvRange& color) {
  constexpr int kAroundPx = 7, kFromPx = 3, kLeastPx = 30;
  const cv::Vec2d direction = DirectionOf(color);
  if (direction == cv::Vec2d(0, 0)) return std::nullopt;
  const cv::Rect around = cv::Rect(box.x - kAroundPx, box.y - kAroundPx, box.width + 2 * kAroundPx,
                                   box.height + 2 * kAroundPx) &
                          cv::Rect({0, 0}, bgr.size());
  cv::Mat piece = cv::Mat::zeros(around.size(), CV_8UC1), near, far, lab;
  filled.copyTo(piece(box - around.tl()));
  const auto grown = [&](int px, cv::Mat& by) {
    cv::dilate(piece, by, cv::getStructuringElement(cv::MORPH_RECT, {2 * px + 1, 2 * px + 1}));
  };
  grown(kFromPx, near);
  grown(kAroundPx, far);
  far.setTo(0, near);
  far.setTo(0, mask(around));
  if (cv::countNonZero(far) < kLeastPx) return std::nullopt;
  cv::cvtColor(bgr(around), lab, cv::COLOR_BGR2Lab);

  const cv::Scalar own = cv::mean(lab, piece);
  const auto off = [&](const cv::Vec3d& from) {
    return direction.dot({own[1] - from[1], own[2] - from[2]});
  };
  constexpr double kGrey = 128, kDark = 20;
  Tint tint;
  tint.tint = off({0, kGrey, kGrey}) / std::max(kDark, own[0]);
  const std::array<Side, 2> sides = SidesOf(lab, piece, far);
  tint.contrast = off((sides[0].sum + sides[1].sum) / (sides[0].count + sides[1].count));
  tint.least_contrast = tint.contrast;
  if (std::min(sides[0].count, sides[1].count) < kLeastPx / 2) return tint;
  const cv::Vec3d one = sides[0].mean(), other = sides[1].mean();
  tint.least_contrast = std::min(off(one), off(other));
  constexpr double kApart = 40, kNearly = 10;  // of brightness
  const double dark = std::min(one[0], other[0]), bright = std::max(one[0], other[0]);
  tint.is_rim = bright - dark > kApart && own[0] > dark + kNearly && own[0] < bright + kNearly;
  return tint;
}

// Of the ground that the pixels show.
double AreaM2(const cv::Mat& filled, const cv::Rect& box, const Floor& floor) {
  const int step_x = StepOf(box.width), step_y = StepOf(box.height);
  double area_m2 = 0;
  for (int y = step_y / 2; y < box.height; y += step_y) {
    for (int x = step_x / 2; x < box.width; x += step_x) {
      if (filled.at<std::uint8_t>(y, x) == 0) continue;
      const auto at = floor.At(box.x + x, box.y + y), right = floor.At(box.x + x + 1, box.y + y),
                 down = floor.At(box.x + x, box.y + y + 1);
      if (!at || !right || !down) continue;
      area_m2 += std::abs((*right - *at).cross(*down - *at)) * step_x * step_y;
    }
  }
  return area_m2;
}

// Why an outline is no line; empty: it is one. `line`: its shape, `tint`: its colour. Where the
// cuts are too wide they may be aslant, both of them, at the edge of a fisheye: then its area by
// its length is the width.
std::string WhyOdd(const cv::Size& region, const cv::Mat& filled, const cv::Rect& box,
                   const YellowLine& line, const std::optional<Tint>& tint, const Floor& floor,
                   const PieceRules& rules) {
  if (floor.in_metres()) {
    auto width = OddWidth(Widths(filled, box, region, floor).Sorted(), rules);
    if (width && *width > rules.most_width_m && line.placed && line.length > 0) {
      const double by_area_m = AreaM2(filled, box, floor) / line.length;
      if (by_area_m <= kSquint * rules.most_width_m) width.reset();
    }
    if (width) {
      char text[16];
      std::snprintf(text, sizeof text, "%.2f", *width);
      return std::string("is ") + text + " m wide, which no line is";
    }
  }
  if (!tint) return "";
  if (tint->contrast < kLeastOffFloor || tint->least_contrast < kLeastOffSide) {
    return "does not stand out from the floor";
  }
  return tint->is_rim ? "is between a bright and a dark floor, as the rim of a lamp's light is"
                      : "";
}

struct Piece {
  YellowLine line;
  Shape shape;
  std::optional<double> tint{};
};

// What is much paler than the strongest piece is none of its lines. Returns its area.
double RemovePale(std::vector<Piece>& pieces) {
  double strongest = 0;
  for (const Piece& piece : pieces) strongest = std::max(strongest, piece.tint.value_or(0));
  double area_px2 = 0;
  std::erase_if(pieces, [&](const Piece& piece) {
    const bool is_pale = piece.tint && *piece.tint < kLeastOfStrongest * strongest;
    if (is_pale) area_px2 += piece.line.area_px2;
    return is_pale;
  });
  return area_px2;
}

double Beside(const YellowLine& line, const cv::Point2d& point) {
  const cv::Point2d off = point - line.middle;
  return std::abs(off.x * line.axis.y - off.y * line.axis.x);
}

// Along the axis of the first, between its end and that of the other.
double Along(const YellowLine& line, const YellowLine& piece) {
  const double apart = std::abs((piece.middle - line.middle).dot(line.axis));
  const double half = piece.has_axis() ? piece.length / 2 : 0;
  return apart - line.length / 2 - half;
}

bool IsPartOf(const YellowLine& line, const YellowLine& piece, bool in_metres) {
  if (!line.has_axis() || !piece.placed) return false;
  const double least_beside = in_metres ? kLeastBesideM : kLeastBesidePx;
  if (Along(line, piece) > (in_metres ? kMostGapM : line.length)) return false;
  if (Beside(line, piece.middle) > std::max(kWidthsBeside * line.width, least_beside)) return false;
  // The end of a piece that the region cuts off is wider than long.
  const bool turns = piece.has_axis() && piece.length > kWidthsBeside * line.width;
  return !turns || std::abs(line.axis.dot(piece.axis)) >= std::cos(kMostTurn);
}

void Join(Piece& line, const Piece& piece) {
  YellowLine& joined = line.line;
  const double area_px2 = joined.area_px2 + piece.line.area_px2;
  joined.centroid =
      (joined.centroid * joined.area_px2 + piece.line.centroid * piece.line.area_px2) / area_px2;
  joined.area_px2 = area_px2;
  joined.box |= piece.line.box;
  joined.pieces.insert(joined.pieces.end(), piece.line.pieces.begin(), piece.line.pieces.end());
  line.shape.Add(piece.shape);
  line.shape.Describe(joined);
}

// The longest first, so that a short piece finds its line.
std::vector<Piece> Joined(std::vector<Piece> pieces, bool in_metres) {
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& one, const Piece& other) {
    return one.line.length > other.line.length;
  });
  std::vector<Piece> lines;
  for (Piece& piece : pieces) {
    const auto line = std::find_if(lines.begin(), lines.end(), [&](const Piece& each) {
      return IsPartOf(each.line, piece.line, in_metres);
    });
    if (line == lines.end()) {
      lines.push_back(std::move(piece));
    } else {
      Join(*line, piece);
    }
  }
  return lines;
}

// Not farther along the axis than the line is long: beyond it may bend.
cv::Point2d PlaceOf(const YellowLine& line, const Floor& floor, double row) {
  constexpr int kSteps = 60;
  if (!line.leads_away) return line.centroid;
  cv::Point2d best = line.centroid;
  double nearest = std::abs(line.centroid.y - row);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const auto seen = floor.Seen(line.middle + line.length * i / kSteps * line.axis);
    if (!seen || std::abs(seen->y - row) >= nearest) continue;
    nearest = std::abs(seen->y - row);
    best = *seen;
  }
  return best;
}

bool Larger(const Piece& one, const Piece& other) {
  return one.line.area_px2 > other.line.area_px2;
}

}  // namespace

std::optional<cv::Point2d> Floor::At(double x, double y) const {
  if (!mount_) return cv::Point2d(x, y);
  const auto point =
      navigation::OnGround(mount_->camera, mount_->trunk_height_m, kFarthestM,
                           (region_.x + x) / picture_.width, (region_.y + y) / picture_.height);
  if (!point) return std::nullopt;
  return cv::Point2d(point->x_m, point->y_m);
}

double Floor::Across(const cv::Point2d& way) const {
  if (!mount_) return 0;
  const double yaw_rad = mount_->camera.yaw_rad;
  return std::abs(way.dot({-std::sin(yaw_rad), std::cos(yaw_rad)}));
}

bool Floor::LeadsAway(const cv::Point2d& direction) const {
  constexpr double kHalf = M_SQRT1_2;  // of a right angle
  return mount_ && Across(direction) <= kHalf;
}

std::optional<cv::Point2d> Floor::Seen(const cv::Point2d& on_floor) const {
  if (!mount_) return on_floor;
  const auto share =
      navigation::ShareOf(mount_->camera, mount_->trunk_height_m, {on_floor.x, on_floor.y});
  if (!share) return std::nullopt;
  return cv::Point2d((*share)[0] * picture_.width - region_.x,
                     (*share)[1] * picture_.height - region_.y);
}

std::optional<double> Gap(const YellowLine& one, const YellowLine& other, const Floor& floor) {
  const YellowLine& longer = one.length >= other.length ? one : other;
  const YellowLine& shorter = &longer == &one ? other : one;
  if (!longer.placed || !shorter.placed) return std::nullopt;
  return longer.has_axis() ? Beside(longer, shorter.middle)
                           : floor.Across(longer.middle - shorter.middle);
}

LinesOnFloor LinesOf(const cv::Mat& bgr, const cv::Mat& mask, const Floor& floor,
                     const PieceRules& rules) {
  LinesOnFloor found;
  std::vector<Piece> pieces;
  double odd_area_px2 = 0;
  for (Contour& outline : OutlinesOf(mask)) {
    const cv::Moments moments = cv::moments(outline);
    if (moments.m00 <= 0 || moments.m00 < rules.least_area_px2) continue;
    const cv::Rect box = cv::boundingRect(outline);
    if (box.width < rules.least_length * box.height) continue;
    const cv::Mat filled = Filled(outline, box, mask);
    Piece piece{{}, ShapeOf(filled, box, floor)};
    piece.shape.Describe(piece.line);
    const auto tint = TintOf(bgr, mask, filled, box, rules.color);
    if (tint) piece.tint = tint->tint;
    if (std::string odd = WhyOdd(mask.size(), filled, box, piece.line, tint, floor, rules);
        !odd.empty()) {
      if (moments.m00 > odd_area_px2) found.odd = std::move(odd);
      odd_area_px2 = std::max(odd_area_px2, moments.m00);
      found.odd_area_px2 += moments.m00;
      continue;
    }
    piece.line.area_px2 = moments.m00;
    piece.line.centroid = {moments.m10 / moments.m00, moments.m01 / moments.m00};
    piece.line.box = box;
    piece.line.pieces.push_back(std::move(outline));
    pieces.push_back(std::move(piece));
  }
  found.odd_area_px2 += RemovePale(pieces);
  std::stable_sort(pieces.begin(), pieces.end(), Larger);
  if (pieces.size() > kMostPieces) pieces.resize(kMostPieces);
  std::vector<Piece> lines = Joined(std::move(pieces), floor.in_metres());
  std::stable_sort(lines.begin(), lines.end(), Larger);
  for (Piece& line : lines) {
    const bool has_axis = floor.in_metres() && line.line.has_axis();
    line.line.leads_away = has_axis && floor.LeadsAway(line.line.axis);
    line.line.lies_across =
        has_axis && !line.line.leads_away && line.line.length > 2 * rules.most_width_m;
    line.line.place = PlaceOf(line.line, floor, (mask.rows - 1) / 2.0);
    found.lines.push_back(std::move(line.line));
  }
  return found;
}

}  // namespace musher::vision
