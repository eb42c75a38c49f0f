#include "musher/cli/grammar/examples.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace musher::cli {
namespace {

using Example = std::pair<std::string_view, std::string_view>;

constexpr auto kExamples = std::to_array<Example>({
    {"check", "musher check robot.toml"},
    {"new", "musher new module gripper --language python"},
    {"doctor", "musher doctor robot.toml"},
    {"explain", "musher explain policy.battery.protected_at"},
    {"diff", "musher diff old.toml robot.toml"},
    {"graph", "musher graph robot.toml --what actuators -o robot.svg"},
    {"prove", "musher prove robot.toml --faults 1 --budget 600"},
    {"simulate", "musher simulate robot.toml --seeds 10000"},
    {"tree", "musher tree check mission.xml"},
    {"up", "musher up robot.toml --detach"},
    {"down", "musher down"},
    {"poweroff", "musher poweroff"},
    {"reboot", "musher reboot"},
    {"status", "musher status --follow"},
    {"describe", "musher describe audio"},
    {"top", "musher top --interval 2"},
    {"capabilities", "musher capabilities back_flip"},
    {"set", "musher set LowPower audio"},
    {"wait", "musher wait Active --timeout 30"},
    {"restart", "musher restart audio"},
    {"estop", "musher estop \"smoke\""},
    {"permit", "musher permit"},
    {"plan", "musher plan LowPower"},
    {"wake", "musher wake"},
    {"keep", "musher keep Active --for 60"},
    {"low-power", "musher low-power off --this-run"},
    {"behavior", "musher behavior show --follow"},
    {"skill", "musher skill run take_off altitude=2"},
    {"history", "musher history --since 10m --actuator audio"},
    {"logs", "musher logs -f audio motion_manager --level warning"},
    {"replay", "musher replay journal.sqlite --config robot.toml"},
    {"times", "musher times robot.toml --since 7d"},
    {"topic", "musher topic echo /scan"},
    {"view", "musher view"},
    {"record", "musher record -o run.mcap"},
    {"play", "musher play run.mcap"},
    {"keys", "musher keys init robot.toml"},
    {"ota", "musher ota install release-2"},
    {"deploy", "musher deploy robot.toml --version 1.4.0 --key robot.key"},
    {"completion", "musher completion bash"},
});

}  // namespace

std::string_view ExampleOf(std::string_view command) {
  const auto* const found =
      std::find_if(kExamples.begin(), kExamples.end(),
                   [&](const Example& example) { return example.first == command; });
  return found == kExamples.end() ? std::string_view() : found->second;
}

}  // namespace musher::cli
