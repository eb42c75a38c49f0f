#include "musher/base/code.hpp"

#include <array>
#include <utility>

namespace musher {
namespace {

constexpr std::array<const char*, 14> kKeyNames = {
    "ok",          "Failed",          "Uninitialized",     "StateInvalid",
    "StatusError", "NetError",        "PermissionDenied",  "Timeout",
    "UnSupport",   "SelfCheckFailed", "ParametersInvalid", "TargetBusy",
    "DeviceError", "ProtectedError"};

constexpr std::pair<ModuleCode, const char*> kModuleNames[] = {
    {ModuleCode::kRobot, "Robot"},
    {ModuleCode::kServer, "Server"},
    {ModuleCode::kBridgeGrpc, "BridgeGrpc"},
    {ModuleCode::kBridgeNet, "BridgeNet"},
    {ModuleCode::kApp, "App"},
    {ModuleCode::kDeviceManager, "DeviceManager"},
    {ModuleCode::kLed, "LED"},
    {ModuleCode::kMiniLed, "MiniLED"},
    {ModuleCode::kWifi, "Wifi"},
    {ModuleCode::kBms, "Bms"},
    {ModuleCode::kTouch, "Touch"},
    {ModuleCode::kUwb, "UWB"},
    {ModuleCode::kSensorManager, "SensorManager"},
    {ModuleCode::kLidar, "Lidar"},
    {ModuleCode::kTof, "ToF"},
    {ModuleCode::kUltrasonic, "Ultrasonic"},
    {ModuleCode::kGps, "GPS"},
    {ModuleCode::kMotionManager, "MotionManager"},
    {ModuleCode::kMotionBoard, "MotionBoard"},
    {ModuleCode::kMotionUtils, "MotionUtils"},
    {ModuleCode::kFollow, "Follow"},
    {ModuleCode::kAi, "AI"},
    {ModuleCode::kMapNav, "MapNav"},
    {ModuleCode::kCameraServer, "CameraServer"},
    {ModuleCode::kAudioNx, "AudioNX"},
    {ModuleCode::kAudioBoard, "AudioBoard"},
    {ModuleCode::kConnector, "Connector"},
    {ModuleCode::kNavigation, "Navigation"},
    {ModuleCode::kTransmission, "Transmission"},
    {ModuleCode::kFence, "Fence"},
    {ModuleCode::kAft, "AFT"},
    {ModuleCode::kOta, "OTA"},
    {ModuleCode::kVisualProgram, "VisualProgram"},
    {ModuleCode::kFace, "Face"},
};

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// Whether the sentence has the code already. Of a code without a name only as a number of its own,
// and not where it is so short that it may count something.
bool Says(const std::string& message, const std::string& code) {
  constexpr std::size_t kShortest = 4;
  const std::size_t at = message.find(code);
  if (at == std::string::npos) return false;
  if (code.ends_with(')')) return true;
  const std::size_t end = at + code.size();
  const bool alone =
      (at == 0 || !IsDigit(message[at - 1])) && (end == message.size() || !IsDigit(message[end]));
  return code.size() >= kShortest && alone;
}

}  // namespace

std::string CodeText(std::int32_t code) {
  std::string number = std::to_string(code);
  if (code < 0) return number;
  const std::int32_t key = code % 100;
  const bool named_key = key < static_cast<std::int32_t>(kKeyNames.size());
  if (code < 100) return named_key ? number + " (" + kKeyNames[key] + ")" : number;
  for (const auto& [module, name] : kModuleNames) {
    if (static_cast<std::int32_t>(module) != code - key) continue;
    return number + " (" + name + (named_key && key > 0 ? std::string(": ") + kKeyNames[key] : "") +
           ")";
  }
  return number;
}

std::string WithCode(const std::string& message, std::int32_t code) {
  const std::string text = CodeText(code);
  if (code == kCodeOk || Says(message, text)) return message;
  return message + (message.empty() ? "(" : " (") + text + ")";
}

}  // namespace musher
