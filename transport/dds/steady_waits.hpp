#pragma once
// Cyclone's threads wait by the steady clock, see steady_waits.cpp.

namespace musher::transport::dds {

// Does nothing: a program that calls it has the waits.
void LinkSteadyWaits();

}  // namespace musher::transport::dds
