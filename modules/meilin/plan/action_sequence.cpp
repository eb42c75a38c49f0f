#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/base/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace musher::meilin {
namespace {

constexpr double kWhole = 0.001;  // so near to a whole number is one

// The eight numbers of a step, already finite.
struct Numbers {
  bool fetch = false;
  double row = 0;  // whole, of any size
  double col = 0;
  double height_mm = 0;
  double yaw_rad = 0;
};

bool IsCell(double row, double col) {
  return row >= 0 && row < kRows && col >= 0 && col < kCols;
}

std::size_t IndexOf(Cell cell) {
  return static_cast<std::size_t>(cell.row * kCols + cell.col);
}

std::string Area() {
  return fmt::format("expected rows 0 to {} and columns 0 to {}", kRows - 1, kCols - 1);
}

// Follows the robot through a plan.
class SequenceCheck {
 public:
  SequenceCheck(const PlanRules& rules, const PlanStart& start, std::size_t steps)
      : rules_(rules), steps_(steps), place_(start) {}

  void Check(const float* numbers) {
    ++step_;
    const std::optional<Numbers> read = Decode(numbers);
    if (!read) {
      place_.reset();
    } else if (read->fetch) {
      CheckFetch(*read);
    } else {
      CheckMove(*read);
    }
  }

  PlanReading Take() && {
    if (!reading_.faults.empty()) {
      reading_.segments.clear();
      return std::move(reading_);
    }
    Segment done;
    done.index = step_;
    done.segment_type = kPlanDoneType;
    done.debug_name = "meilin_plan_done";
    reading_.segments.push_back(std::move(done));
    return std::move(reading_);
  }

 private:
  void Fault(const std::string& text) {
    if (reading_.faults.size() >= kMostPlanFaults) return;
    reading_.faults.push_back({step_, fmt::format("{} (step {} of {})", text, step_, steps_)});
  }

  bool IsIndex(double number, const char* name) {
    if (!std::isfinite(number)) {
      Fault(fmt::format("{} contains NaN/Inf: {}", name, number));
      return false;
    }
    if (std::abs(number - std::round(number)) > kWhole) {
      Fault(fmt::format("{} must be an integer grid index: {:g}", name, number));
      return false;
    }
    return true;
  }

  std::optional<Numbers> Decode(const float* numbers) {
    const double action = numbers[0];
    if (!std::isfinite(action)) {
      Fault(fmt::format("action type contains NaN/Inf: {}", action));
      return std::nullopt;
    }
    if (std::abs(action) > kWhole && std::abs(action - 1) > kWhole) {
      Fault(fmt::format("arg0 must be 0(move) or 1(fetch): {:g}", action));
      return std::nullopt;
    }
    const bool whole_row = IsIndex(numbers[1], "row");
    const bool whole_col = IsIndex(numbers[2], "col");
    const bool finite = std::isfinite(numbers[3]) && std::isfinite(numbers[4]);
    if (!finite) {
      Fault(fmt::format("arg3/yaw contains NaN/Inf: {} and {}", numbers[3], numbers[4]));
    }
    if (!whole_row || !whole_col || !finite) return std::nullopt;
    // Without -0, which would be printed.
    return Numbers{action > 0.5F, std::round(double{numbers[1]}) + 0.0,
                   std::round(double{numbers[2]}) + 0.0, numbers[3], numbers[4]};
  }

  void CheckMove(const Numbers& to) {
    if (!IsCell(to.row, to.col)) {
      Fault(fmt::format("move grid out of range: ({:g}, {:g}), {}", to.row, to.col, Area()));
      return place_.reset();
    }
    const Cell cell{static_cast<int>(to.row), static_cast<int>(to.col)};
    const double height_mm = rules_.grid.HeightMm(cell);
    const double tolerance_mm = rules_.height_tolerance_mm;
    if (std::abs(to.height_mm) > tolerance_mm &&
        std::abs(to.height_mm - height_mm) > tolerance_mm) {
      Fault(fmt::format("move target_height mismatch: {:g} mm, the {} field has {:g} mm at {}",
                        to.height_mm, SideText(rules_.grid.side), height_mm, CellText(cell)));
    }
    const double yaw_rad = NormalizeYaw(to.yaw_rad);
    Segment segment = Next(kMoveType, cell, yaw_rad);
    if (place_ && std::abs(height_mm - place_->height_mm) > tolerance_mm) {
      CheckClimb(*place_, cell, height_mm, yaw_rad);
      CheckWay(cell, cell);
    } else if (place_) {
      CheckFlat(*place_, cell);
      if (place_->cell != cell) CheckWay(place_->cell, cell);
    }
    entered_.at(IndexOf(cell)) = step_;
    place_ = PlanStart{cell, height_mm, yaw_rad, true};
    segment.move_row = cell.row;
    segment.move_col = cell.col;
    segment.target_height_mm = height_mm;
    reading_.segments.push_back(std::move(segment));
  }

  // A straight way over cells of another height: the robot would fall into a pit, or push a wall.
  void CheckFlat(const PlanStart& from, Cell to) {
    const Grid& grid = rules_.grid;
    const auto other = grid.OtherHeightOnLine(grid.Centre(from.cell), grid.Centre(to),
                                              from.height_mm, rules_.height_tolerance_mm);
    if (!other) return;
    Fault(
        fmt::format("move from {} to {} crosses {}, which has {} mm: a straight way has one "
                    "height, {:g} mm",
                    CellText(from.cell), CellText(to), CellText(*other), grid.HeightMm(*other),
                    from.height_mm));
  }

  // The cells between two cells, and the second one: they are entered now.
  void CheckWay(Cell from, Cell to) {
    for (const Cell cell :
         rules_.grid.CellsOnLine(rules_.grid.Centre(from), rules_.grid.Centre(to))) {
      if (cell == from && from != to) continue;
      entered_.at(IndexOf(cell)) = step_;
      if (!HasBox(cell)) continue;
      Fault(
          fmt::format("move to {} drives over {}, where the map has a box: fetch it before, or "
                      "go around it",
                      CellText(to), CellText(cell)));
    }
  }

  // By the map, without the boxes that were taken.
  bool HasBox(Cell cell) const {
    if (!rules_.boxes || fetched_.at(IndexOf(cell)) > 0) return false;
    if (std::ranges::find(rules_.taken, cell) != rules_.taken.end()) return false;
    const Box box = rules_.boxes->At(cell);
    return box != Box::kEmpty && (box != Box::kKfs1 || rules_.kfs1_blocks);
  }

  void CheckClimb(const PlanStart& from, Cell to, double height_mm, double yaw_rad) {
    const auto direction = DirectionTo(from.cell, to);
    if (!direction) {
      Fault(fmt::format(
          "move with height change requires adjacent target grid: {} mm to {} mm, {} to {}",
          from.height_mm, height_mm, CellText(from.cell), CellText(to)));
    } else if (*direction == Direction::kBackward) {
      Fault(fmt::format(
          "move does not support backward direction: {} to {} changes the height by {:g} mm",
          CellText(from.cell), CellText(to), height_mm - from.height_mm));
    } else if (YawDistance(yaw_rad, SnapYaw(yaw_rad)) > rules_.yaw_tolerance_rad) {
      Fault(
          fmt::format("move climbs across its heading: {:.2f} rad from {} to {}, expected a right "
                      "angle within {:.2f} rad",
                      yaw_rad, CellText(from.cell), CellText(to), rules_.yaw_tolerance_rad));
    }
  }

  void CheckFetch(const Numbers& box) {
    const double wheels_mm = rules_.normal_height_mm + box.height_mm;
    if (!IsCell(box.row, box.col)) {
      Fault(fmt::format("fetch grid out of range: ({:g}, {:g}), {}", box.row, box.col, Area()));
    } else {
      const Cell cell{static_cast<int>(box.row), static_cast<int>(box.col)};
      if (place_) CheckReach(*place_, cell, box.yaw_rad);
      CheckBox(cell);
      if (const int before = entered_.at(IndexOf(cell)); before > 0) {
        Fault(
            fmt::format("fetch KFS grid {} is already driven over by step {}, where its box blocks "
                        "the way: fetch it before",
                        CellText(cell), before));
      }
      fetched_.at(IndexOf(cell)) = step_;
      Segment segment = Next(kFetchType, cell, NormalizeYaw(box.yaw_rad));
      segment.kfs_row = cell.row;
      segment.kfs_col = cell.col;
      segment.height_diff = box.height_mm;
      reading_.segments.push_back(std::move(segment));
    }
    if (std::abs(box.height_mm) > rules_.height_tolerance_mm &&
        (wheels_mm < 0 || wheels_mm > rules_.highest_wheel_mm)) {
      Fault(fmt::format(
          "fetch suspension height is {}: {:g} mm of wheels and {:g} mm of difference make {:g} "
          "mm, expected 0 to {:g} mm",
          wheels_mm < 0 ? "negative" : "out of range", rules_.normal_height_mm, box.height_mm,
          wheels_mm, rules_.highest_wheel_mm));
    } else if (IsCell(box.row, box.col)) {
      CheckHeight(box);
    }
    if (!place_) return;
    place_->at_centre = false;
    place_->yaw_rad = NormalizeYaw(box.yaw_rad);
  }

  // The arm is lifted by that difference: by a wrong one it grasps into the air, or into the wall.
  void CheckHeight(const Numbers& box) {
    if (!place_) return;
    const Cell cell{static_cast<int>(box.row), static_cast<int>(box.col)};
    const double expected_mm = rules_.grid.HeightMm(cell) - place_->height_mm;
    if (std::abs(box.height_mm - expected_mm) <= rules_.height_tolerance_mm) return;
    Fault(fmt::format("fetch height_diff mismatch: {:g} mm, the {} field has {:g} mm from {} to {}",
                      box.height_mm, SideText(rules_.grid.side), expected_mm,
                      CellText(place_->cell), CellText(cell)));
  }

  void CheckBox(Cell cell) {
    if (const int before = fetched_.at(IndexOf(cell)); before > 0) {
      return Fault(fmt::format("fetch KFS grid {} a second time: step {} has taken its box",
                               CellText(cell), before));
    }
    if (std::ranges::find(rules_.taken, cell) != rules_.taken.end()) {
      return Fault(fmt::format("fetch KFS grid {}: its box is already taken", CellText(cell)));
    }
    if (!rules_.boxes) return;
    const Box box = rules_.boxes->At(cell);
    if (box != Box::kEmpty && box != Box::kFake) return;
    Fault(fmt::format("fetch KFS grid {}: the map has {} there", CellText(cell),
                      box == Box::kFake ? "a fake box" : "no box"));
  }

  void CheckReach(const PlanStart& from, Cell box, double yaw_rad) {
    if (!from.at_centre) {
      Fault(
          fmt::format("fetch requires robot pose at current cell center: a move to {} before "
                      "the fetch of {} is missing",
                      CellText(from.cell), CellText(box)));
    }
    const auto direction = DirectionTo(from.cell, box);
    if (!direction) {
      return Fault(fmt::format("fetch KFS grid must be adjacent to current grid: {} from {}",
                               CellText(box), CellText(from.cell)));
    }
    if (*direction == Direction::kBackward) {
      return Fault(fmt::format("fetch only supports forward/left/right: {} is backward of {}",
                               CellText(box), CellText(from.cell)));
    }
    const double expected_rad = YawOf(*direction);
    if (YawDistance(yaw_rad, expected_rad) > rules_.yaw_tolerance_rad) {
      Fault(fmt::format("fetch yaw mismatch: {:.2f} rad, {} from {} is {}: {:.2f} rad", yaw_rad,
                        CellText(box), CellText(from.cell), DirectionText(*direction),
                        expected_rad));
    }
  }

  Segment Next(std::string_view type, Cell cell, double yaw_rad) const {
    Segment segment;
    segment.index = step_ - 1;
    segment.segment_type = type;
    segment.debug_name = segment.segment_type + " " + CellText(cell);
    segment.target_yaw = yaw_rad;
    if (place_) {
      segment.from_row = place_->cell.row;
      segment.from_col = place_->cell.col;
    }
    return segment;
  }

  const PlanRules& rules_;
  const std::size_t steps_;
  int step_ = 0;  // the present one, from 1
  std::array<int, std::size_t{kRows} * kCols>
      entered_{};  // by cell: the step that last moved there; 0: none
  std::array<int, std::size_t{kRows} * kCols> fetched_{};  // the same of its box
  std::optional<PlanStart> place_;  // nothing: not known since a step that cannot be read
  PlanReading reading_;
};

// Why the layout and the numbers do not belong together; empty if they do.
std::string Contradiction(const msg::Float32MultiArray& plan) {
  if (plan.layout.data_offset != 0) {
    return fmt::format("data_offset is {}, expected 0", plan.layout.data_offset);
  }
  if (plan.layout.dim.empty()) return "";
  std::uint64_t count = 1;
  std::string sizes;
  for (const msg::MultiArrayDimension& dimension : plan.layout.dim) {
    // Two sizes of 32 bits do not overflow; after that the product is already too large.
    count = count > plan.data.size() ? count : count * dimension.size;
    if (sizes.size() < 80) sizes += (sizes.empty() ? "" : " x ") + std::to_string(dimension.size);
  }
  if (count == plan.data.size()) return "";
  return fmt::format("{} is not {} numbers", sizes, plan.data.size());
}

PlanReading Refused(std::string message) {
  PlanReading reading;
  reading.faults.push_back({0, std::move(message)});
  return reading;
}

}  // namespace

PlanStart StartOf(const Grid& grid, const PlanStart& initial, const std::optional<Pose2>& live) {
  if (!live || !std::isfinite(live->yaw_rad)) return initial;
  const Point2 at{live->x_m, live->y_m};
  const std::optional<Cell> cell = grid.CellAt(at);
  if (!cell) return initial;
  return {*cell, static_cast<double>(grid.HeightMm(*cell)), NormalizeYaw(live->yaw_rad),
          grid.IsAtCentre(at, *cell)};
}

PlanReading ReadActionSequence(const msg::Float32MultiArray& plan, const PlanRules& rules,
                               const PlanStart& start) {
  const std::size_t size = plan.data.size();
  if (size == 0) return Refused("empty Float32MultiArray: a plan has at least one step");
  if (size % kNumbersPerStep != 0) {
    return Refused(fmt::format("Float32MultiArray length must be divisible by 8: {}",
                               Counted(size, "number")));
  }
  const std::size_t steps = size / kNumbersPerStep;
  if (steps > kMostSteps) {
    return Refused(fmt::format("too many steps: {}, expected at most {}", steps, kMostSteps));
  }
  const std::string contradiction = Contradiction(plan);
  if (!contradiction.empty()) return Refused("layout contradicts the data: " + contradiction);
  SequenceCheck check(rules, start, steps);
  for (std::size_t at = 0; at < size; at += kNumbersPerStep) check.Check(&plan.data[at]);
  return std::move(check).Take();
}

msg::Float32MultiArray ToActionSequence(const std::vector<PlanStep>& steps) {
  msg::Float32MultiArray plan;
  plan.layout.dim = {{"step", static_cast<std::uint32_t>(steps.size()), kNumbersPerStep},
                     {"field", kNumbersPerStep, 1}};
  for (const PlanStep& step : steps) {
    for (const double number :
         {step.fetch ? 1.0 : 0.0, static_cast<double>(step.cell.row),
          static_cast<double>(step.cell.col), step.height_mm, step.yaw_rad, 0.0, 0.0, 0.0}) {
      plan.data.push_back(static_cast<float>(number));
    }
  }
  return plan;
}

std::vector<PlanStep> StepsOf(const msg::Float32MultiArray& plan) {
  std::vector<PlanStep> steps;
  for (std::size_t at = 0; at + kNumbersPerStep <= plan.data.size(); at += kNumbersPerStep) {
    const float* numbers = &plan.data[at];
    steps.push_back(
        {numbers[0] > 0.5F,
         {static_cast<int>(std::lround(numbers[1])), static_cast<int>(std::lround(numbers[2]))},
         numbers[3],
         numbers[4]});
  }
  return steps;
}

std::string PlanIdOf(std::uint64_t number) {
  return "mf_action_seq_" + std::to_string(number);
}

}  // namespace musher::meilin
