#include "musher/modules/camera/service_core.hpp"

#include <algorithm>
#include <utility>

#include "musher/modules/camera/camera_code.hpp"

namespace musher::camera {
namespace {

using msg::CameraService;

constexpr std::uint32_t kLargestRequestPx = 4096;
constexpr std::uint32_t kMaxRequestedHz = 120;
constexpr std::size_t kLongestName = 128;

KeyCode KeyOf(std::uint8_t result) {
  switch (result) {
    case CameraService::kSuccess:
      return KeyCode::kOk;
    case CameraService::kInvalidArguments:
      return KeyCode::kParametersInvalid;
    case CameraService::kUnsupported:
    case CameraService::kUndefined:
      return KeyCode::kUnSupport;
    case CameraService::kTimeout:
      return KeyCode::kTimeout;
    case CameraService::kBusy:
      return KeyCode::kTargetBusy;
    case CameraService::kInvalidState:
      return KeyCode::kStateInvalid;
    default:
      return KeyCode::kFailed;
  }
}

bool Needs(std::uint8_t command, std::initializer_list<std::uint8_t> commands) {
  return std::find(commands.begin(), commands.end(), command) != commands.end();
}

bool EndsWith(const std::string& name, std::initializer_list<const char*> endings) {
  return std::any_of(endings.begin(), endings.end(),
                     [&](const char* ending) { return name.ends_with(ending); });
}

std::optional<std::string> FaultOfSize(const CameraService::Request& request) {
  if ((request.width == 0) != (request.height == 0))
    return "a width without a height, or the other way round";
  if (request.width > kLargestRequestPx || request.height > kLargestRequestPx) {
    return "a picture of " + std::to_string(request.width) + "x" + std::to_string(request.height) +
           " is larger than " + std::to_string(kLargestRequestPx) + " pixels";
  }
  // Video encoding needs even sizes.
  if (request.width % 2 != 0 || request.height % 2 != 0) return "a width or height that is odd";
  if (request.fps > kMaxRequestedHz)
    return std::to_string(request.fps) + " pictures a second are too many";
  return std::nullopt;
}

// The name of a file to be written; empty: one by the time.
std::optional<std::string> FaultOfNewFile(const std::string& name, bool video) {
  if (name.empty()) return std::nullopt;
  if (auto fault = FaultOfName(name)) return fault;
  if (video && !EndsWith(name, {".avi"})) return "a video's name ends with .avi";
  if (!video && !EndsWith(name, {".jpg", ".png", ".bmp"})) {
    return "a picture's name ends with .jpg, .png or .bmp";
  }
  return std::nullopt;
}

std::optional<std::string> FaultOf(const CameraService::Request& request) {
  switch (request.command) {
    case CameraService::kTakePicture:
    case CameraService::kStartRecording: {
      const bool video = request.command == CameraService::kStartRecording;
      if (auto fault = FaultOfNewFile(request.args, video)) return fault;
      return FaultOfSize(request);
    }
    case CameraService::kSetParameters:
    case CameraService::kStartImagePublish:
      return FaultOfSize(request);
    case CameraService::kDeleteFile:
      return FaultOfName(request.args);
    default:
      return std::nullopt;
  }
}

Shape ShapeOf(const CameraService::Request& request, const Shape& requested) {
  Shape shape = requested;
  if (request.width > 0) {
    shape.width_px = request.width;
    shape.height_px = request.height;
  }
  if (request.fps > 0) shape.rate_hz = request.fps;
  return shape;
}

Decision Execute(const CameraService::Request& request, const ServiceState& state,
                 const Shape& requested) {
  switch (request.command) {
    case CameraService::kSetParameters:
      return SetShape{ShapeOf(request, {})};
    case CameraService::kTakePicture:
      return TakePicture{ShapeOf(request, requested), request.args};
    case CameraService::kStartRecording:
      if (state.recording) return Answer(CameraService::kBusy, "a video is being recorded already");
      return StartRecording{ShapeOf(request, requested), request.args};
    case CameraService::kStopRecording:
      if (!state.recording)
        return Answer(CameraService::kInvalidState, "nothing is being recorded");
      return StopRecording{};
    case CameraService::kGetState:
      return ReportState{};
    case CameraService::kDeleteFile:
      return DeleteFile{request.args};
    case CameraService::kListFiles:
      return ListFiles{};
    case CameraService::kStartImagePublish:
      return StartImage{ShapeOf(request, {})};
    default:  // kStopImagePublish
      if (!state.publishing) return Answer(CameraService::kInvalidState, "image is not published");
      return StopImage{};
  }
}

}  // namespace

CameraService::Response Answer(std::uint8_t result, std::string text) {
  return {result, std::move(text), CameraCode(KeyOf(result))};
}

std::optional<std::string> FaultOfName(const std::string& name) {
  if (name.empty()) return "the name of a file is missing";
  if (name.size() > kLongestName) return "a name longer than 128 characters";
  if (name.front() == '.') return "a name that begins with a dot";
  for (const char c : name) {
    if (c == '/' || c == '\\') return "a path, where the name of a file is expected";
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) return "a name with control characters";
  }
  return std::nullopt;
}

Decision Decide(const CameraService::Request& request, const ServiceState& state,
                const Shape& requested) {
  const std::uint8_t command = request.command;
  if (command > CameraService::kStopImagePublish) {
    return Answer(CameraService::kUndefined, "unknown command " + std::to_string(command));
  }
  if (Needs(command, {CameraService::kStartLiveStream, CameraService::kStopLiveStream})) {
    const bool start = command == CameraService::kStartLiveStream;
    return Answer(CameraService::kUnsupported,
                  "command " + std::to_string(command) + " (" + (start ? "start" : "stop") +
                      " live) is not supported: there is no live stream; command 9 publishes the "
                      "pictures on the topic image");
  }
  if (auto fault = FaultOf(request)) return Answer(CameraService::kInvalidArguments, *fault);
  // Commands that end something, or only read, are accepted in every state.
  if (Needs(command, {CameraService::kTakePicture, CameraService::kStartRecording,
                      CameraService::kStartImagePublish})) {
    if (state.refusal) {
      CameraService::Response response =
          Answer(CameraService::kInvalidState, state.refusal->message);
      response.code = state.refusal->code;
      return response;
    }
    if (!state.on) return Answer(CameraService::kInvalidState, "the camera is off");
  }
  return Execute(request, state, requested);
}

}  // namespace musher::camera
