#pragma once
// What happens between two hosts: the controller on this side, all actuators on the other.

#include "musher/test/campaign/trial.hpp"

namespace musher::campaign::network {

void LosesPackets(Trial& trial);
void IsSlow(Trial& trial);
void DoublesPackets(Trial& trial);
void ReordersPackets(Trial& trial);
void IsCut(Trial& trial);
// The actuators hear nothing (for less than a lease of DDS, or for longer), or are not heard.
void IsDeaf(Trial& trial, bool beyond_lease);
void IsMute(Trial& trial);
void IsCutInSwitch(Trial& trial);
// An interface goes down and up again.
void LinkGoesDown(Trial& trial);
void StoppedWithoutLink(Trial& trial);
// The other host is started again, several times.
void IsRebooted(Trial& trial);
// A controller on the other host takes the machine over, and one here takes it back; with `deaf`
// the other host hears nothing of this one meanwhile.
void IsTakenOverFromThere(Trial& trial, bool deaf);
// SIGKILL of an actuator there.
void KilledFarAway(Trial& trial);

}  // namespace musher::campaign::network
