#pragma once
// The checks of `musher doctor`: each is a function of the facts, and names what is wrong, the
// numbers found, and the command that fixes it.
//
// Pure; threads: any.

#include <string>
#include <utility>
#include <vector>

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

enum class CheckStatus { kNotApplicable, kOk, kWarning, kError };  // the worst last

struct DoctorCheck {
  std::string name;
  CheckStatus health = CheckStatus::kOk;
  std::string reason = {};
  std::string fix = {};  // a command, or what to change; empty: nothing to do
};

// The check, which cannot be done here, and why.
inline DoctorCheck NotApplicable(DoctorCheck check, std::string reason) {
  check.health = CheckStatus::kNotApplicable;
  check.reason = std::move(reason);
  return check;
}

// All checks, in a fixed order.
std::vector<DoctorCheck> Diagnose(const DoctorFacts& facts);

// The checks by subject; each list is part of Diagnose().
std::vector<DoctorCheck> CheckNetwork(const DoctorFacts& facts);
std::vector<DoctorCheck> CheckHost(const DoctorFacts& facts);
std::vector<DoctorCheck> CheckStorage(const DoctorFacts& facts);
std::vector<DoctorCheck> CheckMachine(const DoctorFacts& facts);
std::vector<DoctorCheck> CheckHosts(const DoctorFacts& facts);  // whose systemd runs actuators
inline constexpr const char* kOwnUnitsCheck = "units";          // the name of that of this host

CheckStatus Worst(const std::vector<DoctorCheck>& checks);

}  // namespace musher::cli
