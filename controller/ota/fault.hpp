#pragma once
// Why a bundle is not taken: each reason has a code of its own, in CyberDog's module for upgrades.

#include <cstdint>
#include <string>

#include "musher/lifecycle/code.hpp"
#include "musher/lifecycle/result.hpp"

namespace musher::ota {

enum class Fault : std::int32_t {  // keys of the module OTA
  kUnsigned = 21,                  // there is no signature
  kWrongSignature,                 // another key, or the manifest was altered after it was signed
  kBadManifest,                    // it cannot be read, or says what no manifest may say
  kUnknownFormat,                  // a newer musher made it
  kBadPath,                        // a file that would lie outside, or twice at the same place
  kMissing,                        // a listed file is not there
  kAltered,                        // a file is not the one that was signed
  kExtra,                          // a file that is not listed
  kOtherRobot,                     // made for a robot of another name
  kNotNewer,                       // older than what the robot has, or the same
  kTooFar,                         // it needs a newer version than the robot has
  kNoSpace,                        // it does not fit
  kGoneBack,                       // it was tried, and the robot went back
  kNoVersion,                      // neither slot holds a version that may be started
};

inline Error Refusal(Fault fault, std::string message) {
  return {static_cast<std::int32_t>(ModuleCode::kOta) + static_cast<std::int32_t>(fault),
          std::move(message)};
}
constexpr bool Is(const Error& error, Fault fault) {
  return error.code ==
         static_cast<std::int32_t>(ModuleCode::kOta) + static_cast<std::int32_t>(fault);
}

}  // namespace musher::ota
