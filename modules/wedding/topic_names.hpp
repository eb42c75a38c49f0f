#pragma once
// Topics and services of the show, relative to the machine's namespace.

namespace musher::wedding::topic {

inline constexpr const char* kTarget = "wedding/perception/target";
inline constexpr const char* kGesture = "wedding/perception/gesture";
inline constexpr const char* kTooClose = "wedding/perception/too_close";
inline constexpr const char* kFaces = "wedding/perception/faces_json";
inline constexpr const char* kCommand = "wedding/fsm/command";
inline constexpr const char* kVoiceCommand = "wedding/audio/voice_command";
inline constexpr const char* kVoiceLevel = "wedding/audio/voice_level";
inline constexpr const char* kJointStates = "wedding/motion/joint_states";
inline constexpr const char* kJointCommands = "wedding/motion/joint_commands";

inline constexpr const char* kState = "wedding/fsm/state";
inline constexpr const char* kPose = "wedding/motion/pose";
inline constexpr const char* kLookAt = "wedding/motion/look_at";
inline constexpr const char* kPlay = "wedding/audio/play";

inline constexpr const char* kReset = "wedding/fsm/reset";  // services
inline constexpr const char* kSetIdle = "wedding/fsm/set_idle";
inline constexpr const char* kStop = "wedding/fsm/stop";

}  // namespace musher::wedding::topic
