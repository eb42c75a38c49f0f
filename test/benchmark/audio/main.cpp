// From a text to its first sound: musher-audio-manager as a process, called over DDS, its sound
// timed and not played (output "silent"), so that the sound device's own delay is not in it. Beside
// it the same for a service that plays nothing.
//
//   benchmark_audio [ROUNDS]

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_srvs/empty.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/transport/service.hpp"

namespace musher::benchmark {
namespace {

constexpr Duration kWaitLimit = std::chrono::seconds(30);
constexpr int kWarm = 3;  // rounds that do not count

constexpr const char* kMachine = R"([controller]
actuators = ["audio"]
states = ["SetUp", "Active"]
default_time = 10000
default_state = "Uninitialized"
[actuator.audio]
states = ["SetUp", "Active"]
times = [10000, 10000]
)";

struct Text {
  std::string what;
  std::string text;
};

std::string TwoHundredCharacters() {
  std::string text;
  for (int i = 0; i < 25; ++i) text += "the dog ";
  return text.substr(0, 199) + ".";
}

double Milli(Duration duration) {
  return Microseconds(duration) / 1000;
}

// The audio module and a hand in its domain.
class Voice {
 public:
  Voice() : folder_(Folder()), module_(Start(folder_)) {
    node_ = Must(transport::MakeDdsNode(loop_));
    text_ = Must(transport::MakeClient<msg::AudioTextPlay>(*node_, "speech_text_play"));
    stop_ = Must(transport::MakeClient<msg::EmptyService>(*node_, "stop_play"));
    volume_ = Must(transport::MakeClient<msg::AudioVolumeGet>(*node_, "audio_volume_get"));
    report_ = Must(transport::MakeSubscription<msg::Bool>(
        *node_, "audio_notification_report", [this](const msg::Bool& report, const auto&) {
          sounds_ = report.data;
          sounds_since_ = loop_.Now();
        }));
    Await("the audio module", [this] {
      return text_->Ready() && stop_->Ready() && volume_->Ready() && report_->MatchedWriters() > 0;
    });
  }
  ~Voice() {
    std::error_code none;
    std::filesystem::remove_all(folder_, none);
  }
  Voice(const Voice&) = delete;
  Voice& operator=(const Voice&) = delete;

  // From the request to its first sound; silent again after it.
  Duration Say(const std::string& text) {
    const Time begun = loop_.Now();
    bool over = false;
    text_->Call({"benchmark", true, {}, text}, kWaitLimit, [&](const auto&) { over = true; });
    Await("the first sound", [this] { return sounds_; });
    const Time first_sound = sounds_since_;
    stop_->Call({}, kWaitLimit, [](const auto&) {});
    Await("silence", [&] { return over && !sounds_; });
    return first_sound - begun;
  }
  Duration QueryVolume() {
    const Time begun = loop_.Now();
    bool over = false;
    volume_->Call({}, kWaitLimit, [&](const auto&) { over = true; });
    Await("the volume", [&] { return over; });
    return loop_.Now() - begun;
  }

 private:
  static std::filesystem::path Folder() {
    auto folder =
        std::filesystem::temp_directory_path() / ("musher-voice-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder);
    setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
    return folder;
  }
  static Child Start(const std::filesystem::path& folder) {
    std::ofstream(folder / "machine.toml") << kMachine;
    std::ofstream(folder / "phrases.toml") << "[[phrase]]\nid = 1\nen = \"one\"\n";
    std::ofstream(folder / "audio.toml") << "output = \"silent\"\nphrases = \"phrases.toml\"\n";
    return Child({Program("musher-audio-manager"), folder / "audio.toml"},
                 {{"MUSHER_ACTUATOR", "audio"}, {"MUSHER_CONFIG", folder / "machine.toml"}},
                 Child::Output::kNowhere);
  }
  template <class T>
  static T Must(Result<T> made) {
    if (!made) Fail(made.error().message);
    return std::move(made).value();
  }
  void Await(const std::string& what, const std::function<bool()>& is_so) {
    if (!loop_.RunUntil(is_so, loop_.Now() + kWaitLimit)) Fail("no " + what);
  }

  const std::filesystem::path folder_;
  const Child module_;
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  bool sounds_ = false;
  Time sounds_since_{};
  std::unique_ptr<transport::Client<msg::AudioTextPlay>> text_;
  std::unique_ptr<transport::Client<msg::EmptyService>> stop_;
  std::unique_ptr<transport::Client<msg::AudioVolumeGet>> volume_;
  std::unique_ptr<transport::Subscription> report_;
};

void Main(int rounds) {
  const std::vector<Text> texts = {{"short Chinese", "你好，我准备好了。"},
                                   {"short English", "Hello, I am ready."},
                                   {"200 characters of English", TwoHundredCharacters()}};
  std::vector<std::vector<double>> times(texts.size());
  std::vector<double> plain;
  Voice voice;
  for (int round = -kWarm; round < rounds; ++round) {  // in turns, so that they share their luck
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const double took = Milli(voice.Say(texts[i].text));
      if (round >= 0) times[i].push_back(took);
    }
    const double took = Milli(voice.QueryVolume());
    if (round >= 0) plain.push_back(took);
  }
  const Table table("From a text to its first sound");
  for (std::size_t i = 0; i < texts.size(); ++i) table.Row(texts[i].what, times[i], "ms");
  table.Row("the volume is queried and returned", plain, "ms");
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  musher::benchmark::Main(argc > 1 ? std::atoi(argv[1]) : 200);
}
