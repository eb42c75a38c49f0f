#pragma once
// The machine of examples/ros2_stack as a person without ROS 2 has it: its own config, its own
// stand-ins for `ros2`, the real `musher` program.

#include <signal.h>

#include <algorithm>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing {

class Ros2Stack : public MachineByCli {
 protected:
  Ros2Stack() {
    for (const char* name : {"MUSHER_NAMESPACE", "CYCLONEDDS_URI", "RMW_IMPLEMENTATION",
                             "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE"}) {
      unsetenv(name);
    }
    setenv("XDG_STATE_HOME", (folder_ / "state").c_str(), 1);
    std::filesystem::copy(SourceDir() + "/examples/ros2_stack", stack_,
                          std::filesystem::copy_options::recursive);
    std::filesystem::create_directory(stack_ + "/build");
    std::filesystem::create_symlink(BinDir() + "/managed_node", stack_ + "/build/managed_node");
    WriteRos2();
    SetPath(folder_ / "bin:");
  }

  // The folders before those of a shell without ROS 2.
  static void SetPath(const std::string& before) {
    setenv("PATH", (before + BinDir() + ":/usr/bin:/bin").c_str(), 1);
  }

  Ended Up() const { return testing::UpDetached(robot_); }

  // All that the stand-ins have printed, in the order of time: "amcl: on_activate".
  std::vector<std::string> Events() const {
    std::ifstream file(events_);
    std::vector<std::string> lines;
    for (std::string line; std::getline(file, line);) lines.push_back(line);
    return lines;
  }
  // What they have printed since the last call.
  std::vector<std::string> NewEvents() {
    const auto all = Events();
    const std::vector<std::string> latest(all.begin() + static_cast<std::ptrdiff_t>(seen_),
                                          all.end());
    seen_ = all.size();
    return latest;
  }
  // The place of a line among `events`; behind all of them if it is not there.
  static std::ptrdiff_t Place(const std::vector<std::string>& events, const std::string& line) {
    return std::find(events.begin(), events.end(), line) - events.begin();
  }
  std::string Lamp() const {
    std::ifstream file(stack_ + "/lamp");
    std::string text;
    std::getline(file, text);
    return text;
  }
  static nlohmann::json Actuator(const std::string& name) { return Status()["actuators"][name]; }

  const std::string stack_ = folder_ / "stack";
  const std::string robot_ = stack_ + "/robot.toml";

 private:
  // The stand-in of the example, with its output in one file.
  void WriteRos2() const {
    const std::string path = folder_ / "bin/ros2";
    std::filesystem::create_directory(folder_ / "bin");
    std::ofstream(path) << "#!/bin/sh\nexec >> " << events_ << " 2>&1\nexec " << stack_
                        << "/without_ros/ros2 \"$@\"\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  }

  const std::string events_ = folder_ / "events";
  std::size_t seen_ = 0;
};

}  // namespace musher::testing
