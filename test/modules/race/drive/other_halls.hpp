#pragma once
// The twelve other halls in which the course is driven: each with its own lanes, lines, S curve,
// slip, floor and light, and what its boards show.
//
// Threads: any.

#include <cstdint>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "musher/test/modules/race/drive/course_drive.hpp"

namespace musher::race::testing {

struct Route {
  std::uint64_t seed;
  std::map<std::string, std::string> chosen;
  bool yellow_light = false;
  std::optional<double> slip = {};
  std::set<std::string> unseen = {};
};
inline void PrintTo(const Route& route, std::ostream* out) {
  *out << "seed " << route.seed;
}

struct HallCase {
  int number;
  Route route;
  OtherHall hall;
  std::string until = {};
  bool ends = false;  // it is known to reach END
};
inline void PrintTo(const HallCase& hall, std::ostream* out) {
  *out << "hall " << hall.number;
}

// By their numbers, from 1 on.
const std::vector<HallCase>& Halls();

}  // namespace musher::race::testing
