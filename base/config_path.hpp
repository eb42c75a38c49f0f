#pragma once
// Which state config a program uses.
//
// Threads: any, as long as none changes the environment.

#include <string>

namespace musher {

// `given`, or if that is empty, the file that MUSHER_CONFIG names. A controller sets the variable
// for the processes that it starts. Empty: neither names a file.
std::string ConfigPath(const std::string& given);

}  // namespace musher
