#pragma once
// The referee's report of a run, as text for a person and as JSON. Pure functions; no errors.

#include <string>
#include <vector>

#include "musher/modules/world/simulation/referee.hpp"

namespace musher::world {

// The zones of a run beside the order that the scene demands.
struct ZonesInOrder {
  std::vector<bool> in_order;            // of each visit
  std::vector<std::string> missing;      // before the last zone that was reached in order
  std::vector<std::string> ahead;        // after it
  std::vector<std::string> out_of_turn;  // zones to lie in, where it lay at another time
};

// The longest part of the order that the visits have in it counts as reached. Passing through a
// zone again is no fault.
ZonesInOrder CompareZones(const Scene& scene, const std::vector<ZoneVisit>& visits);

std::string RefereeText(const Scene& scene, const Referee& referee, Duration now);

// One object on one line: name, seed, sampled, finished, time_s, reached, missing, ahead,
// out_of_turn, lines, collisions, moved_by_hand; see ../README.md.
std::string RefereeJson(const Scene& scene, const Referee& referee, Duration now);

}  // namespace musher::world
