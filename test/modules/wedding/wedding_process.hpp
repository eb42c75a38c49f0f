#pragma once
// The real musher-wedding on DDS, with fakes of the robot's body, audio and vision, and an
// operator on a command line.

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/geometry_msgs/point_stamped.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/modules/module_process.hpp"

namespace musher::wedding {

// A show whose photos take half a second, with a longer timeout of a face: on a busy machine it
// would say farewell too early.
inline constexpr const char* kFile = R"(
autostart = true
[check]
time_ms = 15000
[tracking]
lost_ms = 5000
[photo]
confirm_ms = 100
pose_ms = 100
countdown_ms = 200
shutter_ms = 100
[farewell]
time_ms = 200
[safe_stop]
clear_ms = 300
)";

// The same with a pose that does not end by itself.
inline std::string LongPose() {
  std::string file = kFile;
  const std::string brief = "\npose_ms = 100\n";
  return file.replace(file.find(brief), brief.size(), "\npose_ms = 60000\n");
}

// The words received on a topic, and how far a test has read them: many words may arrive between
// two checks, and none of them is missed.
class Words : public std::vector<std::string> {
 public:
  // Whether `word` comes after the one that was found last. A repetition of that one does not
  // count.
  bool Find(const std::string& word) {
    while (next_ > 0 && next_ < size() && (*this)[next_] == (*this)[next_ - 1]) ++next_;
    const auto found = std::find(begin() + static_cast<std::ptrdiff_t>(next_), end(), word);
    if (found == end()) return false;
    next_ = static_cast<std::size_t>(found - begin()) + 1;
    return true;
  }
  void Forget() {
    clear();
    next_ = 0;
  }

 private:
  std::size_t next_ = 0;
};

class WeddingProcess : public test::ModuleProcess {
 protected:
  WeddingProcess() : ModuleProcess("wedding", "musher-wedding") {}

  void SetUp() override {
    Subscribe("wedding/fsm/state", states_);
    Subscribe("wedding/motion/pose", poses_);
    Subscribe("wedding/audio/play", sounds_);
    ModuleProcess::Subscribe<msg::PointStamped>(
        "wedding/motion/look_at",
        [this](const msg::PointStamped& look) { looks_.push_back(look); });
    target_ = Publisher<msg::PointStamped>("wedding/perception/target");
    too_close_ = Publisher<msg::Bool>("wedding/perception/too_close");
    gesture_ = Publisher<msg::String>("wedding/perception/gesture");
    command_ = Publisher<msg::String>("wedding/fsm/command");
    voice_ = Publisher<msg::String>("wedding/audio/voice_command");
  }
  void Start(const std::string& file = kFile) {
    ModuleProcess::Start(file);
    ASSERT_TRUE(peer_.Until([&] {
      return target_->MatchedReaders() == 1 && too_close_->MatchedReaders() == 1 &&
             gesture_->MatchedReaders() == 1 && command_->MatchedReaders() == 1 &&
             voice_->MatchedReaders() == 1 &&
             std::ranges::all_of(subscriptions_, [](const auto& received) {
               return received->MatchedWriters() == 1;
             });
    })) << peer_.Output();
  }
  void StartActive(const std::string& file = kFile) {
    Start(file);
    ExpectDone("Active");
    ASSERT_TRUE(AwaitShown("IDLE"));
  }
  // A guest stands there, published ten times a second, until the show is in `state`.
  bool AwaitWithFace(const std::string& state) {
    const auto again = peer_.node().loop().Every(Milliseconds(100), [this] { Face(); });
    Face();
    return AwaitShown(state);
  }
  bool AwaitShown(const std::string& state) {
    return peer_.Until([&] { return states_.Find(state); });
  }
  bool AwaitPose(const std::string& pose) {
    return peer_.Until([&] { return poses_.Find(pose); });
  }
  // Until it has published its state three times without a gaze in between; it publishes fifty
  // gazes a second while it moves.
  bool AwaitNoMoreLooks() {
    std::size_t looks = looks_.size();
    std::size_t states = states_.size();
    return peer_.Until([&] {
      if (looks_.size() != looks) states = states_.size();
      looks = looks_.size();
      return states_.size() >= states + 3;
    });
  }
  void Face(double x = 0.5) { ASSERT_TRUE(target_->Publish({{{}, "camera"}, {x, 0.5, 1.5}})); }
  void Command(const std::string& word) { ASSERT_TRUE(command_->Publish({word})); }
  // Runs the program as a person does.
  int RunTool(std::vector<std::string> words) {
    words.insert(words.begin(), "musher-wedding");
    return Run(std::move(words));
  }
  // Each state once, however often it was published.
  std::vector<std::string> Changes() const {
    std::vector<std::string> changes(states_.begin(), states_.end());
    changes.erase(std::unique(changes.begin(), changes.end()), changes.end());
    return changes;
  }
  // All of them, also several at once after a while without a CPU.
  void Subscribe(const std::string& topic, Words& words) {
    ModuleProcess::Subscribe<msg::String>(
        topic, [&words](const msg::String& word) { words.push_back(word.data); },
        transport::Qos{.depth = 0});
  }

  Words states_;
  Words poses_;
  Words sounds_;
  std::vector<msg::PointStamped> looks_;
  std::unique_ptr<transport::Publisher<msg::PointStamped>> target_;
  std::unique_ptr<transport::Publisher<msg::Bool>> too_close_;
  std::unique_ptr<transport::Publisher<msg::String>> gesture_;
  std::unique_ptr<transport::Publisher<msg::String>> command_;
  std::unique_ptr<transport::Publisher<msg::String>> voice_;
};

}  // namespace musher::wedding
