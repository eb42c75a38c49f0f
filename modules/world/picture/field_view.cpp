#include "musher/modules/world/picture/field_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/marks.hpp"
#include "musher/modules/world/picture/strip_chart.hpp"

namespace musher::world {
namespace {

using Eigen::Rotation2Dd;
using Eigen::Vector2d;

constexpr Color kLowPlatform{228, 234, 220};
constexpr Color kHighPlatform{92, 128, 84};
constexpr Color kWayBlue{24, 88, 190};
constexpr Color kUpGreen{16, 120, 60};
constexpr Color kDownOrange{214, 104, 16};
constexpr Color kTakenPurple{140, 40, 150};
constexpr Color kGroundBrown{150, 132, 96};
constexpr std::array<Color, 3> kKfsColors{{{236, 196, 60}, {232, 120, 40}, {150, 150, 156}}};
constexpr double kFieldLetters = 12;
constexpr double kSmallLetters = 10;

double HighestMm(const FieldSpec& field) {
  return std::max(*std::max_element(field.heights_mm.begin(), field.heights_mm.end()), 1.0);
}

Color ColorOfPlatform(const FieldSpec& field, double height_mm) {
  if (height_mm <= 0) return kLowPlatform;
  return Mix(kLowPlatform, kHighPlatform, 0.15 + 0.85 * height_mm / HighestMm(field));
}

Color ColorOfBox(KfsKind kind) {
  return kKfsColors.at(static_cast<std::size_t>(kind));
}

std::string WholeText(double value) {
  return std::to_string(std::lround(value));
}

void Triangle(const Pixel& middle, double half, bool up, const Color& color, Canvas& canvas) {
  const double tip = up ? -half : half;
  const std::vector<Pixel> corners{middle + Pixel(0, tip), middle + Pixel(-half, -tip),
                                   middle + Pixel(half, -tip)};
  canvas.Fill(corners, color);
  canvas.Outline(corners, kPaper, 1);
}

void CrossOut(const Pixel& middle, double half, double width, Canvas& canvas) {
  canvas.Line(middle - Pixel(half, half), middle + Pixel(half, half), kBumpRed, width);
  canvas.Line(middle + Pixel(-half, half), middle + Pixel(half, -half), kBumpRed, width);
}

// On a paper background, so that the way below does not hide it.
void Tag(const std::string& text, const Pixel& at, const Color& color, Align align,
         Canvas& canvas) {
  const double width = canvas.TextWidth(text, kSmallLetters);
  const double left = align == Align::kCenter ? -width / 2 : 0;
  canvas.FillRect(at + Pixel(left - 2, -kSmallLetters), at + Pixel(left + width + 2, 3), kPaper);
  canvas.Text(text, at, kSmallLetters, color, align);
}

class FieldView {
 public:
  FieldView(const World& world, const ToPixel& at, double scale, Canvas& canvas)
      : field_(*world.field()), spec_(field_.spec()), at_(at), scale_(scale), canvas_(canvas) {}

  void Draw() {
    for (int row = 0; row < spec_.rows; ++row) {
      for (int col = 0; col < spec_.cols; ++col) DrawCell({row, col});
    }
    for (std::size_t i = 0; i < field_.boxes().size(); ++i) DrawBox(i);
    std::vector<Pixel> way;
    for (const FieldSample& sample : field_.way()) way.push_back(at_(sample.position_m));
    way.push_back(at_(field_.robot().position_m()));
    canvas_.Polyline(way, kWayBlue, 3);
    canvas_.Ring(way.front(), 6, kWayBlue, 2.5);
    DrawRobot();
    for (const FieldEvent& event : field_.events()) DrawEvent(event);
  }

 private:
  void DrawCell(const FieldCell& cell) {
    const Vector2d half = Vector2d::Constant(spec_.cell_m / 2);
    const Vector2d middle = spec_.CentreOf(cell);
    const Pixel low = at_(middle - half);
    const Pixel high = at_(middle + half);
    const Color color = ColorOfPlatform(spec_, spec_.HeightMm(cell));
    canvas_.FillRect({low.x(), high.y()}, {high.x(), low.y()}, color);
    canvas_.Outline({low, {high.x(), low.y()}, high, {low.x(), high.y()}}, kPaper, 2);
    canvas_.Text(WholeText(spec_.HeightMm(cell)), {low.x() + 6, high.y() + 18}, 15, InkOn(color));
    canvas_.Text(std::to_string(cell.row) + ", " + std::to_string(cell.col),
                 {high.x() - 6, low.y() - 6}, kSmallLetters, InkOn(color), Align::kRight);
  }

  // Hollow where it was taken away.
  void DrawBox(std::size_t index) {
    const KfsSpec& spec = spec_.boxes[index];
    const Color color = ColorOfBox(spec.kind);
    const double half = kKfsSizeM / 2 * scale_;
    const Pixel middle = at_(spec_.CentreOf(spec.cell));
    const std::vector<Pixel> corners{middle + Pixel(-half, -half), middle + Pixel(half, -half),
                                     middle + Pixel(half, half), middle + Pixel(-half, half)};
    const bool here = field_.boxes()[index].where == KfsBox::Where::kField;
    if (here) canvas_.Fill(corners, color);
    canvas_.Outline(corners, here ? Mix(color, kInk, 0.5) : color, here ? 1.5 : 2.5);
    Tag(spec.name, middle + Pixel(0, half + 13), kInk, Align::kCenter, canvas_);
  }

  void DrawRobot() {
    const LiftBody& robot = field_.robot();
    const Rotation2Dd turn(robot.yaw_rad());
    const auto point = [&](double x, double y) {
      return at_(robot.position_m() + turn * Vector2d(x, y));
    };
    canvas_.Outline({point(0.3, 0.3), point(0.3, -0.3), point(-0.3, -0.3), point(-0.3, 0.3)},
                    robot.fallen() ? kBumpRed : kInk, 2.5);
    for (const double x : {-kLiftWheelM, kLiftWheelM}) {
      for (const double y : {-kLiftWheelM, kLiftWheelM}) canvas_.Disc(point(x, y), 3.5, kInk);
    }
    canvas_.Line(point(0, 0), point(0.3, 0), kInk, 2.5);
    canvas_.Disc(point(0, 0), 3, kInk);
  }

  void DrawEvent(const FieldEvent& event) {
    const Pixel middle = at_(event.where_m);
    switch (event.kind) {
      case FieldEvent::Kind::kUp:
      case FieldEvent::Kind::kDown: {
        const bool up = event.kind == FieldEvent::Kind::kUp;
        const Color color = up ? kUpGreen : kDownOrange;
        Triangle(middle, 7, up, color, canvas_);
        Tag((up ? "+" : "\u2212") + event.text, middle + Pixel(11, 4), color, Align::kLeft,
            canvas_);
        break;
      }
      case FieldEvent::Kind::kTaken:
        canvas_.Disc(middle, 5, kTakenPurple);
        canvas_.Ring(middle, 5, kPaper, 1);
        Tag("takes " + event.text, middle + Pixel(0, -10), kTakenPurple, Align::kCenter, canvas_);
        break;
      case FieldEvent::Kind::kPlaced:
      case FieldEvent::Kind::kDocked:
        Mark(event, middle);
        break;
      case FieldEvent::Kind::kBump:
        CrossOut(middle, 5, 2, canvas_);
        break;
      case FieldEvent::Kind::kFall:
        CrossOut(middle, 12, 4, canvas_);
        break;
      case FieldEvent::Kind::kReady:
        break;
    }
  }

  // Several at one place stand below each other.
  void Mark(const FieldEvent& event, const Pixel& middle) {
    const bool docked = event.kind == FieldEvent::Kind::kDocked;
    marks_ = (middle - last_mark_).norm() < 30 ? marks_ + 1 : 0;
    last_mark_ = middle;
    canvas_.Ring(middle, 8, kTakenPurple, 2);
    Tag(docked ? "docks with R1" : "places " + event.text, middle + Pixel(0, 24 + 14 * marks_),
        kTakenPurple, Align::kCenter, canvas_);
  }

  const Field& field_;
  const FieldSpec& spec_;
  const ToPixel& at_;
  double scale_;
  Canvas& canvas_;
  Pixel last_mark_{-1000, -1000};
  int marks_ = 0;
};

// Downwards, row by row.
class FieldLegend {
 public:
  FieldLegend(const World& world, const Pixel& corner, Canvas& canvas)
      : field_(*world.field()), at_(corner), canvas_(canvas) {}

  Pixel Draw() {
    Heading("Platforms, side " + field_.spec().side);
    std::vector<double> heights = field_.spec().heights_mm;
    std::sort(heights.begin(), heights.end());
    heights.erase(std::unique(heights.begin(), heights.end()), heights.end());
    for (const double height : heights) {
      Square(ColorOfPlatform(field_.spec(), height));
      Entry(WholeText(height) + " mm over the ground");
    }
    canvas_.Text("1, 2", at_ + Pixel(13, 0), kSmallLetters, kInk, Align::kCenter);
    Entry("row and column of a platform");
    Heading("Boxes");
    Boxes();
    Heading("The robot R2");
    canvas_.Line(at_ + Pixel(0, -4), at_ + Pixel(26, -4), kWayBlue, 3);
    canvas_.Ring(at_ + Pixel(4, -4), 5, kWayBlue, 2.5);
    Entry("its way, from its start");
    canvas_.Outline(
        {at_ + Pixel(6, -11), at_ + Pixel(20, -11), at_ + Pixel(20, 3), at_ + Pixel(6, 3)}, kInk,
        2);
    canvas_.Line(at_ + Pixel(13, -4), at_ + Pixel(20, -4), kInk, 2);
    Entry("where it is, and its heading");
    Triangle(at_ + Pixel(13, -4), 6, true, kUpGreen, canvas_);
    Entry("has climbed up, so many mm", Count(FieldEvent::Kind::kUp));
    Triangle(at_ + Pixel(13, -4), 6, false, kDownOrange, canvas_);
    Entry("has climbed down, so many mm", Count(FieldEvent::Kind::kDown));
    canvas_.Disc(at_ + Pixel(13, -4), 5, kTakenPurple);
    Entry("takes a box from here", Count(FieldEvent::Kind::kTaken));
    canvas_.Ring(at_ + Pixel(13, -4), 6, kTakenPurple, 2);
    Entry("docks with R1, or places a box");
    CrossOut(at_ + Pixel(13, -4), 5, 2, canvas_);
    Entry("bumps into something", Count(FieldEvent::Kind::kBump));
    CrossOut(at_ + Pixel(13, -4), 8, 3.5, canvas_);
    Entry("falls", Count(FieldEvent::Kind::kFall));
    return at_;
  }

 private:
  static constexpr double kRowHeight = 21;

  void Boxes() {
    for (const KfsKind kind : {KfsKind::kKfs1, KfsKind::kKfs2, KfsKind::kFake}) {
      int here = 0, all = 0;
      for (std::size_t i = 0; i < field_.boxes().size(); ++i) {
        if (field_.spec().boxes[i].kind != kind) continue;
        ++all;
        if (field_.boxes()[i].where != KfsBox::Where::kField) ++here;
      }
      if (all == 0) continue;
      Square(ColorOfBox(kind));
      Entry(NameOf(kind), std::to_string(here) + " of " + std::to_string(all) + " taken");
    }
    canvas_.Outline(
        {at_ + Pixel(6, -11), at_ + Pixel(20, -11), at_ + Pixel(20, 3), at_ + Pixel(6, 3)},
        ColorOfBox(KfsKind::kKfs2), 2.5);
    Entry("where a taken box was");
  }

  void Heading(const std::string& text) {
    at_.y() += at_.y() > 120 ? kRowHeight / 3 : 0;
    canvas_.Text(text, at_, 13, kInk);
    at_.y() += kRowHeight;
  }
  void Entry(const std::string& text, const std::string& right = "") {
    canvas_.Text(text, at_ + Pixel(38, 0), kFieldLetters, kInk);
    canvas_.Text(right, at_ + Pixel(262, 0), kFieldLetters, kGreyInk, Align::kRight);
    at_.y() += kRowHeight;
  }
  void Square(const Color& color) {
    canvas_.FillRect(at_ + Pixel(0, -11), at_ + Pixel(26, 3), color);
    canvas_.Outline(
        {at_ + Pixel(0, -11), at_ + Pixel(26, -11), at_ + Pixel(26, 3), at_ + Pixel(0, 3)},
        Mix(color, kInk, 0.3), 1);
  }
  std::string Count(FieldEvent::Kind kind) const {
    const auto count =
        std::count_if(field_.events().begin(), field_.events().end(),
                      [kind](const FieldEvent& event) { return event.kind == kind; });
    return std::to_string(count);
  }

  const Field& field_;
  Pixel at_;
  Canvas& canvas_;
};

}  // namespace

void DrawField(const World& world, const ToPixel& at, double scale, Canvas& canvas) {
  if (world.field()) FieldView(world, at, scale, canvas).Draw();
}

Pixel DrawFieldLegend(const World& world, const Pixel& at, Canvas& canvas) {
  return world.field() ? FieldLegend(world, at, canvas).Draw() : at;
}

void DrawHeightChart(const World& world, const Pixel& corner, const Pixel& opposite,
                     Canvas& canvas) {
  constexpr double kAxis = 26;
  if (!world.field()) return;
  const Field& field = *world.field();
  const double left = corner.x() + kChartNames;
  const double bottom = opposite.y() - kAxis;
  const double most_mm = HighestMm(field.spec()) + field.spec().robot.most_mm;
  const double end_s = std::max(1.0, ToSeconds(field.way().back().at));
  const auto x = [&](double seconds) { return left + (opposite.x() - left) * seconds / end_s; };
  const auto y = [&](double mm) { return bottom - (bottom - corner.y()) * mm / most_mm; };
  const double every_s = MarkEvery(end_s, 14, {1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600});
  for (const double s : Marks(0, end_s, every_s)) {
    canvas.Line({x(s), corner.y()}, {x(s), bottom}, kGrid);
    canvas.Text(ClockText(s), {x(s), bottom + 16}, kSmallLetters, kGreyInk, Align::kCenter);
  }
  for (const double mm : Marks(0, most_mm, 200)) {
    canvas.Line({left, y(mm)}, {opposite.x(), y(mm)}, kGrid);
    canvas.Text(WholeText(mm), {left - 6, y(mm) + 4}, kSmallLetters, kGreyInk, Align::kRight);
  }
  std::vector<Pixel> ground{{left, bottom}};
  std::vector<Pixel> body;
  for (const FieldSample& sample : field.way()) {
    const double s = ToSeconds(sample.at);
    const double floor = y(field.spec().HeightMm(sample.position_m));
    ground.emplace_back(x(s), ground.back().y());
    ground.emplace_back(x(s), floor);
    body.emplace_back(x(s), y(sample.height_mm));
  }
  ground.emplace_back(ground.back().x(), bottom);
  canvas.Fill(ground, Mix(kGroundBrown, kPaper, 0.45));
  canvas.Polyline(body, kWayBlue, 2.5);
  canvas.Text("height, mm", {left - 34, (corner.y() + bottom) / 2 - 14}, kFieldLetters, kInk,
              Align::kRight);
  canvas.Text("underside", {left - 34, (corner.y() + bottom) / 2 + 6}, kFieldLetters, kWayBlue,
              Align::kRight);
  canvas.Text("platform", {left - 34, (corner.y() + bottom) / 2 + 24}, kFieldLetters, kGroundBrown,
              Align::kRight);
}

}  // namespace musher::world
