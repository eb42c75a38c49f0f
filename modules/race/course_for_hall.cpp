#include "musher/modules/race/course_for_hall.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/race/toml_numbers.hpp"
#include "musher/navigation/camera/mounted_camera.hpp"

namespace musher::race {
namespace {

using Measure = double (*)(const Hall&);

// A number of steps in a course, and the way that they lead.
struct CountRule {
  std::string_view table;
  std::string_view movement;
  Measure way_m;
  int nth = 0;  // of the walks of this movement in the state
  std::string_view key = "count";
  std::string_view beside = {};  // else the step that moves by `movement`
};

constexpr Measure kStart = [](const Hall& hall) { return hall.start_m; };
constexpr Measure kCross = [](const Hall& hall) { return hall.cross_m; };
constexpr Measure kCrossToS1 = [](const Hall& hall) { return hall.cross_m - hall.s1_m; };
constexpr Measure kBayAAside = [](const Hall& hall) { return hall.bay_a_aside_m; };
constexpr Measure kBayAIn = [](const Hall& hall) { return hall.bay_a_in_m; };
constexpr Measure kLaneAside = [](const Hall& hall) { return hall.lane_aside_m; };
constexpr Measure kLaneLength = [](const Hall& hall) { return hall.lane_length_m; };
constexpr Measure kLaneWithoutBay = [](const Hall& h) { return h.lane_length_m - h.bay_b_in_m; };
constexpr Measure kBayBAside = [](const Hall& hall) { return hall.bay_b_aside_m; };
constexpr Measure kBayBIn = [](const Hall& hall) { return hall.bay_b_in_m; };
constexpr Measure kBayToBay = [](const Hall& hall) { return 2 * hall.bay_b_aside_m; };
constexpr Measure kBayToLane = [](const Hall& h) { return h.bay_b_aside_m + h.lane_aside_m; };

// A course may lack some: the states of the two remainders, and what is added to a counter.
const std::vector<CountRule>& CountRules() {
  static const std::vector<CountRule> rules = {
      {"state.START_TO_QRA", "forward", kStart},
      {"state.QRA_TO_A1", "forward", kCross},
      {"state.QRA_TO_A1", "right", kBayAAside},
      {"state.QRA_TO_A1", "backward", kBayAIn},
      {"state.QRA_TO_A2", "forward", kCross},
      {"state.QRA_TO_A2", "left", kBayAAside},
      {"state.QRA_TO_A2", "backward", kBayAIn},
      {"state.A1_TO_S1", "forward", kBayAIn},
      {"state.A1_TO_S1", "left", kBayAAside},
      {"state.A1_TO_S1", "backward", kCrossToS1},
      {"state.A2_TO_S1", "forward", kBayAIn},
      {"state.A2_TO_S1", "right", kBayAAside},
      {"state.A2_TO_S1", "backward", kCrossToS1},
      {"state.S2_TO_L1", "left", kLaneAside},
      {"state.S2_TO_R1", "right", kLaneAside},
      {"until.barrier", "forward", kLaneLength, 0, "most", "most"},
      {"until.marker", "forward", kLaneLength, 0, "most", "most"},
      {"state.L1_TO_QRB", "forward", kLaneLength},
      {"state.L1_TO_QRB", "forward", kLaneLength, 0, "beyond", "beyond"},
      {"state.L1_TO_QRB", "right", kLaneAside},
      {"state.R1_TO_QRB", "forward", kLaneLength},
      {"state.R1_TO_QRB", "forward", kLaneLength, 0, "beyond", "beyond"},
      {"state.R1_TO_QRB", "left", kLaneAside},
      {"state.QRB_TO_B1", "left", kBayBAside},
      {"state.QRB_TO_B1", "forward", kBayBIn},
      {"state.QRB_TO_B2", "right", kBayBAside},
      {"state.QRB_TO_B2", "forward", kBayBIn},
      {"state.B1_TO_B2", "backward", kBayBIn},
      {"state.B1_TO_B2", "right", kBayToBay},
      {"state.B1_TO_B2", "forward", kBayBIn},
      {"state.B2_TO_B1", "backward", kBayBIn},
      {"state.B2_TO_B1", "left", kBayToBay},
      {"state.B2_TO_B1", "forward", kBayBIn},
      {"state.B1_TO_R1", "forward", kBayBIn},
      {"state.B1_TO_R1", "left", kBayToLane},
      {"state.B1_TO_R1", "forward", kLaneWithoutBay, 0, "most", "most"},
      {"state.B1_TO_R1", "forward", kBayBIn, 0, "by", "add = "},
      {"state.B2_TO_L1", "forward", kBayBIn},
      {"state.B2_TO_L1", "right", kBayToLane},
      {"state.B2_TO_L1", "forward", kLaneWithoutBay, 0, "most", "most"},
      {"state.B2_TO_L1", "forward", kBayBIn, 0, "by", "add = "},
      {"state.L1_TO_S2", "forward", kLaneLength},
      {"state.L1_TO_S2", "forward", kBayBIn, 1},
      {"state.L1_TO_S2", "forward", kLaneLength, 0, "beyond", "beyond"},
      {"state.L1_TO_S2", "left", kLaneAside},
      {"state.R1_TO_S2", "forward", kLaneLength},
      {"state.R1_TO_S2", "forward", kBayBIn, 1},
      {"state.R1_TO_S2", "forward", kLaneLength, 0, "beyond", "beyond"},
      {"state.R1_TO_S2", "right", kLaneAside},
      {"state.S1_TO_A1", "forward", kCrossToS1},
      {"state.S1_TO_A1", "right", kBayAAside},
      {"state.S1_TO_A1", "backward", kBayAIn},
      {"state.S1_TO_A2", "forward", kCrossToS1},
      {"state.S1_TO_A2", "left", kBayAAside},
      {"state.S1_TO_A2", "backward", kBayAIn},
      {"state.A1_TO_START", "forward", kBayAIn},
      {"state.A1_TO_START", "left", kBayAAside},
      {"state.A1_TO_START", "backward", kCross},
      {"state.A1_TO_START", "backward", kStart, 1},
      {"state.A2_TO_START", "forward", kBayAIn},
      {"state.A2_TO_START", "right", kBayAAside},
      {"state.A2_TO_START", "backward", kCross},
      {"state.A2_TO_START", "backward", kStart, 1},
  };
  return rules;
}

std::string Text(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

// Of a step on its way; 0: no such walk.
double StepLength(const Course& course, std::string_view movement) {
  const auto found = FindByName(course.movements, movement);
  if (!found) return 0;
  const Movement& moved = course.movements[*found];
  return std::hypot(moved.twist.forward_m_s, moved.twist.left_m_s) * ToSeconds(course.step) *
         moved.odometry_share;
}

// Every measure of the hall in the table [hall] of the text.
void WriteHall(const Hall& hall, TomlNumbers& numbers, AdaptedFile& file) {
  for (const HallMeasure& each : kHallMeasures) {
    const TomlNumbers::Place place{"hall", "", each.key};
    const auto before = numbers.Get(place);
    const double now = hall.*each.member;
    if (before && std::abs(*before - now) < 1e-9) continue;
    if (numbers.Set(place, MeasureText(now))) continue;
    if (now == Hall{}.*each.member) continue;
    file.open.push_back("hall." + std::string(each.key) + " is missing in the base: write " +
                        MeasureText(now));
  }
}

// What the measures do not give.
void NoteOpen(const Hall& hall, const Hall& base, AdaptedFile& file) {
  if (hall.start_m != base.start_m) {
    file.open.emplace_back(
        "start_m: where the line ahead is seen from START (dy_target of front_far_lane) is to be "
        "measured: musher-vision look");
  }
  if (hall.s1_m != base.s1_m) {
    file.open.emplace_back(
        "s1_m: where the S lane is seen from START (ycy_center of front_start) and START from lane "
        "Q (left_start) is to be measured: musher-vision look");
  }
  if (hall.bay_b_in_m != base.bay_b_in_m) {
    file.open.emplace_back(
        "bay_b_in_m: where the line ahead is seen in a bay of zone B (dy_target of front_bay) is "
        "to be measured: musher-vision look");
  }
}

// A step that each course has in this state; the second ones of a state, and what is beside a step,
// are of some courses.
bool Needs(const Course& base, const CountRule& rule) {
  constexpr std::string_view kState = "state.";
  if (!rule.beside.empty() || rule.nth != 0 || !rule.table.starts_with(kState)) return false;
  return FindByName(base.states, rule.table.substr(kState.size())).has_value();
}

}  // namespace

std::string MeasureText(double metres) {
  std::string text = Text("%.4f", metres);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text += '0';
  return text;
}

AdaptedFile CourseForHall(const Hall& hall, const Course& base, std::string_view text) {
  AdaptedFile file;
  TomlNumbers numbers(text);
  for (const CountRule& rule : CountRules()) {
    const std::string step_of = "move = \"" + std::string(rule.movement) + "\"";
    const std::string_view beside = rule.beside.empty() ? std::string_view(step_of) : rule.beside;
    const TomlNumbers::Place place{rule.table, beside, rule.key, rule.nth};
    const auto count = numbers.Get(place);
    const double more_m = rule.way_m(hall) - rule.way_m(base.hall);
    const double step_m = StepLength(base, rule.movement);
    if (std::abs(more_m) < 1e-9) continue;
    if (!count || step_m == 0) {
      if (!Needs(base, rule)) continue;
      file.open.push_back(std::string(rule.table) + ": its " + std::string(rule.movement) +
                          " is not found");
      continue;
    }
    const long now = std::lround(*count + more_m / step_m);
    const std::string what = std::string(rule.table) + ": " + std::string(rule.movement) + " " +
                             std::to_string(std::lround(*count));
    if (now < 1 || now > kMostSteps) {
      file.open.push_back(what + " would be " + std::to_string(now) +
                          " steps: the state needs other movements");
      continue;
    }
    if (now == std::lround(*count)) continue;
    numbers.Set(place, std::to_string(now));
    file.changes.push_back(what + " -> " + std::to_string(now) + " (" +
                           Text("%.2f", std::abs(more_m)) + (more_m < 0 ? " m less)" : " m more)"));
  }
  WriteHall(hall, numbers, file);
  NoteOpen(hall, base.hall, file);
  file.text = numbers.text();
  return file;
}

namespace {

// A camera and a region of the vision config.
struct View {
  navigation::MountedCamera camera;
  double trunk_height_m = 0.29;
  double top = 0.6, bottom = 1, left = 0, right = 1;
};

// Reads no more of the vision config than this: it has a reader of its own.
class VisionText {
 public:
  explicit VisionText(std::string_view text) : document_(config_toml::ParseDocument(text)) {}

  std::optional<View> ViewOf(std::string_view detector) const {
    const auto* root = std::get_if<config_toml::Table>(&document_);
    if (root == nullptr) return std::nullopt;
    config_toml::Findings findings;
    config_toml::TableReader reader(*root, {1, 1}, "", findings);
    View view;
    if (auto hall = reader.Sub("hall")) Take(*hall, "trunk_height_m", view.trunk_height_m);
    for (config_toml::TableReader& entry : reader.Subs("detectors")) {
      const auto name = entry.String("name");
      if (!name || name->text != detector) continue;
      const auto picture = entry.String("picture");
      if (auto parameters = entry.Sub("parameters")) {
        if (auto region = parameters->Sub("region")) {
          Take(*region, "top", view.top);
          Take(*region, "bottom", view.bottom);
          Take(*region, "left", view.left);
          Take(*region, "right", view.right);
        }
      }
      if (Mount(reader, picture ? picture->text : "image_rgb", view.camera)) return view;
    }
    return std::nullopt;
  }

 private:
  static void Take(config_toml::TableReader& table, const char* key, double& value) {
    value = table.Number(key, -1e3, 1e3).value_or(value);
  }
  static bool Mount(config_toml::TableReader& root, std::string_view picture,
                    navigation::MountedCamera& camera) {
    for (config_toml::TableReader& mount : root.Subs("mounts")) {
      const auto of = mount.String("picture");
      if (!of || of->text != picture) continue;
      for (const config_toml::Row& row : navigation::CameraRows(camera)) row(mount);
      return true;
    }
    return false;
  }

  std::variant<config_toml::Table, config_toml::SyntaxFault> document_;
};

using Place = std::optional<std::array<double, 2>>;

// Where in its region, from its top, the middle of a line is seen; nothing where it is not.
template <class At>
std::optional<double> ShareInRegion(const View& view, At&& at) {
  constexpr double kStepM = 0.01;
  constexpr int kHalf = 250;  // steps
  double sum = 0, weights = 0;
  Place before;
  for (int i = -kHalf; i <= kHalf; ++i) {
    const Place seen = navigation::ShareOf(view.camera, view.trunk_height_m, at(i * kStepM));
    const bool inside = seen && (*seen)[0] >= view.left && (*seen)[0] <= view.right &&
                        (*seen)[1] >= view.top && (*seen)[1] <= view.bottom;
    if (inside && before) {
      const double weight = std::hypot((*seen)[0] - (*before)[0], (*seen)[1] - (*before)[1]);
      sum += weight * (*seen)[1];
      weights += weight;
    }
    before = inside ? seen : std::nullopt;
  }
  if (weights == 0) return std::nullopt;
  return (sum / weights - view.top) / (view.bottom - view.top);
}

struct TargetRule {
  std::string_view detector;
  enum class Side { kLeft, kRight, kAhead } side;
  Measure away_m;  // from the body's middle to the line
};

constexpr Measure kHalfLane = [](const Hall& hall) { return hall.half_m(); };
constexpr Measure kInnerLine = [](const Hall& hall) { return hall.lane_aside_m - hall.half_m(); };
constexpr Measure kBayAAhead = [](const Hall& hall) { return hall.bay_a_ahead_m; };

constexpr TargetRule kTargets[] = {
    {"right_edge", TargetRule::Side::kRight, kHalfLane},
    {"left_edge", TargetRule::Side::kLeft, kHalfLane},
    {"right_inner", TargetRule::Side::kRight, kInnerLine},
    {"left_inner", TargetRule::Side::kLeft, kInnerLine},
    {"front_bay_a", TargetRule::Side::kAhead, kBayAAhead},
};

std::optional<double> TargetOf(const View& view, const TargetRule& rule, const Hall& hall) {
  const double away_m = rule.away_m(hall);
  return ShareInRegion(view, [&](double along_m) -> navigation::GroundPoint {
    if (rule.side == TargetRule::Side::kAhead) return {away_m, along_m};
    return {along_m, rule.side == TargetRule::Side::kLeft ? away_m : -away_m};
  });
}

void WriteTarget(const TargetRule& rule, const Hall& hall, const Hall& base,
                 const VisionText& vision, TomlNumbers& numbers, AdaptedFile& file) {
  if (std::abs(rule.away_m(hall) - rule.away_m(base)) < 1e-9) return;
  const std::string name(rule.detector);
  const TomlNumbers::Place place{rule.detector, "", "dy_target"};
  const auto before = numbers.Get(place);
  const auto view = vision.ViewOf(rule.detector);
  if (!view || !before) {
    file.open.push_back(name +
                        ": without dy_target, region and [[mounts]] of its camera its "
                        "target is to be measured: musher-vision look");
    return;
  }
  const auto here = TargetOf(*view, rule, hall), there = TargetOf(*view, rule, base);
  const double target = here && there ? *before + *here - *there : -1;
  constexpr double kEdge = 0.05;  // of the region
  if (target < kEdge || target > 1 - kEdge) {
    file.open.push_back(name + ": its line, " + MeasureText(rule.away_m(hall)) +
                        " m away, is not in its region; it needs another one");
    return;
  }
  numbers.Set(place, Text("%.3f", target));
  file.changes.push_back(name + ": dy_target " + MeasureText(*before) + " -> " +
                         Text("%.3f", target));
}

}  // namespace

AdaptedFile VisionForHall(const Hall& hall, const Hall& base, std::string_view text) {
  AdaptedFile file;
  TomlNumbers numbers(text);
  const VisionText vision(text);
  if (std::abs(hall.pitch_m() - base.pitch_m()) > 1e-9) {
    if (numbers.Set({"hall", "", "lane_m"}, MeasureText(hall.pitch_m()))) {
      file.changes.push_back("hall: lane_m " + MeasureText(hall.pitch_m()));
    } else {
      file.open.push_back("hall.lane_m is missing: write " + MeasureText(hall.pitch_m()));
    }
  }
  for (const TargetRule& rule : kTargets) WriteTarget(rule, hall, base, vision, numbers, file);
  NoteOpen(hall, base, file);
  file.text = numbers.text();
  return file;
}

AdaptedFile WalkerForHall(const Hall& hall, std::string_view text) {
  AdaptedFile file;
  TomlNumbers numbers(text);
  const TomlNumbers::Place place{"lane", "", "width_m"};
  const auto before = numbers.Get(place);
  if (!before) {
    file.open.push_back("lane.width_m is missing: write " + MeasureText(hall.lane_m));
  } else if (std::abs(*before - hall.lane_m) > 1e-9) {
    numbers.Set(place, MeasureText(hall.lane_m));
    file.changes.push_back("lane: width_m " + MeasureText(*before) + " -> " +
                           MeasureText(hall.lane_m));
  }
  file.text = numbers.text();
  return file;
}

}  // namespace musher::race
