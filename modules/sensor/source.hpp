#pragma once
// A topic that a sensor's readings come on: heard while it is wanted, judged, and watched for
// silence. What is wrong with it is said once with its code, and once more when it is well again.
//
//   Ignored --Listen()--> Waiting --reading--> Well <--reading-- Bad: silent, or readings refused
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/sensor/dependencies.hpp"
#include "musher/modules/sensor/readings.hpp"
#include "musher/modules/sensor/sensor_kind.hpp"

namespace musher::sensor {

struct SourceOptions {
  SensorKind kind = SensorKind::kLidar;
  std::string name;   // for people: "lidar", "tof left_head"
  std::string topic;  // in the namespace
  Duration silence{};
  Duration stamp_tolerance{};
};

class Source {
 public:
  virtual ~Source() = default;
  Source(const Source&) = delete;
  Source& operator=(const Source&) = delete;

  // Begins to hear its topic; no effect while it does. Fails when the subscription cannot be made.
  Result<> Listen();
  // Drops the subscription, so that nobody has to make readings for it.
  void Ignore();
  // The clock went back.
  void OnTimeJumped();

  // Empty: well. Else what is wrong, also before it was said.
  const std::string& complaint() const { return complaint_; }
  std::uint64_t refused() const { return refused_; }  // readings, since the beginning

 protected:
  Source(const Dependencies& around, SourceOptions options);

  virtual Result<std::unique_ptr<transport::Subscription>> Subscribe(
      transport::SubscriptionEvents events) = 0;

  // A reading has come; says whether it counts.
  bool Take(const Result<>& judged, const msg::Header& header);

  const Dependencies around_;
  const SourceOptions options_;

 private:
  void AwaitNext();
  void Complain(KeyCode key, const std::string& complaint);

  StampChecker stamps_;
  std::string complaint_ = "it is not heard";
  std::string wrong_stamp_;  // what was wrong with that of the last reading
  bool said_ = false;        // the complaint, or one before it that is not over
  std::uint64_t refused_ = 0;
  std::uint64_t refused_before_ = 0;  // when it was well
  std::optional<Time> last_refused_;
  transport::LoopHandlePtr silence_;
  std::unique_ptr<transport::Subscription> subscription_;  // last: its callbacks use the rest
};

// A source of messages M. `judge` says what cannot be true of one, `use` is given those that count.
template <msg::Message M>
class SourceOf : public Source {
 public:
  using Judgement = std::function<Result<>(const M&)>;
  using Use = std::function<void(const M&)>;

  SourceOf(const Dependencies& around, SourceOptions options, Judgement judge, Use use)
      : Source(around, std::move(options)), evaluation_(std::move(judge)), use_(std::move(use)) {}

 private:
  Result<std::unique_ptr<transport::Subscription>> Subscribe(
      transport::SubscriptionEvents events) override {
    return transport::MakeSubscription<M>(
        around_.node, around_.Name(options_.topic),
        [this](const M& reading, const auto&) {
          if (Take(evaluation_(reading), reading.header)) use_(reading);
        },
        transport::kSensorDataQos, std::move(events));
  }

  const Judgement evaluation_;
  const Use use_;
};

}  // namespace musher::sensor
