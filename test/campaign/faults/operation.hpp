#pragma once
// What people do at the wrong moment.

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::operation {

void EmergencyStopAtRest(Trial& trial);
void EmergencyStopInSwitch(Trial& trial);
// Error over a switch that is under way.
void Superseded(Trial& trial);
// Many calls at once; one of them leads, the others are told.
void ManyCalls(Trial& trial);

}  // namespace musher::campaign::operation
