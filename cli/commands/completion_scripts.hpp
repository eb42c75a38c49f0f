#pragma once
// The scripts of completion/, embedded by CMake.

namespace musher::cli {

extern const char* const kBashCompletion;
extern const char* const kZshCompletion;
extern const char* const kFishCompletion;

}  // namespace musher::cli
