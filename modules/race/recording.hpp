#pragma once
// The inputs of a race in a recording (behavior/fsm/recorder.hpp), a name and a text: words in a
// row, of which the first is the time of reception in nanoseconds since the machine was first
// started, and the last may have spaces. "-" is an empty word. In all but the last a space is %20,
// a percent sign %25, and the word "-" %2D.

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"

namespace musher::race {

namespace input {
// detector, when it was taken in ns, seen 0 or 1, distance in m, phase, text, offset, confidence (a
// recording of an earlier version has none)
inline constexpr std::string_view kSighting = "sighting";
// detector, when it was taken in ns, contours, ycy, dy, middle offset, doubt (a recording of an
// earlier version has none)
inline constexpr std::string_view kLines = "lines";
inline constexpr std::string_view kDoubt = "doubt";             // detector, why
inline constexpr std::string_view kWalker = "walker";           // walk, status
inline constexpr std::string_view kMotionDone = "motion_done";  // number, code, message
inline constexpr std::string_view kSpoken = "spoken";           // number, code, message
// stamp in ns, when it was taken in ns, x and y in m, yaw in rad: only during a walk. A recording
// of an earlier version has none, and is replayed by time, as it was recorded.
inline constexpr std::string_view kOdometry = "odometry";
inline constexpr std::string_view kBody = "body";        // switch_status, motion_id
inline constexpr std::string_view kServo = "servo";      // accepted 0 or 1, code
inline constexpr std::string_view kCharger = "charger";  // 1: it is put on one; 0: on none any more
// topic (a recording of an earlier version has the number of a detector)
inline constexpr std::string_view kTwoPublishers = "two_publishers";
inline constexpr std::string_view kCommand = "command";  // its text
inline constexpr std::string_view kRest = "rest";
inline constexpr std::string_view kResume = "resume";
inline constexpr std::string_view kBreak = "break";  // its length in ns
}  // namespace input

std::string NumberText(double number);

// Joins the words behind the time.
std::string InputText(Duration at, std::initializer_list<std::string> words);

// Splits a text into the time and `words` words; fails when it has fewer.
struct InputWords {
  Duration at{};
  std::vector<std::string> words;
};
Result<InputWords> ReadInput(std::string_view text, std::size_t words);

// Of a word; fails when it is none.
Result<std::int64_t> ReadInteger(std::string_view word);
Result<double> ReadNumber(std::string_view word);

}  // namespace musher::race
