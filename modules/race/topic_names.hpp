#pragma once
// Topics and services of the race, relative to the machine's namespace. Those of the course are in
// its file.

namespace musher::race::topic {

inline constexpr const char* kCommand = "state_machine/start_command";
inline constexpr const char* kInfo = "state_machine/state_info";

inline constexpr const char* kServo = "motion_servo_cmd";
inline constexpr const char* kServoReply = "motion_servo_response";
inline constexpr const char* kMotion = "motion_result_cmd";  // a service
inline constexpr const char* kBody = "motion_status";
inline constexpr const char* kBattery = "bms_status";
inline constexpr const char* kSpeech = "speech_text_play";  // a service

}  // namespace musher::race::topic
