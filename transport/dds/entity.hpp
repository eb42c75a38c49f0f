#pragma once
// The sole owner of a Cyclone entity. Before it deletes the entity it removes the listener, which
// waits for running callbacks: nothing that they use may be destroyed before, and no lock that they
// take may be held.

#include <dds/dds.h>

#include <string>
#include <utility>

#include "musher/base/result.hpp"

namespace musher::transport::dds {

class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Entity() { Delete(); }

  void Delete() {
    if (handle_ <= 0) return;
    dds_set_listener(handle_, nullptr);
    dds_delete(std::exchange(handle_, 0));
  }

  dds_entity_t get() const { return handle_; }

 private:
  dds_entity_t handle_ = 0;
};

// `what` failed with Cyclone's return code.
inline Error DdsError(const std::string& what, dds_return_t code) {
  const auto number = code == DDS_RETCODE_TIMEOUT                   ? kCodeTimeout
                      : code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY ? kCodePermissionDenied
                                                                    : kCodeNetError;
  return {number, what + ": " + dds_strretcode(code)};
}

}  // namespace musher::transport::dds
