#include "musher/cyberdog/codes/module_codes.hpp"

namespace musher::cyberdog {
namespace {

constexpr ModuleName kModuleNames[] = {
    {module_code::kServer, "Server"},
    {module_code::kBridgeGrpc, "BridgeGrpc"},
    {module_code::kBridgeNet, "BridgeNet"},
    {module_code::kApp, "App"},
    {module_code::kDeviceManager, "DeviceManager"},
    {module_code::kLed, "LED"},
    {module_code::kMiniLed, "MiniLED"},
    {module_code::kWifi, "Wifi"},
    {module_code::kBms, "Bms"},
    {module_code::kTouch, "Touch"},
    {module_code::kUwb, "UWB"},
    {module_code::kSensorManager, "SensorManager"},
    {module_code::kLidar, "Lidar"},
    {module_code::kTof, "ToF"},
    {module_code::kUltrasonic, "Ultrasonic"},
    {module_code::kGps, "GPS"},
    {module_code::kMotionManager, "MotionManager"},
    {module_code::kMotionBoard, "MotionBoard"},
    {module_code::kMotionUtils, "MotionUtils"},
    {module_code::kFollow, "Follow"},
    {module_code::kAi, "AI"},
    {module_code::kMapNav, "MapNav"},
    {module_code::kCameraServer, "CameraServer"},
    {module_code::kAudioNx, "AudioNX"},
    {module_code::kAudioBoard, "AudioBoard"},
    {module_code::kConnector, "Connector"},
    {module_code::kNavigation, "Navigation"},
    {module_code::kTransmission, "Transmission"},
    {module_code::kFence, "Fence"},
    {module_code::kAft, "AFT"},
    {module_code::kVisualProgram, "VisualProgram"},
    {module_code::kFace, "Face"},
};

}  // namespace

bool NameModuleCodes() {
  return NameModules(kModuleNames);
}

}  // namespace musher::cyberdog
