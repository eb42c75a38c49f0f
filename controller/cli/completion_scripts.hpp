#pragma once
// The texts of completion/, built in by CMake.

namespace musher::cli {

extern const char* const kBashCompletion;
extern const char* const kZshCompletion;

}  // namespace musher::cli
