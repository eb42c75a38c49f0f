#pragma once
// Filters what `musher up` prints of an actuator that exits repeatedly: each line once, then how
// often it repeated; its reason once, then "as above" where the actuator, the switch or the machine
// repeats it. The controller's log and the journal have all lines.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "musher/cli/start/progress.hpp"

namespace musher::cli {

class Repetitions {
 public:
  // The lines to print now, oldest first: none if the actuator was restarted and an earlier line
  // has the same event and reason; process numbers, times and counts may differ. To be called with
  // every line, in order.
  std::vector<Progress> Take(const Progress& progress);

 private:
  struct Loop {
    std::int64_t last_ns = 0;    // time of its last line, since 1970
    std::set<std::string> said;  // of the lines printed: event and reason
    bool restarted = false;      // from then on repeated lines are only counted
    int times = 0;               // restarts without any new line
  };

  struct Reason {
    std::string actuator;
    std::string text;
    std::int64_t at_ns = 0;  // when it was printed
  };

  std::vector<Progress> NewLines(const Progress& progress);
  void Shorten(Progress& line);

  std::map<std::string, Loop> loops_;  // by actuator
  std::vector<Reason> reasons_;        // printed recently, the newest last
};

}  // namespace musher::cli
