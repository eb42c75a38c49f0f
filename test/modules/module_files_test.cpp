// Every program of a module refuses an invalid file with exit code 2 and the place of the error.

#include <gmock/gmock.h>

#include <fstream>
#include <string>

#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::module_files_test {

struct Case {
  const char* actuator;
  const char* program;
  const char* file;  // its text
  const char* said;
};

constexpr Case kCases[] = {
    {"RealSenseActuator", "musher-camera-manager", "[camera.front]\ntopic = 3\n",
     "file.toml:2:9: error: camera.front.topic"},
    {"audio", "musher-audio-manager", "output = \"radio\"\n", "file.toml:1:10: error: output"},
    {"controller_server", "musher-controller", "[[robot]]\nname = \"a\"\nspeed_m_s = -1\n",
     "file.toml:3:13: error: robot.speed_m_s"},
    {"device_manager", "musher-device-manager", "[battery]\nsource = \"bucket\"\n",
     "file.toml:2:10: error: battery.source"},
    {"planner_server", "musher-planner", "[[robot]]\nname = 3\n",
     "file.toml:2:8: error: robot.name"},
    {"route_server", "musher-route", "graph = \"g.geojson\"\n[[robot]]\nname = \"a\"\n",
     "file.toml: error: graph: "},
    {"sensor_manager", "musher-sensor-manager", "[lidar]\nsource = \"scan\"\n",
     "file.toml:2:10: error: lidar.source"},
    {"wedding", "musher-wedding", "[idle]\nsway = 3\n", "file.toml:2:8: error: idle.sway"},
    {"yellow_line_walker", "musher-line-walker", "[lane]\nwidth_m = -1\n",
     "file.toml:2:11: error: lane.width_m"},
};

TEST(ProgramOfAModule, RefusesAnInvalidFileWithThePlaceOfTheError) {
  const TempFolder folder;
  for (const Case& one : kCases) {
    const std::string actuator = one.actuator;
    std::ofstream(folder / "machine.toml")
        << "[controller]\nactuators = [\"" + actuator +
               "\"]\nstates = [\"SetUp\", \"Active\"]\ndefault_time = 20000\n"
               "default_state = \"Uninitialized\"\n[actuator." +
               actuator + "]\nstates = [\"SetUp\", \"Active\"]\ntimes = [20000, 20000]\n";
    std::ofstream(folder / "file.toml") << one.file;
    const testing::Ended ended =
        testing::RunToEnd({BinDir() + "/" + one.program, "--actuator", actuator, "--config",
                           folder / "machine.toml", folder / "file.toml"});
    EXPECT_EQ(ended.exit, 2) << one.program;
    EXPECT_THAT(ended.out + ended.err, ::testing::HasSubstr(one.said)) << one.program;
  }
}

}  // namespace musher::module_files_test
