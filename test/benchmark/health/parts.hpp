#pragma once
// The parts of the health benchmark; each starts a machine, measures, and prints a table.

namespace musher::benchmark {

// kill -9 of an actuator on this host → on record as crashed.
void Crash(int rounds);
// The same on another host (a pid namespace), alone there or with others.
void Remote(int rounds);
// A thread that gives no more checkpoints, and a stopped process → on record as hung.
void Hang(int rounds);
// kill -9, or a hang → started again and back in Active.
void Recovery(int rounds);
// A controller is killed → the next one has adopted all its actuators.
void Adoption(int rounds);
// CPU, context switches and traffic of a machine at rest.
void Idle(int seconds);
// Which actuators are detected as lost on a machine with `factor` times its cores busy; an actuator
// loads for `load_ms` in its SetUp, and now and then in its SelfCheck.
void Overload(double minutes, double factor, int load_ms);
// Keeps one core busy; never returns.
[[noreturn]] void Burn();

}  // namespace musher::benchmark
