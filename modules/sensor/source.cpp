#include "musher/modules/sensor/source.hpp"
#include "musher/messages/stamp.hpp"

#include <utility>

namespace musher::sensor {
namespace {

// A process that was suspended reads its queued readings before it reports silence.
constexpr Duration kGrace = Milliseconds(200);  // of the steady clock

}  // namespace

Source::Source(const Dependencies& dependencies, SourceOptions options)
    : dependencies_(dependencies),
      options_(std::move(options)),
      stamps_(options_.stamp_tolerance) {}

Result<> Source::Listen() {
  if (subscription_) return Ok();
  transport::SubscriptionEvents events;
  events.on_match_changed = [this] {
    // A publisher that exits may take the clock with it: the silence timer would never fire.
    if (fault_.empty() && subscription_ && subscription_->MatchedWriters() == 0) {
      ReportFault(KeyCode::kTimeout, "no publisher of " + options_.topic);
    }
  };
  fault_ = "no reading received yet";
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
  logged_ = false;
  fault_ = "not subscribed";
}

void Source::OnTimeJumped() {
  stamps_.Forget();
  last_refused_.reset();
}

void Source::AwaitNext() {
  silence_ = dependencies_.clock.At(dependencies_.clock.Now() + options_.silence, [this] {
    transport::EventLoop& loop = dependencies_.node.loop();
    silence_ = loop.At(loop.Now() + kGrace, [this] {
      silence_.reset();
      const std::string silent =
          "silent for " + std::to_string(ToMilliseconds(options_.silence)) + " ms";
      ReportFault(KeyCode::kTimeout, wrong_stamp_.empty()
                                         ? silent
                                         : silent + ", its readings are refused: " + wrong_stamp_);
    });
  });
}

bool Source::Take(const Result<>& validated, const msg::Header& header) {
  const Time now = dependencies_.clock.Now();
  if (!validated) {
    AwaitNext();
    ++refused_;
    last_refused_ = now;
    ReportFault(KeyCode::kDeviceError, "its readings are refused: " + validated.error().message);
    return false;
  }
  const Result<> timely =
      stamps_.Take(msg::FromStamp(header.stamp), msg::FromStamp(dependencies_.stamp()));
  if (!timely) {
    // As if it had not been received: late ones may be caused by this subscriber.
    ++refused_;
    wrong_stamp_ = timely.error().message;
    return false;
  }
  AwaitNext();
  wrong_stamp_.clear();
  fault_.clear();
  // One good reading among invalid ones is no recovery worth a line.
  if (logged_ && !(last_refused_ && now - *last_refused_ < options_.silence)) {
    logged_ = false;
    const std::uint64_t refused = refused_ - std::exchange(refused_before_, refused_);
    dependencies_.log(
        options_.name + ": ok again" +
        (refused > 0 ? ", " + std::to_string(refused) + " readings were refused" : ""));
  }
  return true;
}

void Source::ReportFault(KeyCode key, const std::string& fault) {
  fault_ = fault;
  if (std::exchange(logged_, true)) return;
  const std::int32_t code = CodeOf(options_.kind, key);
  dependencies_.log(options_.name + ": " + WithCode(fault, code));
  dependencies_.report(code);
}

}  // namespace musher::sensor
