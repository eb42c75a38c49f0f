#pragma once
// Starting the program of an actuator (see process_supervisor.hpp for what the child gets). The
// caller watches and reaps the child.

#include <optional>

#include "musher/base/program.hpp"
#include "musher/base/result.hpp"
#include "musher/controller/process/process_runner.hpp"

namespace musher {

// Forks. Does not wait for a disk. Threads: any.
Result<ForkedProgram> Spawn(const ProcessSpec& spec);

// The failure for people: a program that does not exist comes with what to install, where that is
// known.
Error ErrorOf(const ProgramFailure& failure, const ForkedProgram& program);

}  // namespace musher
