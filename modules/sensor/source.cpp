#include "musher/modules/sensor/source.hpp"

#include <utility>

namespace musher::sensor {
namespace {

// A process that was kept from running hears what waits for it before it calls anybody silent.
constexpr Duration kGrace = Milliseconds(200);  // of the steady clock

}  // namespace

Source::Source(const Dependencies& around, SourceOptions options)
    : around_(around), options_(std::move(options)), stamps_(options_.stamp_tolerance) {}

Result<> Source::Listen() {
  if (subscription_) return Ok();
  transport::SubscriptionEvents events;
  events.on_match_changed = [this] {
    // Who is gone may take the clock along: no silence would ever be over.
    if (complaint_.empty() && subscription_ && subscription_->MatchedWriters() == 0) {
      Complain(KeyCode::kTimeout, "nobody publishes " + options_.topic);
    }
  };
  complaint_ = "nothing was heard of it yet";
  auto subscription = Subscribe(std::move(events));
  if (!subscription) return subscription.error();
  subscription_ = std::move(subscription).value();
  AwaitNext();
  return Ok();
}

void Source::Ignore() {
  subscription_.reset();
  silence_.reset();
  stamps_.Forget();
  last_refused_.reset();
  wrong_stamp_.clear();
  said_ = false;
  complaint_ = "it is not heard";
}

void Source::OnTimeJumped() {
  stamps_.Forget();
  last_refused_.reset();
}

void Source::AwaitNext() {
  silence_ = around_.clock.At(around_.clock.Now() + options_.silence, [this] {
    transport::EventLoop& loop = around_.node.loop();
    silence_ = loop.At(loop.Now() + kGrace, [this] {
      silence_.reset();
      const std::string silent =
          "silent for " + std::to_string(ToMilliseconds(options_.silence)) + " ms";
      Complain(KeyCode::kTimeout, wrong_stamp_.empty()
                                      ? silent
                                      : silent + ", its readings are refused: " + wrong_stamp_);
    });
  });
}

bool Source::Take(const Result<>& judged, const msg::Header& header) {
  const Time now = around_.clock.Now();
  if (!judged) {
    AwaitNext();
    ++refused_;
    last_refused_ = now;
    Complain(KeyCode::kDeviceError, "its readings are refused: " + judged.error().message);
    return false;
  }
  const Result<> timely =
      stamps_.Take(msg::FromStamp(header.stamp), msg::FromStamp(around_.stamp()));
  if (!timely) {
    // As if it had not come: late ones may be the fault of who hears them.
    ++refused_;
    wrong_stamp_ = timely.error().message;
    return false;
  }
  AwaitNext();
  wrong_stamp_.clear();
  complaint_.clear();
  // One good reading among bad ones is no recovery that is worth a line.
  if (said_ && !(last_refused_ && now - *last_refused_ < options_.silence)) {
    said_ = false;
    const std::uint64_t refused = refused_ - std::exchange(refused_before_, refused_);
    around_.log(options_.name + ": well again" +
                (refused > 0 ? ", " + std::to_string(refused) + " readings were refused" : ""));
  }
  return true;
}

void Source::Complain(KeyCode key, const std::string& complaint) {
  complaint_ = complaint;
  if (std::exchange(said_, true)) return;
  const std::int32_t code = CodeOf(options_.kind, key);
  around_.log(options_.name + ": " + WithCode(complaint, code));
  around_.report(code);
}

}  // namespace musher::sensor
