#pragma once
// The bytes of a message with random values, by the layout of its type. A service's request or
// response has the id 0. No number is NaN, and no sequence is long: JSON has the whole message.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <utility>

#include "musher/messages/cdr.hpp"
#include "musher/view/json/message_layout.hpp"

namespace musher::view {

class RandomMessage {
 public:
  RandomMessage(MessageLayout layout, unsigned seed) : layout_(std::move(layout)), random_(seed) {}

  msg::Bytes Make() {
    if (layout_.envelope) writer_.Put(msg::RequestId{});
    Message(0);
    return std::move(writer_).Take();
  }

 private:
  template <class T>
  void Number() {
    const std::uint64_t bits = random_();
    T value{};
    std::memcpy(&value, &bits, sizeof value);
    writer_.Put(value);
  }
  double Real() { return static_cast<double>(random_() % 2'000'001) / 1000 - 1000; }
  void Message(std::size_t type) {
    if (layout_.types[type].empty()) writer_.Put(std::uint8_t{0});
    for (const MessageField& field : layout_.types[type]) {
      const std::size_t count =
          field.sequence ? random_() % 4 : std::max<std::size_t>(1, field.length);
      if (field.sequence) writer_.Put(static_cast<std::uint32_t>(count));
      for (std::size_t i = 0; i < count; ++i) One(field);
    }
  }
  void One(const MessageField& field) {
    switch (field.kind) {
      case FieldKind::kBool:
        return writer_.Put(random_() % 2 == 1);
      case FieldKind::kInt8:
        return Number<std::int8_t>();
      case FieldKind::kUint8:
        return Number<std::uint8_t>();
      case FieldKind::kInt16:
        return Number<std::int16_t>();
      case FieldKind::kUint16:
        return Number<std::uint16_t>();
      case FieldKind::kInt32:
        return Number<std::int32_t>();
      case FieldKind::kUint32:
        return Number<std::uint32_t>();
      case FieldKind::kInt64:
        return Number<std::int64_t>();
      case FieldKind::kUint64:
        return Number<std::uint64_t>();
      case FieldKind::kFloat32:
        return writer_.Put(static_cast<float>(Real()));
      case FieldKind::kFloat64:
        return writer_.Put(Real());
      case FieldKind::kString:
        return writer_.Put(std::string(random_() % 9, 'a') + "\"\n");
      case FieldKind::kMessage:
        return Message(field.type);
    }
  }

  const MessageLayout layout_;
  std::mt19937_64 random_;
  msg::CdrWriter writer_;
};

}  // namespace musher::view
