#pragma once
// Where the tests find files of the source tree and programs of the build. Functions and not
// macros: one object file differs from one clone to another, and the compiler cache has the rest.

#include <string>

namespace musher {

std::string SourceDir();  // of the whole tree
std::string BuildDir();   // of the whole build
std::string BinDir();     // of all programs

}  // namespace musher
