#pragma once
// Why a bundle is refused: each reason has a code of its own, in CyberDog's module for upgrades.

#include <cstdint>
#include <string>

#include "musher/base/code.hpp"
#include "musher/base/result.hpp"

namespace musher::ota {

enum class Fault : std::int32_t {  // keys of the module OTA
  kUnsigned = 21,                  // no signature
  kWrongSignature,                 // signed with another key, or altered after signing
  kBadManifest,                    // unreadable or invalid manifest
  kUnknownFormat,                  // made by a newer musher
  kBadPath,                        // a file outside of the slot, or listed twice
  kMissing,                        // a listed file is missing
  kAltered,                        // a file differs from the signed one
  kExtra,                          // a file that is not listed
  kOtherRobot,                     // for a robot of another name
  kNotNewer,                       // older than the robot's version, or the same
  kTooFar,                         // needs a newer version than the robot has
  kNoSpace,                        // not enough disk space
  kRolledBack,                     // the trial boot failed, and the robot rolled back
  kNoVersion,                      // neither slot has a version that can be started
};

inline Error FaultError(Fault fault, std::string message) {
  return {static_cast<std::int32_t>(ModuleCode::kOta) + static_cast<std::int32_t>(fault),
          std::move(message)};
}
constexpr bool Is(const Error& error, Fault fault) {
  return error.code ==
         static_cast<std::int32_t>(ModuleCode::kOta) + static_cast<std::int32_t>(fault);
}

}  // namespace musher::ota
