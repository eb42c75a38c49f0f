#pragma once
// Topics that the robot's second generation has in addition to those of the first.
//
// Threads: the loop's.

#include <string>
#include <string_view>

#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/wedding/show.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::wedding {

namespace topic {
inline constexpr const char* kReady = "wedding/system/ready";
inline constexpr const char* kSetPose = "wedding/motion/set_pose";
inline constexpr const char* kSetMotion = "wedding/motion/set_motion";
inline constexpr const char* kSetLookAt = "wedding/fsm/set_look_at";
inline constexpr const char* kTargetFaceId = "wedding/fsm/target_face_id";
inline constexpr const char* kDebugLog = "wedding/fsm/debug_log";
inline constexpr const char* kCameraInfo = "camera/head/camera_info";
}  // namespace topic

class SecondGeneration {
 public:
  // `show` outlives the topics.
  void Open(transport::Endpoints& topics, Show& show, const std::function<Time()>& now);

  void SetPose(std::string_view pose) { Publish(set_pose_, std::string(pose)); }
  void SetMotion(std::string_view motion) { Publish(set_motion_, std::string(motion)); }
  void PublishFace(int face_id) { Publish(target_face_id_, std::to_string(face_id)); }
  void PublishLine(std::string_view state, const std::string& line) {
    Publish(debug_log_, "[" + std::string(state) + "] " + line);
  }
  // The last value of wedding/system/ready; false before the first message.
  bool ready() const { return ready_; }

 private:
  using Text = transport::Publisher<msg::String>;
  static void Publish(Text* topic, const std::string& text) {
    // A lost message is superseded by the next.
    if (topic != nullptr) static_cast<void>(topic->Publish({text}));
  }

  Text* set_pose_ = nullptr;
  Text* set_motion_ = nullptr;
  Text* target_face_id_ = nullptr;
  Text* debug_log_ = nullptr;
  bool ready_ = false;
};

}  // namespace musher::wedding
