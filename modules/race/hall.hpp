#pragma once
// The measures of a hall, for which the counts of a course are: the table [hall] of its file.
// course_for_hall.hpp changes the counts for a hall with others. A race itself does not use them.
//
//               L1 ------------- bar --------------+  B1
//   START  Q    |                                  |
//   =====+--S1~~~S2 (arrow)                   QR B |
//   A1   |  A2  |                                  |
//   =====+===== R1 ----------- marker -------------+  B2
//        board A
//
// Lengths are metres, from the axis of a lane to that of another one, and to the middle of a body.
//
// Threads: plain values.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::race {

struct Hall {
  double lane_m = 0.83;         // a lane's width, between the inner edges of its lines
  double line_m = 0.05;         // a line's width
  double start_m = 0.93;        // the start to lane Q
  double cross_m = 1.82;        // the START lane to the cross lane A, along lane Q
  double s1_m = 0.4;            // the START lane to the S lane at S1, along lane Q
  double bay_a_aside_m = 1.23;  // lane Q to the bays A1 and A2
  double bay_a_in_m = 0.54;     // the cross lane A back to the place in a bay
  double bay_a_ahead_m = 1.0;   // this place to the line ahead of it
  double lane_aside_m = 1.3;    // the S lane at S2 to L1 and R1
  double lane_length_m = 9.25;  // L1 and R1: the line behind S2 to that between the bays of zone B
  double bay_b_aside_m = 1.42;  // the S lane at S2 to the bays B1 and B2
  double bay_b_in_m = 0.7;      // QR B ahead to the place in a bay

  double pitch_m() const { return lane_m + line_m; }  // between the middles of a lane's lines
  double half_m() const { return pitch_m() / 2; }     // a lane's axis to the middle of a line

  friend bool operator==(const Hall&, const Hall&) = default;
};

// The keys of [hall], with the names of the members; each keeps its value where it is missing.
config_toml::Rows HallRows(Hall& hall);

struct HallReading {
  std::optional<Hall> hall;             // present exactly when no diagnostic is an error
  std::vector<Diagnostic> diagnostics;  // by line
};

// A file of these keys alone; what it lacks is as in `base`. Never throws; an unreadable file is a
// diagnostic.
HallReading ReadHallFile(const std::string& path, const Hall& base);
HallReading ReadHallText(std::string_view text, const std::string& path, const Hall& base);

}  // namespace musher::race
