#include "musher/modules/audio/tool/commands.hpp"

#include <iostream>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/modules/audio/audio_code.hpp"

namespace musher::audio::tool {

ExitCode Fail(ExitCode exit, const Error& error) {
  std::cerr << "musher-audio: " << error.message;
  if (error.code >= static_cast<std::int32_t>(cyberdog::module_code::kAudioNx)) {
    std::cerr << " (" << error.code << ")";
  }
  std::cerr << std::endl;
  return exit;
}

std::string CodeMeaning(std::int32_t code) {
  const std::string meaning = AudioCodeText(code);
  return meaning.empty() ? CodeText(code) : meaning;
}

}  // namespace musher::audio::tool
