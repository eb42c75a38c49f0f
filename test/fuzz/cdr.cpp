// Untrusted samples of every message; the first byte selects the message. A sample that decodes is
// a value: encoded and decoded again it is the same.

#include "musher/messages/cdr.hpp"

#include <vector>

#include "musher/messages/interfaces.hpp"
#include "musher/test/fuzz/fuzz.hpp"

namespace musher::msg {
namespace {

template <class M>
void RoundTrip(std::span<const std::byte> bytes) {
  const auto message = Decode<M>(bytes);
  if (!message) return;
  // Compares bytes, since floating-point fields may be NaN.
  const Bytes once = Encode(*message);
  const auto again = Decode<M>(once);
  fuzz::Require(again.has_value(), "an encoded value decodes");
  fuzz::Require(Encode(*again) == once, "a round trip changes nothing");
}

using Trip = void (*)(std::span<const std::byte>);

struct Trips {
  template <class M>
  void Message() {
    all.push_back(RoundTrip<M>);
  }
  template <class S>
  void Service() {
    all.push_back(RoundTrip<typename S::Request>);
    all.push_back(RoundTrip<typename S::Response>);
  }
  template <class A>
  void Action() {
    Message<typename A::FeedbackMessage>();
    Service<typename A::SendGoal>();
    Service<typename A::GetResult>();
  }

  std::vector<Trip> all{RoundTrip<RequestId>};
};

const std::vector<Trip>& AllTrips() {
  static const std::vector<Trip> kAll = [] {
    Trips trips;
    VisitInterfaces(trips);
    return trips.all;
  }();
  return kAll;
}

}  // namespace
}  // namespace musher::msg

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto& trips = musher::msg::AllTrips();
  trips[data[0] % trips.size()](std::as_bytes(std::span(data + 1, size - 1)));
  return 0;
}
