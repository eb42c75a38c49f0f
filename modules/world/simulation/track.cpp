#include "musher/modules/world/simulation/track.hpp"

#include <algorithm>
#include <utility>

namespace musher::world {
namespace {

constexpr std::size_t kMostBumps = 200;
constexpr std::size_t kMostMarks = 50;
constexpr std::size_t kLongestMark = 60;  // bytes
constexpr std::size_t kMostNames = 200;   // of states; another publisher may invent any number

std::uint16_t IndexOf(const std::string& name, std::vector<std::string>& names) {
  auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    if (names.size() >= kMostNames) return 0;
    found = names.insert(names.end(), name);
  }
  return static_cast<std::uint16_t>(found - names.begin());
}

}  // namespace

void Track::Add(Sample sample, const std::string& machine_state, const std::string& motion) {
  sample.machine_state = IndexOf(machine_state, states_);
  sample.motion = IndexOf(motion, motions_);
  if (samples_.size() >= kMost) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < samples_.size(); i += 2) samples_[kept++] = samples_[i];
    samples_.resize(kept);
    period_ *= 2;
  }
  samples_.push_back(sample);
}

void Track::AddBump(const Bump& bump) {
  if (bumps_.size() < kMostBumps) bumps_.push_back(bump);
}

void Track::AddMark(Mark mark) {
  if (marks_.size() >= kMostMarks) return;
  mark.text.resize(std::min(mark.text.size(), kLongestMark));
  marks_.push_back(std::move(mark));
}

}  // namespace musher::world
