#pragma once
// A topic with a sensor's readings: subscribed to while it is wanted, validated, and watched for
// silence. A fault is logged once with its code, and once when it is over.
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

  // Subscribes to its topic; no effect while subscribed. Fails when the subscription cannot be
  // made.
  Result<> Listen();
  // Drops the subscription, so that the publisher need not make readings for it.
  void Ignore();
  // The clock went back.
  void OnTimeJumped();

  // Empty: no fault. Else the fault, also before it was logged.
  const std::string& fault() const { return fault_; }
  std::uint64_t refused() const { return refused_; }  // readings, since the beginning

 protected:
  Source(const Dependencies& dependencies, SourceOptions options);

  virtual Result<std::unique_ptr<transport::Subscription>> Subscribe(
      transport::SubscriptionEvents events) = 0;

  // A reading was received; returns whether it counts.
  bool Take(const Result<>& validated, const msg::Header& header);

  const Dependencies dependencies_;
  const SourceOptions options_;

 private:
  void AwaitNext();
  void ReportFault(KeyCode key, const std::string& fault);

  StampChecker stamps_;
  std::string fault_ = "not subscribed";
  std::string wrong_stamp_;  // the fault of the last reading's stamp
  bool logged_ = false;      // the fault, or an earlier one that is not over
  std::uint64_t refused_ = 0;
  std::uint64_t refused_before_ = 0;  // when it was last without a fault
  std::optional<Time> last_refused_;
  transport::LoopHandlePtr silence_;
  std::unique_ptr<transport::Subscription> subscription_;  // last: its callbacks use the rest
};

// A source of messages M. `check` says what is impossible in one, `use` gets the valid ones.
template <msg::Message M>
class SourceOf : public Source {
 public:
  using Validator = std::function<Result<>(const M&)>;
  using Use = std::function<void(const M&)>;

  SourceOf(const Dependencies& dependencies, SourceOptions options, Validator validate, Use use)
      : Source(dependencies, std::move(options)),
        validate_(std::move(validate)),
        use_(std::move(use)) {}

 private:
  Result<std::unique_ptr<transport::Subscription>> Subscribe(
      transport::SubscriptionEvents events) override {
    return transport::MakeSubscription<M>(
        dependencies_.node, dependencies_.Name(options_.topic),
        [this](const M& reading, const auto&) {
          if (Take(validate_(reading), reading.header)) use_(reading);
        },
        transport::kSensorDataQos, std::move(events));
  }

  const Validator validate_;
  const Use use_;
};

}  // namespace musher::sensor
