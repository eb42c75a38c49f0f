#pragma once
// The files of the machine: its state folder, the lock in it and its logs.

#include "musher/cli/doctor/facts.hpp"

namespace musher::cli {

// Reads them with the config of `facts`; each disk gets `timeout` to answer.
void ReadStorage(DoctorFacts& facts, Duration timeout);

}  // namespace musher::cli
