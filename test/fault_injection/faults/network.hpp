#pragma once
// What happens between two hosts: the controller on this side, all actuators on the other.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::network {

void LosesPackets(FaultRun& run);
void IsSlow(FaultRun& run);
void DoublesPackets(FaultRun& run);
void ReordersPackets(FaultRun& run);
void IsCut(FaultRun& run);
// The actuators hear nothing (for less than a lease of DDS, or for longer), or are not heard.
void IsDeaf(FaultRun& run, bool beyond_lease);
void IsMute(FaultRun& run);
void IsCutInSwitch(FaultRun& run);
// An interface goes down and up again.
void LinkGoesDown(FaultRun& run);
void StoppedWithoutLink(FaultRun& run);
// The other host is started again, several times.
void IsRebooted(FaultRun& run);
// A controller on the other host takes the machine over, and one here takes it back; with `deaf`
// the other host hears nothing of this one meanwhile.
void IsTakenOverFromThere(FaultRun& run, bool deaf);
// SIGKILL of an actuator there.
void KilledFarAway(FaultRun& run);

}  // namespace musher::fault_injection::network
