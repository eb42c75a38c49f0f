#pragma once
// The table of `musher top`. Pure.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace musher::cli {

// The name of the controller's row; in JSON "controller", as in the logs.
inline constexpr const char* kControllerRow = "(controller)";

struct TopRow {
  std::string name;
  std::string state;   // "" for the controller
  std::string target;  // of a switch under way
  std::string health;
  bool degraded = false;
  bool elsewhere = false;  // its process is on another host
  std::int32_t pid = 0;
  std::optional<double> cpu_percent;  // of one CPU, since the last sample
  std::optional<std::uint64_t> memory_bytes;
  std::optional<std::uint64_t> threads;
  std::optional<double> heartbeat_age_s;   // of its last heartbeat
  std::optional<double> checkpoint_age_s;  // since the last checkpoint, if one is overdue
  std::int32_t restarts = 0;
  std::string event;                  // the last one in the journal
  std::optional<double> event_age_s;  // nullopt: it is by the clock of another computer
};

enum class TopOrder { kConfig, kCpu, kMemory, kName };

struct TopView {
  std::string title;         // the machine, its state, or that there is no controller
  std::vector<TopRow> rows;  // the controller, then the actuators in the order of the config
};

// The controller stays first; equal rows keep their order.
void Sort(std::vector<TopRow>& rows, TopOrder order);

// Lines of at most `width` columns; 0: of any. At most `height` lines; 0: any number.
std::string TopText(const TopView& view, std::size_t width, std::size_t height, bool colour);
std::string TopJson(const TopView& view);
// The same lines as a frame of a terminal: each one replaces the one there.
std::string TopFrame(const std::string& text);

}  // namespace musher::cli
