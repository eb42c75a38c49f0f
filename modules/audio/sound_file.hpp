#pragma once
// Sound in files, by libsndfile.
//
// Threads: any.

#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/audio/sound.hpp"

namespace musher::audio {

inline constexpr std::chrono::minutes kLongestRecording(10);

// Mixes several channels into one. Fails with kRecording's code on a file that is missing, has no
// sound, or is longer than kLongestRecording.
Result<Sound> ReadSound(const std::string& path);

// Whether ReadSound() would succeed, by the file's header.
Result<> CheckSound(const std::string& path);

// As WAV, 16 bit. Fails with the code of a device that takes no sound.
Result<> WriteWav(const std::string& path, const Sound& sound);

}  // namespace musher::audio
