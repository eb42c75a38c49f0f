#include "musher/cli/console/error_json.hpp"

#include <nlohmann/json.hpp>

#include "musher/cli/console/json_line.hpp"

namespace musher::cli {
namespace {

OrderedJson Of(const Diagnostic& d) {
  return {{"file", Known(d.file)},
          {"line", Known(d.line)},
          {"column", Known(d.column)},
          {"severity", SeverityName(d.severity)},
          {"message", d.message}};
}

OrderedJson Of(const std::vector<Diagnostic>& diagnostics) {
  OrderedJson list = OrderedJson::array();
  for (const Diagnostic& d : diagnostics) list.push_back(Of(d));
  return list;
}

}  // namespace

std::string FailureJson(const Failure& failure) {
  return JsonLine({{"error", failure.error.message},
                   {"code", failure.error.code},
                   {"switch", Known(failure.switch_number.value())},
                   {"diagnostics", OrderedJson::array()}});
}

std::string CheckJson(const std::vector<Diagnostic>& diagnostics) {
  return JsonLine({{"valid", !HasError(diagnostics)}, {"diagnostics", Of(diagnostics)}});
}

std::string BadConfigJson(const std::string& file, const std::vector<Diagnostic>& diagnostics) {
  return JsonLine({{"error", file + " is not a valid state config"},
                   {"code", kCodeParametersInvalid},
                   {"switch", nullptr},
                   {"diagnostics", Of(diagnostics)}});
}

}  // namespace musher::cli
