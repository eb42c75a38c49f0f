#pragma once
// The files of a race for a hall with other measures: only their numbers change. Pure.
//
// A count changes by what its way is longer or shorter than in the base's hall, in whole steps of
// the robot: 0.2 s at the speed of the movement, as odometry shows it (Movement::odometry_share).
// What is tuned in the base stays so, and the base for its own hall is the base itself.
//
// Threads: any.

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "musher/modules/race/course.hpp"
#include "musher/modules/race/hall.hpp"

namespace musher::race {

struct HallMeasure {
  std::string_view key;  // of [hall]
  double Hall::*member;
  std::string_view what;
};
inline constexpr std::array<HallMeasure, 12> kHallMeasures = {{
    {"lane_m", &Hall::lane_m, "a lane's width, between the inner edges of its lines"},
    {"line_m", &Hall::line_m, "a line's width"},
    {"start_m", &Hall::start_m, "the start to lane Q"},
    {"cross_m", &Hall::cross_m, "the START lane to the cross lane A, along lane Q"},
    {"s1_m", &Hall::s1_m, "the START lane to the S lane at S1, along lane Q"},
    {"bay_a_aside_m", &Hall::bay_a_aside_m, "lane Q to the bays A1 and A2"},
    {"bay_a_in_m", &Hall::bay_a_in_m, "the cross lane A back to the place in a bay"},
    {"bay_a_ahead_m", &Hall::bay_a_ahead_m, "this place to the line ahead of it"},
    {"lane_aside_m", &Hall::lane_aside_m, "the S lane at S2 to L1 and R1"},
    {"lane_length_m", &Hall::lane_length_m,
     "L1 and R1: the line behind S2 to that between the bays of zone B"},
    {"bay_b_aside_m", &Hall::bay_b_aside_m, "the S lane at S2 to the bays B1 and B2"},
    {"bay_b_in_m", &Hall::bay_b_in_m, "QR B ahead to the place in a bay"},
}};

// As short as it is exact to 0.1 mm.
std::string MeasureText(double metres);

struct AdaptedFile {
  std::string text;
  std::vector<std::string> changes;  // "state.QRA_TO_A1: forward 23 -> 25 (0.17 m more)"
  std::vector<std::string> open;     // what the measures do not give, and a person has to set
};

// `text` is that of `base`.
AdaptedFile CourseForHall(const Hall& hall, const Course& base, std::string_view text);

// The config of the vision module, as config/vision/course.toml: the lane's width, and where a line
// beside or ahead has to be seen. `base` is the hall that the text is for.
AdaptedFile VisionForHall(const Hall& hall, const Hall& base, std::string_view text);

// The config of the line walker.
AdaptedFile WalkerForHall(const Hall& hall, std::string_view text);

}  // namespace musher::race
