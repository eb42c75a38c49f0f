#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "musher/base/program_path.hpp"
#include "musher/modules/motion/tool/commands.hpp"

namespace musher::motion::tool {
namespace {

namespace fs = std::filesystem;

// Next to an installed program, or in the tree that it was built in.
std::string TableFile() {
  const fs::path bin = OwnProgram().parent_path();
  const fs::path installed = bin / "../share/musher/config/motion/motions.toml";
  std::error_code error;
  if (fs::exists(installed, error)) return installed.lexically_normal();
  return (bin / "../../../config/motion/motions.toml").lexically_normal();
}

std::string DurationText(const Motion& motion) {
  if (motion.min_exec_time_ms < 0) return "needed";
  if (motion.min_exec_time_ms == 0) return "any";
  return std::to_string(motion.min_exec_time_ms) + " ms";
}

std::string Column(const std::string& text, std::size_t width) {
  return text + std::string(text.size() < width ? width - text.size() : 0, ' ') + "  ";
}

void PrintJson(const MotionTable& table) {
  nlohmann::json list = nlohmann::json::array();
  for (const Motion& motion : table.motions()) {
    nlohmann::json row = {{"id", motion.id},
                          {"name", motion.name},
                          {"mode", motion.mode},
                          {"gait", motion.gait},
                          {"min_exec_time_ms", motion.min_exec_time_ms},
                          {"next", motion.next}};
    if (!motion.capability.empty()) row["capability"] = motion.capability;
    if (!motion.servo.empty()) row["servo"] = motion.servo;
    if (motion.limit) row["limit"] = *motion.limit;
    list.push_back(std::move(row));
  }
  std::cout << list.dump(2) << std::endl;
}

void PrintText(const MotionTable& table) {
  std::cout << "  id  name                     duration   capability     servo\n";
  for (const Motion& motion : table.motions()) {
    const std::string id = std::to_string(motion.id);
    const std::string capability = motion.capability.empty() ? "always" : motion.capability;
    std::cout << std::string(id.size() < 4 ? 4 - id.size() : 0, ' ') << id << "  "
              << Column(motion.name, 23) << Column(DurationText(motion), 9)
              << Column(capability, motion.servo.empty() ? 0 : 13) << motion.servo << "\n";
  }
  std::cout << std::flush;
}

}  // namespace

TableReading ReadTable(const GlobalOptions& global) {
  return ReadTableFile(global.motions.empty() ? TableFile() : global.motions);
}

std::string NameOf(const GlobalOptions& global, std::int32_t id) {
  const TableReading reading = ReadTable(global);
  const Motion* motion = reading.table ? reading.table->Find(id) : nullptr;
  return std::to_string(id) + (motion == nullptr ? "" : " (" + motion->name + ")");
}

ExitCode Run(const GlobalOptions& global, const ListOptions&) {
  const TableReading reading = ReadTable(global);
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    std::cerr << FormatDiagnostic(diagnostic) << std::endl;
  }
  if (!reading.table) return ExitCode::kUsage;
  if (global.json) {
    PrintJson(*reading.table);
  } else {
    PrintText(*reading.table);
  }
  return ExitCode::kDone;
}

}  // namespace musher::motion::tool
