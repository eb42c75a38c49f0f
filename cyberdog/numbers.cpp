#include "musher/cyberdog/numbers.hpp"

#include <algorithm>
#include <array>

#include "musher/messages/protocol/manager.hpp"

namespace musher::cyberdog {
namespace {

struct Row {
  std::string_view state;
  std::uint8_t number;  // of protocol/MachineState
  std::int32_t status;  // of protocol/StateSwitchStatus
  std::string_view text;
};

using Number = msg::MachineState;
using Status = msg::StateSwitchStatus;

// CyberDog's manager has no text for DeActive, which it never enters.
constexpr std::array<Row, 8> kRows = {{
    {kActive, Number::kActive, Status::kActive, "active"},
    {kProtected, Number::kProtect, Status::kProtected, "protected"},
    {kLowPower, Number::kLowPower, Status::kLowPower, "lowpower"},
    {kOta, Number::kOta, Status::kOta, "ota"},
    {kTearDown, Number::kShutdown, Status::kShutdown, "shutdown"},
    {kSelfCheck, Number::kSelfCheck, Status::kUnknown, "selfcheck"},
    {kDeActive, Number::kDeActive, Status::kUnknown, "deactive"},
    {kError, Number::kError, Status::kError, "error-state"},
}};

const Row* RowOf(std::string_view state) {
  const auto* const row =
      std::find_if(kRows.begin(), kRows.end(), [state](const Row& r) { return r.state == state; });
  return row == kRows.end() ? nullptr : row;
}

}  // namespace

std::optional<State> StateOfNumber(std::uint8_t number) {
  const auto* const row = std::find_if(kRows.begin(), kRows.end(),
                                       [number](const Row& r) { return r.number == number; });
  if (row == kRows.end()) return std::nullopt;
  return State(row->state);
}

std::string_view TextOf(std::string_view state) {
  const Row* row = RowOf(state);
  return row == nullptr ? "unkown" : row->text;
}

std::int32_t StatusNumberOf(std::string_view state) {
  const Row* row = RowOf(state);
  return row == nullptr ? Status::kUnknown : row->status;
}

bool IsPublishedAtBegin(std::string_view state) {
  return state == kLowPower || state == kOta || state == kTearDown;
}

}  // namespace musher::cyberdog
