#include "musher/simulation/coverage.hpp"

#include <algorithm>
#include <numeric>

namespace musher::simulation {
namespace {

std::string Padded(std::string text, std::size_t width, bool left) {
  if (text.size() >= width) return text;
  const std::string blank(width - text.size(), ' ');
  return left ? text + blank : blank + text;
}

}  // namespace

void Coverage::Add(const Coverage& other) {
  for (std::size_t kind = 0; kind < kInjectionKinds; ++kind) {
    for (std::size_t phase = 0; phase < kMachinePhases; ++phase) {
      counts_[kind][phase] += other.counts_[kind][phase];
    }
  }
}

std::uint64_t Coverage::Of(InjectionKind kind) const {
  const auto& row = counts_[static_cast<std::size_t>(kind)];
  return std::accumulate(row.begin(), row.end(), std::uint64_t{0});
}

std::string Coverage::Text() const {
  constexpr std::size_t kFirst = 18;
  constexpr std::size_t kColumn = 7;  // for a word, or millions
  std::string heads[2] = {Padded("", kFirst, true), Padded("", kFirst, true)};
  for (std::size_t phase = 0; phase < kMachinePhases; ++phase) {
    const std::string name(MachinePhaseName(static_cast<MachinePhase>(phase)));  // one word or two
    const std::size_t space = std::min(name.find(' '), name.size());
    heads[0] += " " + Padded(name.substr(0, space), kColumn, false);
    heads[1] += " " + Padded(name.substr(std::min(space + 1, name.size())), kColumn, false);
  }
  std::string text = heads[0] + "\n" + heads[1] + "\n";
  for (std::size_t kind = 0; kind < kInjectionKinds; ++kind) {
    text += Padded(std::string(KindName(static_cast<InjectionKind>(kind))), kFirst, true);
    for (std::size_t phase = 0; phase < kMachinePhases; ++phase) {
      const std::uint64_t count = counts_[kind][phase];
      text += " " + Padded(count == 0 ? "-" : std::to_string(count), kColumn, false);
    }
    text += "\n";
  }
  return text;
}

}  // namespace musher::simulation
