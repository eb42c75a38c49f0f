#include "musher/modules/device/i2c_link.hpp"

#include <mutex>
#include <utility>

#include "musher/base/work_queue.hpp"
#include "musher/modules/device/i2c_file.hpp"

namespace musher::device {

I2cDoor I2cOfThisComputer() {
  return {OpenI2cFile, [] {
            const auto thread = std::make_shared<WorkQueue>(
                WorkQueueOptions{.name = "i2c",
                                 .takes_signals = false,
                                 .at_end = WorkQueueOptions::AtEnd::kDrop,
                                 .end_timeout = std::chrono::seconds(1)});
            return [thread](std::function<void()> work) { thread->Do(std::move(work)); };
          }};
}

// Of the thread of the bus, which may outlive the link.
class I2cLink::Reader {
 public:
  Reader(I2cBus::Open open, const I2cProtocol& protocol)
      : open_(std::move(open)), protocol_(protocol) {}

  Reading Read() {
    if (!device_) {
      auto opened = open_(protocol_.bus, protocol_.address);
      if (!opened) return opened.error();
      device_ = std::move(opened).value();
    }
    std::vector<RegisterBytes> registers;
    for (const RegisterValue& value : protocol_.values) {
      auto bytes = device_->Read(value.address, value.bytes);
      if (!bytes) {
        device_.reset();
        return bytes.error();
      }
      registers.push_back(std::move(bytes).value());
    }
    return registers;
  }

 private:
  const I2cBus::Open open_;
  const I2cProtocol protocol_;
  std::unique_ptr<I2cBus> device_;
};

// The way back to the loop; null once the link is gone.
struct I2cLink::Home {
  std::mutex mutex;
  I2cLink* link = nullptr;

  void Post(std::function<void(I2cLink&)> work, const std::shared_ptr<Home>& self) {
    const std::lock_guard lock(mutex);
    if (link == nullptr) return;
    link->loop_.Post([self, work = std::move(work)] {
      if (self->link != nullptr) work(*self->link);  // changes on the loop only
    });
  }
};

I2cLink::I2cLink(transport::EventLoop& loop, const I2cDoor& door, I2cProtocol protocol,
                 Duration silence, Events events)
    : loop_(loop),
      protocol_(std::move(protocol)),
      silence_time_(silence),
      events_(std::move(events)),
      record_(protocol_.values),
      reader_(std::make_shared<Reader>(door.open, protocol_)),
      home_(std::make_shared<Home>()),
      background_(door.make_background()) {
  home_->link = this;
  ArmSilence();
  period_ = loop_.Every(protocol_.period, [this] { Begin(); });
  Begin();
}

I2cLink::~I2cLink() {
  const std::lock_guard lock(home_->mutex);
  home_->link = nullptr;
}

// The bus may still be held by the reading before.
void I2cLink::Begin() {
  if (begun_at_) return;
  begun_at_ = loop_.Now();
  background_([reader = reader_, home = home_] {
    home->Post([reading = reader->Read()](I2cLink& link) { link.OnReading(reading); }, home);
  });
}

void I2cLink::OnReading(const Reading& reading) {
  const Time begun = *std::exchange(begun_at_, std::nullopt);
  if (!reading) return Refuse(reading.error());
  const auto counts = record_.Take(reading.value(), begun);
  if (!counts) return Refuse(counts.error());
  refused_ = counts.value() ? "" : "its values jump from reading to reading";
  if (!counts.value()) return;
  works_ = true;
  fault_.clear();
  ArmSilence();
  events_.on_record(*counts.value());
}

void I2cLink::Refuse(const Error& error) {
  refused_ = error.message;
  const Time now = loop_.Now();
  if (reported_at_ && now - *reported_at_ < kRefusedPause) return;
  reported_at_ = now;
  events_.on_refused(error);
}

void I2cLink::ArmSilence() {
  const Time due = loop_.Now() + silence_time_;
  silence_ = loop_.At(due, [this, due] { OnSilence(due); });
}

// A process that was suspended runs its timers first: a reading may be on its way.
void I2cLink::OnSilence(Time due) {
  const Time now = loop_.Now();
  if (now > due + kLate) {
    const Time again = now + kLate;
    silence_ = loop_.At(again, [this, again] { OnSilence(again); });
    return;
  }
  ArmSilence();
  const std::string time = std::to_string(ToMilliseconds(silence_time_)) + " ms";
  std::string why = "no reading has counted for " + time;
  if (!refused_.empty()) why += ": " + refused_;
  if (begun_at_ && now - *begun_at_ >= protocol_.period) {
    why = protocol_.bus + " has not answered for " +
          std::to_string(ToMilliseconds(now - *begun_at_)) + " ms: the bus is held";
  }
  record_.Forget();
  const bool begins = std::exchange(works_, false) || fault_.empty();
  fault_ = why;
  if (begins) events_.on_fault(why);
}

}  // namespace musher::device
