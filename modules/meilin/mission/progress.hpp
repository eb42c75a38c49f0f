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
//   wheels_mm = "20 20 20 20"
//
// A plan has a number, and one that was taken is not taken again: when its message was written. For
// a service its content is the number (NumberOf), also where a message has brought it, until the
// service has said that it has none.
// Pure functions; they never throw.

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/std_msgs/multi_array.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

struct Progress {
  std::int64_t plans = 0;                 // that were accepted, in all processes
  std::vector<std::int64_t> taken_plans;  // numbers of the last of them: ns of the writer, or < 0
  std::string plan_id;
  std::vector<PlanStep> plan;  // the present one
  std::string segments;        // or one of the old form, as JSON; empty: none, or it is done
  std::int64_t next = 0;       // its first step that is not done
  bool begun = false;          // a step of it; else it waits for the start of the match
  std::set<std::string> done;  // parts of the match: "prepare_dock_done"
  Cell cell;
  double height_mm = 0;
  double yaw_rad = 0;
  bool at_centre = true;
  double offset_mm = 0;           // of the wheels
  std::vector<double> wheels_mm;  // as the four reported last, to 15 mm; empty: never
  bool climbing = false;          // a climb was begun and not ended
  std::int64_t taken = 0;         // bits of the cells whose boxes were taken
  std::string last_end;           // "MISSION_FAILED: segment 4 of 9, …"
  std::string side = "blue";
  bool stands = false;  // its debugger was lost: until a start

  friend bool operator==(const Progress&, const Progress&) = default;

  bool IsTaken(std::int64_t written_ns) const;
  void Take(std::int64_t written_ns);  // the last 32 are kept, of the services the last one
  void ForgetHandedOut();              // a service has said that it has none
  // Whether there is nothing to go on with.
  bool empty() const {
    return !stands && done.empty() && segments.empty() &&
           next >= static_cast<std::int64_t>(plan.size());
  }
};

// Of a plan whose message has no time: made of its content, negative.
std::int64_t NumberOf(const msg::Float32MultiArray& plan);

std::string WriteProgress(const Progress& progress);
// Fails with each error and its line; `file` is its name in them.
Result<Progress> ReadProgress(std::string_view text, const std::string& file);

}  // namespace musher::meilin
