#pragma once
// The output of `musher doctor`.

#include <string>
#include <vector>

#include "musher/cli/doctor/checks.hpp"

namespace musher::cli {

// A line for each check, and below what is wrong the command that fixes it.
std::string DoctorText(const std::vector<DoctorCheck>& checks, bool colour);
std::string DoctorJson(const std::vector<DoctorCheck>& checks);

}  // namespace musher::cli
