#pragma once
// The fields of a message and of the types that it consists of, read from its definition
// (messages/definitions.hpp). Pure; threads: any.

#include <cstddef>
#include <string>
#include <vector>

#include "musher/messages/definitions.hpp"

namespace musher::view {

enum class FieldKind {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,
  kMessage,
};

struct MessageField {
  std::string name;
  FieldKind kind = FieldKind::kUint8;
  std::size_t type = 0;    // of a kMessage: its index in MessageLayout::types
  bool sequence = false;   // of any length
  std::size_t length = 0;  // of an array; 0: it is none
};

struct MessageLayout {
  std::vector<std::vector<MessageField>> types;  // the message itself first
  bool envelope = false;                         // see MessageDefinition
  std::size_t appended = 0;
};

MessageLayout LayoutOf(const msg::MessageDefinition& definition);

}  // namespace musher::view
