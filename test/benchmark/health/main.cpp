// Health, recovery and authority with real processes: how soon a loss is known, how soon it is made
// good, what that costs while nothing happens, and which actuators are wrongly detected as lost.
//
//   benchmark_health                                    all parts
//   benchmark_health crash|remote|hang|recovery|adoption [ROUNDS]
//   benchmark_health idle [SECONDS]
//   benchmark_health overload [--minutes M] [--factor F]
//
// --smoke instead of a size: as little as shows that it works.

#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/health/parts.hpp"

namespace musher::benchmark {
namespace {

struct Part {
  std::function<void(int)> run;
  int size = 0;
  int smoke = 0;
};

const std::map<std::string_view, Part> kParts = {
    {"crash", {Crash, 50, 2}},       {"remote", {Remote, 4, 1}},     {"hang", {Hang, 25, 1}},
    {"recovery", {Recovery, 20, 1}}, {"adoption", {Adoption, 5, 1}}, {"idle", {Idle, 30, 1}},
};

int OverloadMain(const std::vector<std::string>& arguments) {
  double minutes = 1;
  double factor = 4;
  int load_ms = 22'000;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--smoke") {
      minutes = 0.05;
      load_ms = 300;
    } else if (i + 1 == arguments.size()) {
      Fail("no value for " + arguments[i]);
    } else if (arguments[i] == "--minutes") {
      minutes = std::atof(arguments[++i].c_str());
    } else if (arguments[i] == "--factor") {
      factor = std::atof(arguments[++i].c_str());
    } else {
      Fail("unknown: " + arguments[i]);
    }
  }
  Overload(minutes, factor, load_ms);
  return EXIT_SUCCESS;
}

// Each in a process of its own: parts leave actuators behind, which die with it.
int All() {
  for (const char* part : {"crash", "remote", "hang", "recovery", "adoption", "idle", "overload"}) {
    if (Child({Program("benchmark_health"), part}).Wait() != EXIT_SUCCESS) return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

int Main(const std::vector<std::string>& arguments) {
  if (arguments.empty()) return All();
  const std::string& name = arguments.front();
  const std::vector<std::string> rest(arguments.begin() + 1, arguments.end());
  if (name == "burn") Burn();
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  if (name == "overload") return OverloadMain(rest);
  const auto part = kParts.find(name);
  if (part == kParts.end()) Fail("no part of this name: " + name);
  int size = part->second.size;
  if (!rest.empty()) size = rest[0] == "--smoke" ? part->second.smoke : std::atoi(rest[0].c_str());
  part->second.run(size);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  return musher::benchmark::Main({argv + 1, argv + argc});
}
