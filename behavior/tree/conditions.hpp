#pragma once
// The scripts before and after a node: _failureIf, _successIf, _skipIf, _while, _onSuccess,
// _onFailure, _onHalted, _post. The conditions are evaluated in this order.

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>

#include "musher/behavior/tree/script.hpp"
#include "musher/behavior/tree/status.hpp"

namespace musher::tree {

inline constexpr std::array<std::string_view, 8> kConditionNames = {
    "_failureIf", "_successIf", "_skipIf",   "_while",
    "_onSuccess", "_onFailure", "_onHalted", "_post"};
inline constexpr std::size_t kConditionsBefore = 4;  // the first ones

struct Conditions {
  std::array<std::unique_ptr<const Script>, kConditionNames.size()> scripts;  // most are null

  // The status that a node that is not running gets instead of its tick.
  std::optional<Status> BeforeStart() const;
  // False: a running node has to stop.
  bool MayContinue() const;
  void AfterCompleted(Status status) const;
  void AfterHalt() const;
};

}  // namespace musher::tree
