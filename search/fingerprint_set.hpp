#pragma once
// A set of fingerprints that only grows: 16 bytes for each place, of which at most three quarters
// are used, without an allocation for each. It consists of many parts, and each grows alone: while
// one is moved to twice its places, the others need no more memory.

#include <array>
#include <utility>
#include <vector>

#include "musher/search/fingerprint.hpp"

namespace musher::search {

class FingerprintSet {
 public:
  // Returns whether it was new.
  bool Insert(const Fingerprint& fingerprint) {
    const bool is_new = parts_[fingerprint.high % kParts].Insert(fingerprint);
    size_ += is_new ? 1 : 0;
    return is_new;
  }

  std::size_t size() const { return size_; }

 private:
  static constexpr std::size_t kParts = 256;
  static constexpr std::size_t kFirstPlaces = 16;  // a power of two

  class Part {
   public:
    bool Insert(const Fingerprint& fingerprint) {
      if (4 * (size_ + 1) > 3 * places_.size()) Grow();
      // The empty place is all zeros, and so might one fingerprint in 2^128 be.
      Fingerprint& place = PlaceOf(fingerprint);
      if (place == fingerprint) return false;
      place = fingerprint;
      ++size_;
      return true;
    }

   private:
    Fingerprint& PlaceOf(const Fingerprint& fingerprint) {
      const std::size_t mask = places_.size() - 1;
      std::size_t i = static_cast<std::size_t>(fingerprint.low) & mask;
      while (places_[i] != Fingerprint{} && places_[i] != fingerprint) i = (i + 1) & mask;
      return places_[i];
    }

    void Grow() {
      const std::size_t places = places_.empty() ? kFirstPlaces : 2 * places_.size();
      const std::vector<Fingerprint> before =
          std::exchange(places_, std::vector<Fingerprint>(places));
      for (const Fingerprint& fingerprint : before) {
        if (fingerprint != Fingerprint{}) PlaceOf(fingerprint) = fingerprint;
      }
    }

    std::vector<Fingerprint> places_;
    std::size_t size_ = 0;
  };

  std::array<Part, kParts> parts_;
  std::size_t size_ = 0;
};

}  // namespace musher::search
