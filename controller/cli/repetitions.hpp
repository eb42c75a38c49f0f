#pragma once
// What `musher up` prints of an actuator that ends, perhaps again and again: each line once, then
// how many times the same came again; its reason once, then "as above" where the actuator, the
// switch or the machine repeats it. The controller's log and the journal have all of it.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "musher/controller/cli/progress.hpp"

namespace musher::cli {

class Repetitions {
 public:
  // What is to be printed now, oldest first: nothing where the actuator has been started again and
  // an earlier line says the same but for a process number, a time or a count. To be called with
  // every line, in their order.
  std::vector<Progress> Take(const Progress& progress);

 private:
  struct Loop {
    std::int64_t last_ns = 0;    // of its last line, since 1970
    std::set<std::string> said;  // without numbers that change
    bool restarted = false;      // since then what was said is counted
    int times = 0;               // it was started again and all was said already
  };

  struct Reason {
    std::string actuator;
    std::string text;
    std::int64_t at_ns = 0;  // when it was printed
  };

  std::vector<Progress> NewLines(const Progress& progress);
  void Shorten(Progress& line);

  std::map<std::string, Loop> loops_;  // by actuator
  std::vector<Reason> reasons_;        // that were printed lately, the newest last
};

}  // namespace musher::cli
