// The program musher-record with real processes on DDS.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <utility>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/test/support/domain.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/linux_event_loop.hpp"
#include "musher/view/mcap/scan.hpp"
#include "musher/view/record/qos_text.hpp"

namespace musher::view::program_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kRecord = BinDir() + "/musher-record";
constexpr Duration kLong = std::chrono::seconds(120);

msg::Bytes Encoded(const std::string& text) {
  msg::String message;
  message.data = text;
  return msg::Encode(message);
}

// The texts on a topic of a file.
std::vector<std::string> TextsOf(const std::string& path, const std::string& topic) {
  std::vector<std::string> texts;
  const auto scan = mcap::Scan::Open(path);
  if (!scan) return {scan.error().message};
  for (const auto& message : scan.value()->messages()) {
    if (scan.value()->channels().at(message.channel).topic != topic) continue;
    const auto data = scan.value()->Read(message);
    const auto text = msg::Decode<msg::String>(data.value());
    texts.push_back(text ? text->data : "?");
  }
  return texts;
}

class RecordProgram : public ::testing::Test {
 protected:
  RecordProgram() {
    setenv("ROS_DOMAIN_ID", std::to_string(transport::TestDomain()).c_str(), 1);
    node_ = transport::MakeDdsNode(loop_).value();
  }

  std::unique_ptr<transport::Publisher<msg::String>> Publish(const std::string& topic,
                                                             const transport::Qos& qos) {
    return transport::MakePublisher<msg::String>(*node_, topic, qos).value();
  }
  // Once the recorder has subscribed.
  void Say(transport::Publisher<msg::String>& publisher, const std::string& text) {
    ASSERT_TRUE(
        loop_.RunUntil([&] { return publisher.MatchedReaders() > 0; }, loop_.Now() + kLong));
    msg::String message;
    message.data = text;
    ASSERT_TRUE(publisher.Publish(message));
    ASSERT_TRUE(publisher.Flush(kLong));
  }
  void SayMore(transport::Publisher<msg::String>& publisher) {
    Say(publisher, "more");
    static_cast<void>(loop_.RunUntil([] { return false; }, loop_.Now() + Milliseconds(50)));
  }
  // Waits until the file has that text, which takes the recorder a second at most.
  bool Has(const std::string& path, const std::string& topic, const std::string& text) {
    return loop_.RunUntil(
        [&] {
          const auto texts = TextsOf(path, topic);
          return std::find(texts.begin(), texts.end(), text) != texts.end();
        },
        loop_.Now() + kLong);
  }

  TempFolder folder_;
  const std::string file_ = folder_ / "run.mcap";
  transport::LinuxEventLoop loop_;
  std::unique_ptr<transport::Node> node_;
  transport::LoopHandlePtr turn_ = loop_.Every(Milliseconds(50), [] {});
};

TEST_F(RecordProgram, WhatAPublisherSendsIsInTheFileByteForByte) {
  const auto latched = Publish("state", transport::kLatchedQos);
  ASSERT_TRUE(latched->Publish({"before the recording"}));
  testing::Process recorder({kRecord, "record", "-o", file_});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  const std::string large(1'000'000, 'x');
  Say(*chat, large);
  ASSERT_TRUE(Has(file_, "/chat", large));
  ASSERT_TRUE(Has(file_, "/state", "before the recording"));  // topics have no order among them
  recorder.Signal(SIGINT);
  const auto ended = recorder.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_THAT(ended.err, ::testing::ContainsRegex(", 0 lost; [0-9.]+ [kM]?B in [0-9.]+ s, .*B/s"));
  EXPECT_THAT(TextsOf(file_, "/chat"), ElementsAre("hello", large));
  EXPECT_THAT(TextsOf(file_, "/state"), ElementsAre("before the recording"));
  const auto scan = mcap::Scan::Open(file_).value();
  EXPECT_EQ(scan->damage(), "");
  const auto is_large = [&](const auto& message) {
    return scan->Read(message).value() == Encoded(large);
  };
  EXPECT_TRUE(std::any_of(scan->messages().begin(), scan->messages().end(), is_large));
  for (const auto& [id, channel] : scan->channels()) {
    EXPECT_EQ(channel.encoding, "cdr");
    const bool is_latched = channel.topic == "/state";
    EXPECT_EQ(QosFrom(channel.metadata.at(kOfferedQos)).durability ==
                  transport::Qos::Durability::kTransientLocal,
              is_latched);
  }
}

TEST_F(RecordProgram, OfAKilledRecorderAllButTheLastSecondIsRead) {
  testing::Process recorder({kRecord, "record", "-o", file_, "--compression", "zstd"});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  ASSERT_TRUE(Has(file_, "/chat", "hello"));
  recorder.Signal(SIGKILL);
  static_cast<void>(recorder.Wait());
  const auto info = testing::RunToEnd({kRecord, "info", file_});
  EXPECT_EQ(info.exit, 1);
  EXPECT_THAT(info.err, HasSubstr("the file has no end: its writer was stopped; 1 message"));
  const std::string whole = folder_ / "whole.mcap";
  const auto recovered = testing::RunToEnd({kRecord, "recover", file_, whole});
  EXPECT_EQ(recovered.exit, 0) << recovered.err;
  EXPECT_THAT(TextsOf(whole, "/chat"), ElementsAre("hello"));
  EXPECT_EQ(testing::RunToEnd({kRecord, "info", whole}).exit, 0);
}

// Holds the thread of another process that writes a file, as a disk that hangs does: where it
// enters its next write. `provoke` has it write, and returns after some milliseconds.
class HungDisk {
 public:
  HungDisk(pid_t pid, const std::function<void()>& provoke) {
    for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
      std::ifstream comm(task.path() / "comm");
      std::string is;
      if (std::getline(comm, is) && is == "record-disk")
        thread_ = std::stoi(task.path().filename());
    }
    if (thread_ == 0 || ptrace(PTRACE_SEIZE, thread_, nullptr, PTRACE_O_TRACESYSGOOD) != 0) return;
    ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr);
    waitpid(thread_, nullptr, __WALL);
    constexpr int kMost = 1000;
    for (int times = 0; times < kMost && !EntersWrite();) {
      ptrace(PTRACE_SYSCALL, thread_, nullptr, nullptr);
      for (; waitpid(thread_, nullptr, __WALL | WNOHANG) == 0; ++times) provoke();
    }
    hangs_ = EntersWrite();
  }
  ~HungDisk() { Answer(); }

  bool hangs() const { return hangs_; }
  void Answer() {
    if (thread_ == 0) return;
    const pid_t thread = std::exchange(thread_, 0);
    if (ptrace(PTRACE_DETACH, thread, nullptr, nullptr) == 0) return;
    waitpid(thread, nullptr, __WALL);  // its process has ended; it goes on to exist until then
  }

 private:
  bool EntersWrite() const {
    __ptrace_syscall_info info{};
    const bool known = ptrace(PTRACE_GET_SYSCALL_INFO, thread_, sizeof info, &info) > 0;
    return known && info.op == PTRACE_SYSCALL_INFO_ENTRY && info.entry.nr == SYS_write;
  }

  pid_t thread_ = 0;
  bool hangs_ = false;
};

TEST_F(RecordProgram, SaysThatItWaitsForADiskThatHangs) {
  testing::Process recorder({kRecord, "record", "-o", file_});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  ASSERT_TRUE(Has(file_, "/chat", "hello"));
  HungDisk disk(recorder.pid(), [&] { SayMore(*chat); });
  if (!disk.hangs()) GTEST_SKIP() << "no ptrace";
  Say(*chat, "the rest");
  recorder.Signal(SIGINT);
  ASSERT_TRUE(recorder.AwaitError("waits for its disk to take the rest"));
  disk.Answer();
  const auto ended = recorder.Wait();
  EXPECT_EQ(ended.exit, 0) << ended.err;
  EXPECT_THAT(TextsOf(file_, "/chat"), ::testing::Contains("the rest"));
}

TEST_F(RecordProgram, EndsBesideADiskThatHangsAtASecondSignal) {
  testing::Process recorder({kRecord, "record", "-o", file_});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  ASSERT_TRUE(Has(file_, "/chat", "hello"));
  HungDisk disk(recorder.pid(), [&] { SayMore(*chat); });
  if (!disk.hangs()) GTEST_SKIP() << "no ptrace";
  recorder.Signal(SIGINT);
  ASSERT_TRUE(recorder.AwaitError("a second Ctrl-C ends it without"));
  recorder.Signal(SIGINT);
  ASSERT_TRUE(recorder.AwaitError("ended before its disk had taken everything"));
  disk.Answer();
  EXPECT_EQ(recorder.Wait().exit, 1);
}

TEST_F(RecordProgram, PlayPublishesInTheRecordedOrderAndGaps) {
  {
    testing::Process recorder({kRecord, "record", "-o", file_, "--topic", "/chat"});
    const auto chat = Publish("chat", transport::kDefaultQos);
    Say(*chat, "one");
    Say(*chat, "two");
    Say(*chat, "three");
    ASSERT_TRUE(Has(file_, "/chat", "three"));
    recorder.Signal(SIGINT);
    ASSERT_EQ(recorder.Wait().exit, 0);
  }
  std::vector<std::string> texts;
  const auto subscription = transport::MakeSubscription<msg::String>(
      *node_, "old/chat", [&texts](const msg::String& message, const transport::SampleInfo&) {
        texts.push_back(message.data);
      });
  ASSERT_TRUE(subscription);
  testing::Process player({kRecord, "play", file_, "--remap", "/chat:=/old/chat"});
  EXPECT_TRUE(loop_.RunUntil([&] { return texts.size() == 3; }, loop_.Now() + kLong));
  EXPECT_THAT(texts, ElementsAre("one", "two", "three"));
  const auto ended = player.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.err, HasSubstr("3 messages published"));
}

TEST_F(RecordProgram, TheTopicsOfAMachineArePlayedOnlyIfAsked) {
  {
    testing::Process recorder({kRecord, "record", "-o", file_});
    const auto stop = Publish("musher/emergency_stop", transport::kLatchedQos);
    Say(*stop, "stop");
    ASSERT_TRUE(Has(file_, "/musher/emergency_stop", "stop"));
    recorder.Signal(SIGINT);
    ASSERT_EQ(recorder.Wait().exit, 0);
  }
  const auto refused = testing::RunToEnd({kRecord, "play", file_});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("a robot would obey: /musher/emergency_stop;"));
  const auto asked = testing::RunToEnd({kRecord, "play", file_, "--machine-topics"});
  EXPECT_EQ(asked.exit, 0);
  EXPECT_THAT(asked.err, HasSubstr("1 message published"));
}

// Velocities, servo commands and /clock went to the robot whose domain the recording was played in.
TEST_F(RecordProgram, NothingIsPlayedBesideARobotUnlessAsked) {
  {
    testing::Process recorder({kRecord, "record", "-o", file_, "--topic", "/cmd_vel"});
    const auto velocity = Publish("cmd_vel", transport::kDefaultQos);
    Say(*velocity, "forward");
    ASSERT_TRUE(Has(file_, "/cmd_vel", "forward"));
    recorder.Signal(SIGINT);
    ASSERT_EQ(recorder.Wait().exit, 0);
  }
  std::vector<std::string> velocities;
  const auto wheels = transport::MakeSubscription<msg::String>(
      *node_, "cmd_vel", [&velocities](const msg::String& message, const transport::SampleInfo&) {
        velocities.push_back(message.data);
      });
  ASSERT_TRUE(wheels);
  const auto play = [this](std::vector<std::string> more) {
    std::vector<std::string> argv = {kRecord, "play", file_, "--no-clock"};
    argv.insert(argv.end(), more.begin(), more.end());
    testing::Process player(argv);
    return player.Wait();
  };
  const auto receives = [&](std::size_t count) {
    return loop_.RunUntil([&] { return velocities.size() == count; }, loop_.Now() + kLong);
  };
  {
    const auto motor = transport::MakePublisher<msg::ActuatorStatus>(
                           *node_, "dog1/musher/motor/status", transport::kLatchedQos)
                           .value();
    const auto refused = play({});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_THAT(refused.err, HasSubstr("a robot is in this domain (it publishes /dog1/musher/"));
    const auto asked = play({"--beside-a-robot"});
    EXPECT_EQ(asked.exit, 0) << asked.err;
    EXPECT_TRUE(receives(1)) << "of the first nothing, of the second one";
  }
  // A driver without a controller moves by what it reads, too.
  const auto beside_a_driver = play({});
  EXPECT_EQ(beside_a_driver.exit, 1);
  EXPECT_THAT(beside_a_driver.err, HasSubstr(" reads /cmd_vel, and may move by what is played"));
  const auto elsewhere = play({"--remap", "/cmd_vel:=/played/velocities"});
  EXPECT_EQ(elsewhere.exit, 0) << elsewhere.err;
  const auto asked = play({"--beside-a-robot"});
  EXPECT_EQ(asked.exit, 0) << asked.err;
  EXPECT_TRUE(receives(2)) << "of those that were refused nothing";
}

TEST_F(RecordProgram, AFullDiskEndsTheRecordingWithASentenceAndAGoodFile) {
  testing::Process recorder(
      {"prlimit", "--fsize=300000", kRecord, "record", "-o", file_, "--compression", "none"});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  ASSERT_TRUE(Has(file_, "/chat", "hello"));
  Say(*chat, std::string(1'000'000, 'x'));
  const auto ended = recorder.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("the recording ends: " + file_ + ": File too large"));
  EXPECT_THAT(TextsOf(file_, "/chat"), ElementsAre("hello"));
}

TEST_F(RecordProgram, ARingKeepsNothingWithoutTrouble) {
  testing::Process recorder(
      {kRecord, "record", "--ring", "5m", "--keep-on", "trouble", "-o", folder_ / "kept"});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "hello");
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.Wait().exit, 0);
  EXPECT_TRUE(fs::is_empty(folder_ / "kept"));
}

TEST_F(RecordProgram, ARingKeepsWhatWentWrong) {
  const auto machine = transport::MakePublisher<msg::MachineStatus>(*node_, "musher/machine_status",
                                                                    transport::kLatchedQos)
                           .value();
  msg::MachineStatus status;
  status.state = "Active";
  ASSERT_TRUE(machine->Publish(status));
  testing::Process recorder({kRecord, "record", "--ring", "5m", "-o", folder_ / "kept"});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, "before");
  ASSERT_TRUE(recorder.AwaitError("trouble of the machine is kept"));
  const std::string ring = folder_ / "kept/ring/00000001.mcap";
  const auto has = [&ring](const char* topic) { return !TextsOf(ring, topic).empty(); };
  ASSERT_TRUE(loop_.RunUntil([&] { return has("/chat") && has("/musher/machine_status"); },
                             loop_.Now() + kLong));
  status.emergency_stop = true;
  ASSERT_TRUE(machine->Publish(status));
  ASSERT_TRUE(recorder.AwaitError("trouble: emergency-stop"));
  recorder.Signal(SIGINT);
  const auto ended = recorder.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.err, HasSubstr("kept " + (folder_ / "kept")));
  std::vector<std::string> kept;
  for (const auto& entry : fs::directory_iterator(folder_ / "kept")) {
    kept.push_back(entry.path().string());
  }
  ASSERT_EQ(kept.size(), 1U);
  EXPECT_THAT(kept[0], HasSubstr("Z_emergency-stop.mcap"));
  EXPECT_THAT(TextsOf(kept[0], "/chat"), ElementsAre("before"));
  EXPECT_EQ(TextsOf(kept[0], "/musher/machine_status").size(), 2U);
}

// The status of each machine of the namespace was trouble of the other.
TEST_F(RecordProgram, ARingKeepsNoTroubleOfAnotherMachineOfTheNamespace) {
  const auto publisher = [this] {
    return transport::MakePublisher<msg::MachineStatus>(*node_, "musher/machine_status",
                                                        transport::kLatchedQos)
        .value();
  };
  const auto dog = publisher();
  msg::MachineStatus of_dog;
  of_dog.machine = "dog";
  ASSERT_TRUE(dog->Publish(of_dog));
  testing::Process recorder({kRecord, "record", "--ring", "5m", "-o", folder_ / "kept"});
  // A late reader may get what is latched after what another writer publishes then.
  ASSERT_TRUE(recorder.AwaitError("trouble of dog is kept"));
  const auto cat = publisher();
  msg::MachineStatus of_cat;
  of_cat.machine = "cat";
  of_cat.emergency_stop = true;
  ASSERT_TRUE(loop_.RunUntil([&] { return cat->MatchedReaders() == 2; }, loop_.Now() + kLong));
  ASSERT_TRUE(cat->Publish(of_cat));
  ASSERT_TRUE(cat->Flush(kLong));
  of_dog.state = "Error";
  ASSERT_TRUE(dog->Publish(of_dog));
  ASSERT_TRUE(recorder.AwaitError("trouble: error"));
  recorder.Signal(SIGINT);
  EXPECT_THAT(recorder.Wait().err, ::testing::Not(HasSubstr("emergency-stop")));
}

TEST_F(RecordProgram, ARingThatCannotKeepAllOfWhatWentWrongSaysSoAndExitsWithOne) {
  const auto machine = transport::MakePublisher<msg::MachineStatus>(*node_, "musher/machine_status",
                                                                    transport::kLatchedQos)
                           .value();
  msg::MachineStatus status;
  ASSERT_TRUE(machine->Publish(status));
  testing::Process recorder({"prlimit", "--fsize=300000", kRecord, "record", "--ring", "5m", "-o",
                             folder_ / "kept", "--compression", "none"});
  const auto chat = Publish("chat", transport::kDefaultQos);
  Say(*chat, std::string(1'000'000, 'x'));
  ASSERT_TRUE(recorder.AwaitError("File too large"));
  ASSERT_TRUE(recorder.AwaitError("trouble of the machine is kept"));
  status.emergency_stop = true;
  ASSERT_TRUE(machine->Publish(status));
  ASSERT_TRUE(recorder.AwaitError("trouble: emergency-stop"));
  recorder.Signal(SIGINT);
  const auto ended = recorder.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("emergency-stop.mcap lacks a part: "));
}

TEST_F(RecordProgram, SaysWhatIsWrongWithItsInput) {
  const auto error = [](const std::vector<std::string>& arguments) {
    std::vector<std::string> argv = {kRecord};
    argv.insert(argv.end(), arguments.begin(), arguments.end());
    const auto ended = testing::RunToEnd(argv);
    EXPECT_EQ(ended.exit, 2) << ended.err;
    return ended.err;
  };
  EXPECT_THAT(error({"play", folder_ / "none.mcap"}), HasSubstr("No such file"));
  EXPECT_THAT(error({"info", folder_.path()}), HasSubstr("it is not a file; expected an MCAP"));
  std::ofstream(folder_ / "text") << "hello";
  EXPECT_THAT(error({"info", folder_ / "text"}), HasSubstr("it is not an MCAP file"));
  EXPECT_THAT(error({"record", "-o", folder_ / "text"}), HasSubstr("File exists"));
  EXPECT_THAT(error({"record", "--topic", "a b"}), HasSubstr("invalid topic pattern"));
  EXPECT_THAT(error({"record", "--duration", "5y"}), HasSubstr("invalid duration '5y'"));
  EXPECT_THAT(error({"record", "--keep-on", "trouble"}), HasSubstr("--ring"));
}

}  // namespace musher::view::program_test
