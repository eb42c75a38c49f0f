#pragma once
// Faults of the link between two hosts: the controller on this one, all actuators on the other; or
// the whole robot on this one, and another robot on the other.

#include "musher/test/fault_injection/fault_run.hpp"

namespace musher::fault_injection::network {

void LosesPackets(FaultRun& run);
void IsSlow(FaultRun& run);
void DoublesPackets(FaultRun& run);
void ReordersPackets(FaultRun& run);
void IsCut(FaultRun& run);
// The actuators receive nothing (for less than a DDS lease, or for longer), or nothing is received
// from them.
void IsDeaf(FaultRun& run, bool beyond_lease);
void IsMute(FaultRun& run);
void IsCutInSwitch(FaultRun& run);
// An interface goes down and up again.
void LinkGoesDown(FaultRun& run);
void StoppedWithoutLink(FaultRun& run);
// The other host reboots, several times.
void IsRebooted(FaultRun& run);
// A controller on the other host takes over, and one here takes over again; with `deaf` the other
// host receives nothing from this one meanwhile.
void IsTakenOverFromThere(FaultRun& run, bool deaf);
// A standby on the other host leads once the link is cut for long, or the controller here is
// killed, and not after a short cut.
void IsReplacedByStandby(FaultRun& run, bool killed);
// SIGKILL of an actuator there.
void KilledOnOtherHost(FaultRun& run);

// The whole robot is on this host, whose interface to the others goes down and up again.
void OuterLinkGoesDown(FaultRun& run);
// Another robot comes into range, is used, goes out of range and comes back, and is torn down.
void OtherRobotInRange(FaultRun& run);

}  // namespace musher::fault_injection::network
