#pragma once
// An instrumented source checks at every place that can be changed whether it is, in this run.
// One binary holds all mutants; MUSHER_MUTANT=n chooses one, without it the code is as written.

#include <bitset>
#include <cstddef>
#include <cstdlib>

namespace musher::mutation {

inline constexpr std::size_t kMost = 8192;

inline const std::size_t chosen = [] {
  const char* number = std::getenv("MUSHER_MUTANT");
  return number == nullptr ? 0 : std::strtoul(number, nullptr, 10);
}();

inline std::bitset<kMost> reached;  // since it was cleared

inline bool Active(std::size_t mutant) {
  reached[mutant] = true;
  return mutant == chosen;
}

}  // namespace musher::mutation
