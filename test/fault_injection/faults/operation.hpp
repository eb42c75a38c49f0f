#pragma once
// What people do at the wrong moment.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::operation {

void EmergencyStopAtRest(FaultRun& run);
void EmergencyStopInSwitch(FaultRun& run);
// Error over a switch that is under way.
void Superseded(FaultRun& run);
// Many calls at once; one of them leads, the others are told.
void ManyCalls(FaultRun& run);

}  // namespace musher::fault_injection::operation
