#include "musher/cli/render/doctor.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "musher/base/words.hpp"
#include "musher/cli/console/console.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/console/table.hpp"

namespace musher::cli {
namespace {

struct Shown {
  const char* text;
  const char* json;
  Style style;
};

Shown ShownAs(CheckStatus health) {
  switch (health) {
    case CheckStatus::kNotApplicable:
      return {"-", "not_applicable", Style::kDim};
    case CheckStatus::kOk:
      return {"ok", "ok", Style::kGood};
    case CheckStatus::kWarning:
      return {"warning", "warning", Style::kBusy};
    case CheckStatus::kError:
      break;
  }
  return {"error", "error", Style::kBad};
}

std::size_t CountOf(const std::vector<DoctorCheck>& checks, CheckStatus health) {
  return std::count_if(checks.begin(), checks.end(),
                       [health](const auto& check) { return check.health == health; });
}

}  // namespace

std::string DoctorText(const std::vector<DoctorCheck>& checks, bool colour) {
  Table table({"CHECK", "RESULT", "REASON"});
  for (const DoctorCheck& check : checks) {
    const Shown shown = ShownAs(check.health);
    table.Add({{check.name}, {shown.text, shown.style}, {Printable(check.reason)}});
    if (!check.fix.empty()) table.Add({{""}, {"fix:", Style::kDim}, {Printable(check.fix)}});
  }
  return table.Text(colour) + Counted(CountOf(checks, CheckStatus::kError), "error") + ", " +
         Counted(CountOf(checks, CheckStatus::kWarning), "warning") + "\n";
}

std::string DoctorJson(const std::vector<DoctorCheck>& checks) {
  OrderedJson list = OrderedJson::array();
  for (const DoctorCheck& check : checks) {
    list.push_back({{"check", check.name},
                    {"result", ShownAs(check.health).json},
                    {"reason", check.reason},
                    {"fix", Known(check.fix)}});
  }
  return JsonLine({{"result", ShownAs(Worst(checks)).json}, {"checks", list}});
}

}  // namespace musher::cli
