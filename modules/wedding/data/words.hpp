#pragma once
// The words that the wedding robot's topics carry.

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace musher::wedding {

// The module's own; extensions add theirs.
namespace state {
inline constexpr std::string_view kIdle = "IDLE";
inline constexpr std::string_view kTracking = "TRACKING";
inline constexpr std::string_view kPhotoPosing = "PHOTO_POSING";
inline constexpr std::string_view kFarewell = "FAREWELL";
inline constexpr std::string_view kSafeStop = "SAFE_STOP";
}  // namespace state

namespace command {
inline constexpr std::string_view kStop = "stop";
inline constexpr std::string_view kIdle = "idle";
inline constexpr std::string_view kPhoto = "photo";
inline constexpr std::string_view kTracking = "tracking";
inline constexpr std::string_view kReset = "reset";
}  // namespace command

namespace pose {
inline constexpr std::string_view kNeutral = "neutral";
inline constexpr std::string_view kHeart = "heart";
inline constexpr std::string_view kVSign = "v_sign";
inline constexpr std::string_view kThumbsUp = "thumbs_up";
inline constexpr std::string_view kWave = "wave";
}  // namespace pose

namespace sound {
inline constexpr std::string_view kGreeting = "greeting";
inline constexpr std::string_view kPhotoConfirm = "photo_confirm";
inline constexpr std::string_view kCountdown = "countdown";
inline constexpr std::string_view kShutter = "shutter";
inline constexpr std::string_view kPhotoDone = "photo_done";
inline constexpr std::string_view kFarewell = "farewell";
inline constexpr std::string_view kTooClose = "too_close";
}  // namespace sound

enum class Gesture { kNone, kHeart, kV, kOk };
std::optional<Gesture> GestureOf(std::string_view word);  // lower case; "" is none
std::string_view Name(Gesture gesture);

// Lower case, without blanks at its ends, since people type them.
std::string Tidy(std::string_view word);

}  // namespace musher::wedding
