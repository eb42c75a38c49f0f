#include "musher/modules/meilin/mission/progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>
#include <variant>

#include <fmt/format.h>

#include "musher/base/checksum.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/behavior/fsm/saved_part.hpp"
#include "musher/behavior/fsm/toml/toml_writer.hpp"

namespace musher::meilin {
namespace {

constexpr std::size_t kMostTaken = 32;
constexpr double kFarMm = 10'000;

std::string PlanText(const std::vector<PlanStep>& plan) {
  std::string text;
  for (const PlanStep& step : plan) {
    text += fmt::format("{}{} {} {} {} {}", text.empty() ? "" : "; ", step.fetch ? "fetch" : "move",
                        step.cell.row, step.cell.col, step.height_mm, step.yaw_rad);
  }
  return text;
}

// Nothing: it is no plan.
std::optional<std::vector<PlanStep>> PlanOf(const std::string& text) {
  std::vector<PlanStep> plan;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line, ';');) {
    std::istringstream words(line);
    std::string kind;
    PlanStep step;
    words >> kind >> step.cell.row >> step.cell.col >> step.height_mm >> step.yaw_rad;
    const bool known = kind == "move" || kind == "fetch";
    if (!words || !known || !IsInside(step.cell) || std::abs(step.height_mm) > kFarMm ||
        std::abs(step.yaw_rad) > kFarMm || plan.size() >= kMostSteps) {
      return std::nullopt;
    }
    step.fetch = kind == "fetch";
    plan.push_back(step);
  }
  return plan;
}

// The texts of values that an archive has no type for.
struct Texts {
  std::string plan;
  std::string taken_plans;
  std::string done;
  std::string wheels_mm;
};

Texts TextsOf(const Progress& progress) {
  return {PlanText(progress.plan), fmt::format("{}", fmt::join(progress.taken_plans, " ")),
          fmt::format("{}", fmt::join(progress.done, " ")),
          fmt::format("{:g}", fmt::join(progress.wheels_mm, " "))};
}

void Persist(fsm::Archive& archive, Progress& progress, Texts& texts) {
  std::int64_t row = progress.cell.row;
  std::int64_t col = progress.cell.col;
  archive.Field("plans", progress.plans);
  archive.Field("taken_plans", texts.taken_plans);
  archive.Field("plan_id", progress.plan_id);
  archive.Field("plan", texts.plan);
  archive.Field("segments", progress.segments);
  archive.Field("next", progress.next);
  archive.Field("begun", progress.begun);
  archive.Field("done", texts.done);
  archive.Field("row", row);
  archive.Field("col", col);
  archive.Field("height_mm", progress.height_mm);
  archive.Field("yaw_rad", progress.yaw_rad);
  archive.Field("at_centre", progress.at_centre);
  archive.Field("offset_mm", progress.offset_mm);
  archive.Field("wheels_mm", texts.wheels_mm);
  archive.Field("climbing", progress.climbing);
  archive.Field("taken", progress.taken);
  archive.Field("last_end", progress.last_end);
  archive.Field("side", progress.side);
  archive.Field("stands", progress.stands);
  progress.cell = {static_cast<int>(std::clamp<std::int64_t>(row, -1, kRows)),
                   static_cast<int>(std::clamp<std::int64_t>(col, -1, kCols))};
}

class ProgressWriter : private fsm::TomlWriter {
 public:
  std::string Write(const std::vector<fsm::SavedField>& fields) && {
    Append("# How far a match has come. musher-meilin goes on with it on command.\n");
    for (const fsm::SavedField& field : fields) {
      std::visit([&](const auto& value) { Field(field.name, value); }, field.value);
    }
    const Result<std::string> written = Written("progress");
    return written ? written.value() : "";
  }
};

std::vector<fsm::SavedField> FieldsOf(const config_toml::Table& table) {
  std::vector<fsm::SavedField> fields;
  for (const config_toml::Member& member : table) {
    const auto& content = member.value.content;
    if (const auto* flag = std::get_if<bool>(&content)) fields.push_back({member.key, *flag});
    if (const auto* whole = std::get_if<std::int64_t>(&content)) {
      fields.push_back({member.key, *whole});
    }
    if (const auto* real = std::get_if<double>(&content)) fields.push_back({member.key, *real});
    if (const auto* text = std::get_if<std::string>(&content)) {
      fields.push_back({member.key, *text});
    }
  }
  return fields;
}

// Why these values are no progress; empty if they are.
std::string Wrong(const Progress& progress) {
  if (!IsInside(progress.cell)) return "row and col are no cell";
  for (const double number : {progress.height_mm, progress.yaw_rad, progress.offset_mm}) {
    if (!(std::abs(number) <= kFarMm)) return "a height, yaw or offset is no number in its range";
  }
  // Of a plan of the old form by who reads it.
  const std::size_t steps = progress.segments.empty() ? progress.plan.size() : kMostSteps;
  if (progress.next < 0 || progress.next > static_cast<std::int64_t>(steps)) {
    return "next is no step of the plan";
  }
  const auto& wheels = progress.wheels_mm;
  const auto far = [](double mm) { return !(std::abs(mm) <= kFarMm); };
  if ((!wheels.empty() && wheels.size() != Wheels::kCount) || std::ranges::any_of(wheels, far)) {
    return "wheels_mm: expected the heights of four wheels";
  }
  if (progress.taken < 0 || progress.taken >= std::int64_t{1} << (kRows * kCols)) {
    return "taken has bits of no cell";
  }
  return progress.plans < 0 ? "plans is negative" : "";
}

}  // namespace

bool Progress::IsTaken(std::int64_t written_ns) const {
  return written_ns != 0 && std::ranges::find(taken_plans, written_ns) != taken_plans.end();
}

void Progress::Take(std::int64_t written_ns) {
  if (written_ns == 0 || IsTaken(written_ns)) return;
  if (written_ns < 0) ForgetHandedOut();
  taken_plans.push_back(written_ns);
  if (taken_plans.size() > kMostTaken) taken_plans.erase(taken_plans.begin());
}

void Progress::ForgetHandedOut() {
  std::erase_if(taken_plans, [](std::int64_t number) { return number < 0; });
}

std::int64_t NumberOf(const msg::Float32MultiArray& plan) {
  std::string bytes(plan.data.size() * sizeof(float), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), plan.data.data(), bytes.size());
  return -static_cast<std::int64_t>(Fnv1a(bytes) >> 1) - 1;
}

std::string WriteProgress(const Progress& progress) {
  Progress copy = progress;
  Texts texts = TextsOf(copy);
  return ProgressWriter().Write(
      fsm::SaveFields([&](fsm::Archive& archive) { Persist(archive, copy, texts); }));
}

Result<Progress> ReadProgress(std::string_view text, const std::string& file) {
  const auto fail = [&file](int line, const std::string& why) {
    return Error{kCodeFailed, fmt::format("{}:{}: {}", file, line, why)};
  };
  const auto document = config_toml::ParseDocument(text);
  if (const auto* fault = std::get_if<config_toml::SyntaxFault>(&document)) {
    return fail(fault->at.line, fault->message);
  }
  Progress progress;
  Texts texts;
  std::vector<fsm::SnapshotFault> faults;
  fsm::RestoreFields(
      FieldsOf(std::get<config_toml::Table>(document)), "",
      [&](fsm::Archive& archive) { Persist(archive, progress, texts); }, faults);
  if (!faults.empty()) return fail(1, faults.front().key + ": " + faults.front().what);
  const auto plan = PlanOf(texts.plan);
  if (!plan) return fail(1, "plan: expected steps as in \"move 0 1 0 0; fetch 1 1 200 0\"");
  progress.plan = *plan;
  std::istringstream numbers(texts.taken_plans);
  for (std::int64_t number = 0; numbers >> number;) progress.Take(number);
  std::istringstream words(texts.done);
  for (std::string word; words >> word;) progress.done.insert(word);
  std::istringstream heights(texts.wheels_mm);
  for (double mm = 0; heights >> mm;) progress.wheels_mm.push_back(mm);
  if (const std::string wrong = Wrong(progress); !wrong.empty()) return fail(1, wrong);
  return progress;
}

}  // namespace musher::meilin
