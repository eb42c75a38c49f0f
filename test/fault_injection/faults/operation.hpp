#pragma once
// Operator requests at the wrong time.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::operation {

void EmergencyStopAtRest(FaultRun& run);
void EmergencyStopInSwitch(FaultRun& run);
// Error is requested during a switch.
void Superseded(FaultRun& run);
// Several simultaneous requests; one is executed, the others are refused.
void ManyCalls(FaultRun& run);

}  // namespace musher::fault_injection::operation
