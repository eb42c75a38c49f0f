#pragma once
// Saves and restores the fields of a state or of an application's data, by name. The same function
// does both:
//
//   void Persist(Archive& archive) override {
//     archive.Field("greeted", greeted_);
//     archive.Field("lost_for", lost_for_);
//   }
//
// A saving archive reads the value; a restoring one sets it, and leaves it unchanged where it has
// none.

#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "musher/base/time.hpp"

namespace musher::fsm {

class Archive {
 public:
  virtual ~Archive() = default;

  virtual void Field(std::string_view name, bool& value) = 0;
  virtual void Field(std::string_view name, std::int64_t& value) = 0;
  virtual void Field(std::string_view name, double& value) = 0;
  virtual void Field(std::string_view name, std::string& value) = 0;

  void Field(std::string_view name, Duration& value) {
    std::int64_t ns = value.count();
    Field(name, ns);
    value = Duration(ns);
  }
  template <class E>
  requires std::is_enum_v<E>
  void Field(std::string_view name, E& value) {
    auto number = static_cast<std::int64_t>(value);
    Field(name, number);
    value = static_cast<E>(number);
  }
};

}  // namespace musher::fsm
