#pragma once
// What of a match outlives its process: which plan it carries out and how far, what is done, where
// the robot is by what it has done. Saved by name, like the states of a machine
// (behavior/fsm/archive.hpp), as a TOML file that a person can read.
//
//   plans = 3
//   plan_id = "mf_action_seq_3"
//   plan = "move 0 1 0 0; fetch 1 1 200 0"
//   next = 1
//   done = "prepare_spear_done prepare_grasp_done"
//
// A plan has a number: when its message was written. One that was taken is not taken again.
// Pure functions; they never throw.

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"

namespace musher::meilin {

struct Progress {
  std::int64_t plans = 0;                 // that were accepted, in all processes
  std::vector<std::int64_t> taken_plans;  // when the last of them were written, ns of the writer
  std::string plan_id;
  std::vector<PlanStep> plan;  // the present one
  std::int64_t next = 0;       // its first step that is not done
  std::set<std::string> done;  // parts of the match: "prepare_dock_done"
  Cell cell;
  double height_mm = 0;
  double yaw_rad = 0;
  bool at_centre = true;
  double offset_mm = 0;    // of the wheels
  bool climbing = false;   // a climb was begun and not ended
  std::int64_t taken = 0;  // bits of the cells whose boxes were taken
  std::string last_end;    // "MISSION_FAILED: segment 4 of 9, …"
  std::string side = "blue";

  friend bool operator==(const Progress&, const Progress&) = default;

  bool IsTaken(std::int64_t written_ns) const;
  void Take(std::int64_t written_ns);  // the last 32 are kept
  // Whether there is something to go on with.
  bool empty() const { return done.empty() && next >= static_cast<std::int64_t>(plan.size()); }
};

std::string WriteProgress(const Progress& progress);
// Fails with each error and its line; `file` is its name in them.
Result<Progress> ReadProgress(std::string_view text, const std::string& file);

}  // namespace musher::meilin
