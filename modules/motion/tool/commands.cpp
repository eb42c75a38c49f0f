#include "musher/modules/motion/tool/commands.hpp"

#include <iostream>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/modules/motion/motion_code.hpp"

namespace musher::motion::tool {

ExitCode Fail(ExitCode exit, const Error& error) {
  std::cerr << "musher-motion: " << error.message;
  if (error.code >= static_cast<std::int32_t>(cyberdog::module_code::kMotionManager)) {
    std::cerr << " (" << error.code << ")";
  }
  std::cerr << std::endl;
  return exit;
}

std::string CodeMeaning(std::int32_t code) {
  const std::string meaning = MotionCodeText(code);
  return meaning.empty() ? CodeText(code) : meaning;
}

}  // namespace musher::motion::tool
