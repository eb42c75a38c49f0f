#include "musher/test/benchmark/common/fleet.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>

#include "musher/test/benchmark/common/child.hpp"

namespace musher::benchmark {
namespace {

constexpr const char* kStates = R"(["SetUp", "SelfCheck", "Active", "DeActive", "TearDown"])";

std::string NewFolder() {
  std::string folder = std::filesystem::temp_directory_path() / "musher-benchmark-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) Fail("mkdtemp");
  return folder;
}

}  // namespace

Fleet::Fleet(int count, bool started)
    : Fleet(
          [started](const Fleet&, const std::string& name) {
            return started ? CommandKey({Program("benchmark_actuator"), name}) : std::string();
          },
          count) {}

Fleet::Fleet(const Keys& keys, int count, const std::string& more_tables)
    : folder_(NewFolder()), config_file_(folder_ + "/fleet.toml") {
  std::string list;
  std::string tables;
  for (int i = 0; i < count; ++i) {
    const std::string name = "a" + std::to_string(i);
    names_.push_back(name);
    list += '"' + name + "\", ";
    tables += "[actuator." + name + "]\nstates = " + kStates +
              "\ntimes = [60000, 60000, 60000, 60000, 60000]\ncritical = true\n" +
              keys(*this, name);
  }
  std::ofstream(config_file_) << "[controller]\nactuators = [" << list << "]\nstates = " << kStates
                              << "\ndefault_time = 60000\ndefault_state = \"Uninitialized\"\n"
                              << "state_dir = \"" << folder_ << "/state\"\n"
                              << tables << more_tables;
}

Fleet::~Fleet() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::vector<std::string> Fleet::Module(const std::string& name, int hz) const {
  return {Program("benchmark_module"), name, BoardFile(name), std::to_string(hz)};
}

std::string CommandKey(const std::vector<std::string>& argv) {
  std::string key;
  for (const std::string& argument : argv) {
    key += (key.empty() ? "command = [\"" : ", \"") + argument + "\"";
  }
  return key + "]\n";
}

void MustBeDone(const SwitchResult& result) {
  if (result.done()) return;
  Fail("the switch to " + result.target + " ended as " + std::string(OutcomeName(result.outcome)) +
       ": " + result.reason);
}

}  // namespace musher::benchmark
