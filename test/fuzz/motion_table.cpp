// The motion manager's two files as any text: a result or an error, never a crash.

#include "musher/modules/motion/motion_table.hpp"
#include "musher/modules/motion/motion_config.hpp"
#include "musher/test/fuzz/fuzz.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto table = musher::motion::ReadTableText(text, "motions.toml");
  musher::fuzz::Require(table.table.has_value() != HasError(table.diagnostics),
                        "either a table or an error");
  const auto config = musher::motion::ReadMotionConfigText(text, "motion_manager.toml");
  musher::fuzz::Require(config.config.has_value() != HasError(config.diagnostics),
                        "either a config or an error");
  return 0;
}
